//! Errors of meshes and of other measurements of density.

use crate::eval::ExactError;
use crate::render::error::RenderError;
use crate::render::variant::VariantError;

/// Why there is no mesh.
#[derive(Debug, thiserror::Error)]
pub enum PolygonizeError {
    /// The scene has no program.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The program cannot be evaluated.
    #[error("no mesh of this scene: {0}")]
    Exact(#[from] ExactError),
    /// The grid is out of range.
    #[error("grid {0}: not in 8 to 512; 64 to 256 suit most objects")]
    Grid(u32),
    /// The density is out of range.
    #[error("density {0}: not above 0 and up to 1; 0.5 suits most objects")]
    Density(f32),
    /// No sample is inside.
    #[error("no sample has a density of {level}: {}lower it, or take more samples", match *largest > 0.0 {
        true => format!("the largest is {largest:.3}; "),
        false => String::new(),
    })]
    NoSurface {
        /// The density that was asked for.
        level: f64,
        /// The largest that a sample has where bounds do not tell that all have less.
        largest: f64,
    },
}

impl From<VariantError> for PolygonizeError {
    fn from(error: VariantError) -> PolygonizeError {
        PolygonizeError::Render(error.into())
    }
}
