//! Grids of samples in object space.

use glam::DVec3;

/// Place of anchored samples in their cells, so that faces of common objects meet none.
const OFFSET: DVec3 = DVec3::new(0.381_966, 0.236_068, 0.445_042);
/// Most samples of a grid: their numbers fit 32 bits.
const MOST_SAMPLES: f64 = u32::MAX as f64;

/// A grid of samples with an outside layer around it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lattice {
    /// Samples on each axis.
    pub size: [u32; 3],
    /// Place of the first sample, object space.
    pub low: DVec3,
    /// Distance between samples, object units.
    pub step: f64,
}

impl Lattice {
    /// A number of samples along the longest side of a box, with one layer outside of it.
    pub fn around(low: DVec3, high: DVec3, samples: u32) -> Lattice {
        let extent = high - low;
        let step = extent.max_element() / f64::from(samples - 3);
        let size = extent.to_array().map(|side| (side / step - 1e-9).ceil().max(1.0) as u32 + 3);
        let spare = DVec3::from_array(size.map(|side| f64::from(side - 1))) * step - extent;
        Lattice { size, low: low - 0.5 * spare, step }
    }

    /// Samples at fixed places of multiples of `step`, around a box, so that scenes of one object share them; `None` for more than 2^32.
    pub fn anchored(low: DVec3, high: DVec3, step: f64) -> Option<Lattice> {
        let (first, last) = ((low / step - OFFSET).floor() - 1.0, (high / step - OFFSET).ceil() + 1.0);
        let size = last - first + 1.0;
        (size.element_product() <= MOST_SAMPLES).then(|| Lattice {
            size: size.to_array().map(|side| side as u32),
            low: (first + OFFSET) * step,
            step,
        })
    }

    /// Place of a sample, object space.
    pub fn place(&self, at: [u32; 3]) -> DVec3 {
        self.low + self.step * DVec3::from_array(at.map(f64::from))
    }

    /// The sample of a number, x fastest.
    pub fn of_index(&self, index: u32) -> [u32; 3] {
        let [x, y, _] = self.size;
        [index % x, index / x % y, index / x / y]
    }

    /// Whether a sample is on the grid, and not at its border.
    pub fn is_within(&self, at: [u32; 3]) -> bool {
        (0..3).all(|axis| at[axis] > 0 && at[axis] + 1 < self.size[axis])
    }
}
