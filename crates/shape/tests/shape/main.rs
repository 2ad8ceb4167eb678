//! Shapes: readers and writers of meshes and volumes, refusals and their messages.

#![allow(clippy::unwrap_used, reason = "a test fails where a file is not as described")]

mod bytes;
mod data;
mod dicom;
mod fog;
mod gltf;
mod links;
mod meta;
mod nifti;
mod nrrd;
mod odd;
mod orientation;
mod packed;
mod paint;
mod ply;
mod raw;
mod strange;
mod strangers;
mod threemf;
mod vdb;
mod vdb_versions;
mod vdb_write;
mod write;
mod write_mesh;
