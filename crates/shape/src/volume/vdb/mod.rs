//! OpenVDB: sparse level sets and fog volumes.

mod blosc;
mod grid;
mod grids;
pub(crate) mod header;
pub(crate) mod metadata;
mod tree;
pub(crate) mod values;

pub(crate) use grids::read;
pub(crate) use header::recognizes;
