//! Shapes: readers and writers of meshes and volumes, refusals and their messages.

#[path = "../common/random_scene.rs"]
mod random_scene;

mod along;
mod data;
mod dicom;
mod field_data;
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
mod polygons;
mod raw;
mod strange;
mod turned;
mod vdb;
mod vdb_versions;
mod vdb_write;
mod write;
mod write_mesh;
