//! What the points of a lattice have, of each noise that shaders compute in place.
//!
//! Role: by lattice point, the directions and values that `glsl/` computes or looks up in tables. Invariant: they are those
//! of the shader, to the roundings of f32.

use super::lattice::direction;
use super::table::Noise;
use super::{NOISE_BOUND, NOISE_GRADIENT_BOUND, SEED, Weights};
use std::sync::LazyLock;

/// The slope of a value that fades into another: the weights change by 1.875 per cell at most.
const STEEPEST_OF_VALUES: f64 = 1.875 * 2.0 * NOISE_BOUND;

static TABLES: LazyLock<Noise> = LazyLock::new(|| Noise::new(SEED, Weights::Quintic));

/// What the points of a lattice have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knots {
    /// Directions from a hash, which repeat after so many cells, a power of two: `glsl/lattice_noise.glsl`.
    Hashed(u32),
    /// Directions from the tables of 1989: `glsl/array_noise.glsl` and `glsl/table_noise.glsl`.
    Tables,
    /// Values from a hash: `glsl/noise/wavelet.glsl`.
    Values,
}

impl Knots {
    /// Those that a level of a lookup stands for: the period of a hash, 0 for the tables, or less for values.
    pub fn of_level(level: f64) -> Knots {
        match level {
            1.0.. => Knots::Hashed(level as u32),
            0.0.. => Knots::Tables,
            _ => Knots::Values,
        }
    }

    /// The noise at a lattice point and its gradient there, as if no other point had any.
    pub(super) fn at(self, cell: [u32; 3]) -> [f64; 4] {
        let [x, y, z] = match self {
            Knots::Hashed(period) => direction(cell, period),
            Knots::Tables => TABLES.knot(cell.map(|c| c as usize & 255)),
            Knots::Values => {
                let part = f64::from(hash(cell)) / f64::from(u32::MAX);
                return [3f64.sqrt() * (part - 0.5), 0.0, 0.0, 0.0];
            }
        };
        [0.0, x, y, z]
    }

    /// The gradient of the noise never exceeds this along an axis, per lattice cell.
    pub fn steepest(self) -> f64 {
        if self == Knots::Values { STEEPEST_OF_VALUES } else { NOISE_GRADIENT_BOUND }
    }
}

/// The first number of `glsl/hash.glsl`.
fn hash(cell: [u32; 3]) -> u32 {
    let [mut x, mut y, mut z] = cell.map(|c| c.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    x = x.wrapping_add(y.wrapping_mul(z));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    let [x, y, z] = [x, y, z].map(|c| c ^ c >> 16);
    x.wrapping_add(y.wrapping_mul(z))
}
