//! Voxels of a part of the grid.

use crate::shape::FogLeaf;

/// Leaf of 8^3 voxels.
pub struct VoxelLeaf {
    /// First voxel.
    pub corner: [u32; 3],
    /// Color, linear RGB, and density in \[0, 1\] of each voxel, in the order of [`FogLeaf::index`]. Without light, except that
    /// of a flame's own relief: lit matter has its material color.
    pub voxels: Vec<[f32; 4]>,
    /// Extinction of each voxel per world unit, up to [`VoxelExtinction::limit`](super::VoxelExtinction::limit).
    pub extinctions: Vec<f32>,
}

impl VoxelLeaf {
    pub(super) fn has_matter(&self) -> bool {
        self.voxels.iter().any(|[.., density]| *density > 0.0)
    }

    pub(super) fn not_finite(&self) -> Option<[u32; 3]> {
        let index = self.voxels.iter().position(|voxel| voxel.iter().any(|part| !part.is_finite()));
        let index = index.or_else(|| self.extinctions.iter().position(|extinction| !extinction.is_finite()))?;
        let within = FogLeaf::at(index);
        Some([0, 1, 2].map(|axis| self.corner[axis] + within[axis]))
    }
}
