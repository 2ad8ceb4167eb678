//! Errors of linking the program of a scene.

use super::reflect::ReflectError;
use crate::scene::SceneError;
use crate::shader::{LibraryError, LinkError};

/// Error of linking the program of a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VariantError {
    /// The scene is not valid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A length with a unit in a scene whose object has not been met.
    #[error("{0} = {1}: the size of the object is unknown; `render::settle_lengths` sets the lengths of a scene")]
    Length(String, String),
    /// A module is missing.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// The program cannot be linked.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The linked program cannot be reflected.
    #[error(transparent)]
    Reflect(#[from] ReflectError),
}
