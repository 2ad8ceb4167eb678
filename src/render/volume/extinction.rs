//! Extinction of voxels: the scene's opacity rate times the factor of its medium times -ln(1 - density) (PH 3.1).

use super::leaf::VoxelLeaf;
use serde::Serialize;

/// Largest optical depth of a voxel: what passes a voxel beyond it is below 1e-6, and trackers of other programs take steps by
/// the largest extinction of a volume.
const MAX_DEPTH: f64 = 16.0;
/// Largest finite number in 16 bits.
const MAX_HALF: f64 = 65504.0;
/// Densities at which the factor of the extinction is measured: the quotient keeps five digits there.
const MEASURED_DENSITIES: [f32; 2] = [0.02, 0.98];
/// Relative spread of factors of one value, by rounding.
const FLAT_SPREAD: f64 = 2e-4;

/// Extinction of the voxels with matter, per world unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct VoxelExtinction {
    /// Largest value of a voxel.
    pub largest: f64,
    /// Limit of the values: an optical depth of 16 in a voxel. Hard matter, of infinite extinction, has this value.
    pub limit: f64,
    /// Number of voxels at the limit.
    pub limited: u64,
    /// Lowest and highest quotient of the extinction and -ln(1 - density); `None` if no voxel has a density of 0.02 to 0.98.
    pub factor: Option<[f64; 2]>,
}

impl VoxelExtinction {
    /// Without voxels, for voxels of a side in world units.
    pub(super) fn new(step: f64, is_half: bool) -> VoxelExtinction {
        let limit = (MAX_DEPTH / step).min(if is_half { MAX_HALF } else { f64::from(f32::MAX) });
        VoxelExtinction { largest: 0.0, limit, limited: 0, factor: None }
    }

    /// The quotient of the extinction and -ln(1 - density), if the medium has only one.
    pub fn constant_factor(&self) -> Option<f64> {
        let [low, high] = self.factor?;
        (high - low <= FLAT_SPREAD * high).then_some(0.5 * (low + high))
    }

    /// Turns the extinction of a leaf from object units into world units, of which `scale` gives the number of object units, limits
    /// it and takes it into account.
    pub(super) fn add(&mut self, leaf: &mut VoxelLeaf, scale: f64) {
        for ([.., density], own) in leaf.voxels.iter().zip(&mut leaf.extinctions) {
            if *density <= 0.0 {
                *own = 0.0;
                continue;
            }
            let exact = if *density >= 1.0 { f64::INFINITY } else { scale * f64::from(*own) };
            if *own > 0.0 && (MEASURED_DENSITIES[0]..=MEASURED_DENSITIES[1]).contains(density) {
                let factor = exact / -f64::from(-*density).ln_1p();
                let [low, high] = self.factor.unwrap_or([factor; 2]);
                self.factor = Some([low.min(factor), high.max(factor)]);
            }
            if own.is_nan() {
                continue; // refused as not finite
            }
            self.limited += u64::from(exact >= self.limit);
            *own = exact.min(self.limit) as f32;
            self.largest = self.largest.max(exact.min(self.limit));
        }
    }
}
