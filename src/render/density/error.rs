//! Errors of meshes and of density measurements.

use crate::eval::ExactError;
use crate::render::error::RenderError;
use crate::render::variant::VariantError;

/// Error of a mesh or a density measurement.
#[derive(Debug, thiserror::Error)]
pub enum PolygonizeError {
    /// The scene has no program.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The program cannot be evaluated.
    #[error("the density of this scene cannot be evaluated: {0}")]
    Exact(#[from] ExactError),
    /// The grid is out of range.
    #[error("grid {0}: not in 8 to 512; 64 to 256 suit most objects")]
    Grid(u32),
    /// The density is out of range.
    #[error("density {0}: not above 0 and up to 1; 0.5 suits most objects")]
    Density(f32),
    /// The mesh needs more memory than there is.
    #[error("the mesh needs about {} MiB of memory, of {} MiB; choose coarser samples", needed >> 20, most >> 20)]
    Memory {
        /// Bytes that it needs.
        needed: u64,
        /// Bytes that it may use.
        most: u64,
    },
    /// No sample is inside.
    #[error("no sample has a density of {level}: {}lower it, or take more samples", match *largest > 0.0 {
        true => format!("the largest is {largest:.3}; "),
        false => String::new(),
    })]
    NoSurface {
        /// Requested density.
        level: f64,
        /// Largest density of a sample, except where bounds prove that all are lower.
        largest: f64,
    },
}

impl From<VariantError> for PolygonizeError {
    fn from(error: VariantError) -> PolygonizeError {
        PolygonizeError::Render(error.into())
    }
}
