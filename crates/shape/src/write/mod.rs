//! Writers of meshes and volumes.

mod mesh;
mod nifti;
mod values;
mod vdb;
mod volume;

pub use mesh::MeshFormat;
pub use vdb::{Fog, FogGrid, FogLeaf};
pub use volume::VolumeFormat;
