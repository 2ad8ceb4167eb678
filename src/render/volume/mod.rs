//! The density and color of a scene on a sparse grid of voxels.

mod error;
mod fit;
mod grids;
mod leaf;
mod plan;
mod voxelize;

pub use error::VoxelError;
pub use fit::VoxelFit;
pub use grids::VoxelGrids;
pub use leaf::VoxelLeaf;
pub use plan::VoxelPlan;
pub use voxelize::{VoxelReport, voxelize};
