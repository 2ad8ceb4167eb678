//! Texels that the device samples.

mod blocks;
mod bricks;
mod codes;
mod tables;
mod transfer;
mod volume;

pub use blocks::{Depth, block_channels, block_gradients, block_scales, block_values, table_rows, texels_of};
pub use bricks::{BRICK, Bricks};
pub use tables::{SEGMENT_SIZE, classify, segment_table};
pub use transfer::{evaluate, index_map, transfer_map, transfer_texel};
pub use volume::{Encoding, Texels, encode, encode_closest};
