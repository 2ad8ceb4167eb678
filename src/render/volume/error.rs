//! Errors of voxels.

use crate::eval::ExactError;
use crate::render::density::PolygonizeError;
use crate::render::error::RenderError;
use crate::render::variant::VariantError;
use std::io;

/// Error of a volume of voxels.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VoxelError {
    /// The density cannot be evaluated.
    #[error(transparent)]
    Density(#[from] PolygonizeError),
    /// A pass on the device failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The grid is out of range.
    #[error("grid {0}: not in 8 to 2048; 128 to 512 suit most objects")]
    Grid(u32),
    /// No voxel holds matter.
    #[error(
        "no voxel of {0} x {1} x {2} has a density above 0: nothing to write; take more voxels, or look at the iso-values"
    )]
    Empty(u32, u32, u32),
    /// A voxel is not finite.
    #[error("the density, color or extinction at voxel {0}, {1}, {2} is not finite; {FINITE}", FINITE = crate::render::FINITE)]
    NotFinite(u32, u32, u32),
    /// The voxels cannot be encoded.
    #[error(transparent)]
    Io(#[from] io::Error),
}

impl From<ExactError> for VoxelError {
    fn from(error: ExactError) -> VoxelError {
        VoxelError::Density(error.into())
    }
}

impl From<VariantError> for VoxelError {
    fn from(error: VariantError) -> VoxelError {
        VoxelError::Render(error.into())
    }
}
