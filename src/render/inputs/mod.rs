//! Inputs of a program: uniforms, images and samplers.

mod bricks;
mod cpu_inputs;
mod device_blocks;
mod encoded;
mod images;
mod noise_blocks;
mod object_inputs;
mod table;
mod uniforms;

pub use bricks::Sparse;
pub use cpu_inputs::CpuInputs;
pub(crate) use cpu_inputs::{texture, wrap};
pub(crate) use device_blocks::{apart, block_image};
pub use encoded::ImageInfo;
pub(crate) use encoded::{Encoded, Filter};
pub(crate) use images::{Inputs, StoredObjects, groom_image, image_key};
pub(crate) use uniforms::{Values, blocks, blocks_at};
