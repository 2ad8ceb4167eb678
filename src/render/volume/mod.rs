//! The density, color and extinction of a scene on a sparse grid of voxels.

mod error;
mod extinction;
mod fit;
mod grids;
mod leaf;
mod media;
mod plan;
mod voxelize;

pub use error::VoxelError;
pub use extinction::VoxelExtinction;
pub use fit::VoxelFit;
pub use grids::VoxelGrids;
pub use leaf::VoxelLeaf;
pub use media::lit_media;
pub use plan::VoxelPlan;
pub use voxelize::{VoxelReport, voxelize};
