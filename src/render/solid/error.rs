//! Errors of solids.

use crate::eval::ExactError;
use crate::render::density::PolygonizeError;

/// Error of a solid.
#[derive(Debug, thiserror::Error)]
pub enum SolidError {
    /// The density gives no surface.
    #[error(transparent)]
    Polygonize(#[from] PolygonizeError),
    /// The tolerance is out of range.
    #[error("tolerance {tolerance}: not from {least} to {most}, in the unit of the object")]
    Tolerance {
        /// The tolerance.
        tolerance: f64,
        /// Least one: below it, coordinates of 32 bits or numbers of samples do not hold the surface.
        least: f64,
        /// Greatest one.
        most: f64,
    },
    /// The number of triangles is out of range.
    #[error("triangles {0}: not in 100 to 10000000")]
    Triangles(usize),
    /// The mesh needs more memory than there is.
    #[error(
        "tolerance {tolerance}: needs about {} MiB of memory, and {} MiB may be used; {fits} would fit", needed >> 20, most >> 20
    )]
    Memory {
        /// The tolerance.
        tolerance: f64,
        /// Bytes that it needs.
        needed: u64,
        /// Bytes that may be used.
        most: u64,
        /// A tolerance that fits.
        fits: f64,
    },
}

impl From<ExactError> for SolidError {
    fn from(error: ExactError) -> SolidError {
        SolidError::Polygonize(error.into())
    }
}
