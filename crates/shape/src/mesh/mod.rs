//! Formats of meshes, and their materials and textures.

pub(crate) mod gltf;
mod mtl;
pub(crate) mod obj;
pub(crate) mod ply;
mod polygon;
pub(crate) mod stl;
mod textures;
pub(crate) mod threemf;
