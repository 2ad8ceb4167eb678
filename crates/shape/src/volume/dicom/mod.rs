//! DICOM: the slices of a scan, one per file or several in one.

mod deflated;
mod elements;
mod frames;
mod header;
mod image;
mod read;
mod series;

pub(crate) use read::{read, read_folder, recognizes};
