//! OpenVDB: sparse level sets and fog volumes.

mod blosc;
mod fog;
mod grid;
mod grids;
mod header;
mod metadata;
mod tree;
mod values;
mod write;
mod write_grid;
mod write_tree;

pub use fog::{Fog, FogGrid, FogLeaf};
pub(crate) use grids::read;
pub(crate) use header::recognizes;
pub(crate) use write::write;
