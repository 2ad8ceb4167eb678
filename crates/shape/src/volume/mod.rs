//! Formats of volumes, and the placement of their samples in the world.

mod data_files;
mod decompress;
pub(crate) mod dicom;
mod fields;
pub(crate) mod meta;
pub(crate) mod nifti;
pub(crate) mod nrrd;
mod placement;
mod raster;
pub(crate) mod raw;
pub(crate) mod space;
pub(crate) mod vdb;

pub use raw::{RawLayout, open_raw};
