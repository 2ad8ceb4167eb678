//! glTF 2.0: a scene of meshes, as JSON with its data beside or inside it, or both in one binary file (GLB).

mod accessor;
mod buffer;
mod document;
mod material;
mod primitive;
mod read;
mod scene;

pub(crate) use read::{read, recognizes};
