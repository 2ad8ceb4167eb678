//! Texels that the device samples.

mod blocks;
mod bricks;
mod codes;
mod tables;
mod transfer;
mod volume;

pub use blocks::{Depth, block_channels, block_gradients, block_values, table_rows};
pub(crate) use blocks::{block_scales, texels_of};
pub use bricks::{BRICK, Bricks};
pub use tables::classify;
pub(crate) use tables::{SEGMENT_SIZE, segment_table};
pub use transfer::{evaluate, transfer_map};
pub(crate) use transfer::{index_map, transfer_texel};
pub(crate) use volume::encode_closest;
pub use volume::{Encoding, Texels, encode};
