//! OpenVDB: sparse level sets and fog volumes.

mod blosc;
mod grid;
mod grids;
mod header;
mod metadata;
mod tree;
mod values;
mod write;

pub(crate) use grids::read;
pub(crate) use header::recognizes;
pub(crate) use write::write;
