//! Writers of meshes and volumes.

mod checked;
mod mesh;
mod nifti;
mod threemf;
mod values;
mod vdb;
mod volume;

pub use mesh::MeshFormat;
pub use threemf::{PrintBody, PrintFile};
pub use vdb::{Fog, FogGrid, FogLeaf};
pub use volume::VolumeFormat;
