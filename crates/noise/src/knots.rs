//! Values and gradients at lattice points, of each noise that shaders compute in place.
//!
//! Invariant: they equal those of `glsl/` up to f32 rounding.

use super::table::{Noise, SEED};
use super::weights::{NOISE_BOUND, NOISE_GRADIENT_BOUND, Weights};
use std::sync::LazyLock;

/// Gradient bound of value noise. The slope of the weights is at most 1.875 per cell.
const VALUE_GRADIENT_BOUND: f64 = 1.875 * 2.0 * NOISE_BOUND;

/// Components of the 24 directions (a, a, c), in every order and with every sign. 2 a^2 + c^2 = 1 and 2 a^4 + c^4 = 3 / 5 give
/// them the moments of the sphere up to the fifth order.
const MINOR: f64 = 0.350_021_174_581_540_7;
const MAJOR: f64 = 0.868_890_300_722_201_2;
/// Hash values that divide the three orders.
const THIRDS: [u32; 2] = [0x5555_5555, 0xaaaa_aaaa];
const STRIDE: [u32; 3] = [0x8da6_b343, 0xd816_3841, 0xcb1a_b31f];
/// The 24 directions, by the axis of the major component and by signs, x first.
const DIRECTIONS: [[[f64; 3]; 8]; 3] = {
    let mut found = [[[0.0; 3]; 8]; 3];
    let mut index = 0;
    while index < 72 {
        let (major, signs, axis) = (index / 24, index / 3 % 8, index % 3);
        let size = if axis == major { MAJOR } else { MINOR };
        found[major][signs][axis] = if signs >> axis & 1 == 1 { -size } else { size };
        index += 1;
    }
    found
};

static TABLES: LazyLock<Noise> = LazyLock::new(|| Noise::new(SEED, Weights::Quintic));

/// A kind of lattice noise, by its values and gradients at lattice points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knots {
    /// Hashed directions with a period in cells, a power of two: `glsl/lattice_noise.glsl`.
    Hashed(u32),
    /// Directions from the tables of 1989: `glsl/array_noise.glsl` and `glsl/table_noise.glsl`.
    Tables,
    /// Hashed values: `glsl/noise/wavelet.glsl`.
    Values,
}

impl Knots {
    /// The knots that the level of an image lookup encodes: the period of a hash, 0 for tables, negative for values.
    pub fn of_level(level: f64) -> Knots {
        match level {
            1.0.. => Knots::Hashed(level as u32),
            0.0.. => Knots::Tables,
            _ => Knots::Values,
        }
    }

    /// Value and gradient at a lattice point.
    pub(super) fn at(self, cell: [u32; 3]) -> [f64; 4] {
        let [x, y, z] = match self {
            Knots::Hashed(period) => direction(cell, period),
            Knots::Tables => TABLES.knot(cell.map(|c| c as usize & 255)),
            Knots::Values => {
                let part = f64::from(value_hash(cell)) / f64::from(u32::MAX);
                return [3f64.sqrt() * (part - 0.5), 0.0, 0.0, 0.0];
            }
        };
        [0.0, x, y, z]
    }

    /// Bound of the gradient along an axis, per lattice cell.
    pub fn steepest(self) -> f64 {
        if self == Knots::Values { VALUE_GRADIENT_BOUND } else { NOISE_GRADIENT_BOUND }
    }
}

/// The first component of the hash in `glsl/hash.glsl`.
fn value_hash(cell: [u32; 3]) -> u32 {
    let [mut x, mut y, mut z] = cell.map(|c| c.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    x = x.wrapping_add(y.wrapping_mul(z));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    let [x, y, z] = [x, y, z].map(|c| c ^ c >> 16);
    x.wrapping_add(y.wrapping_mul(z))
}

/// Hash of a cell that repeats after `period` cells, a power of two.
fn hash(cell: [u32; 3], period: u32) -> u32 {
    let strides = cell.map(|c| c & (period - 1)).into_iter().zip(STRIDE);
    let h = strides.fold(0, |h, (c, stride)| h ^ c.wrapping_mul(stride)).wrapping_mul(0x27d4_eb2d);
    h ^ (h >> 15)
}

/// Direction of a lattice point.
pub(super) fn direction(cell: [u32; 3], period: u32) -> [f64; 3] {
    let h = hash(cell, period);
    let major = usize::from(h >= THIRDS[0]) + usize::from(h >= THIRDS[1]);
    DIRECTIONS[major][h as usize & 7]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions() -> impl Iterator<Item = ([u32; 3], [f64; 3])> {
        let cells = (0..48).flat_map(|i| (0..48).flat_map(move |j| (0..48).map(move |k| [i, j, k])));
        cells.map(|cell| (cell, direction(cell, 1 << 20)))
    }

    #[test]
    fn p18_directions_have_the_moments_of_the_sphere() {
        assert!((2.0 * MINOR.powi(2) + MAJOR.powi(2) - 1.0).abs() < 1e-15);
        assert!((2.0 * MINOR.powi(4) + MAJOR.powi(4) - 0.6).abs() < 1e-15, "3 E[x^4] of the sphere");
        let (mut first, mut second, mut fourth) = ([0.0; 3], [0.0; 6], [0.0; 2]);
        for (_, g) in directions() {
            for a in 0..3 {
                let b = (a + 1) % 3;
                first[a] += g[a];
                second[a] += g[a] * g[a] - 1.0 / 3.0;
                second[3 + a] += g[a] * g[b];
                fourth[0] += g[a].powi(4) / 3.0 - 1.0 / 15.0;
                fourth[1] += (g[a] * g[b]).powi(2) / 3.0 - 1.0 / 45.0;
            }
        }
        // 110 592 directions: a mean of uncorrelated ones has a standard deviation below 0.0018.
        let all = first.into_iter().chain(second).chain(fourth).map(|sum| sum / 48f64.powi(3));
        assert!(all.clone().all(|mean| mean.abs() < 0.006), "{:?}", all.collect::<Vec<_>>());
    }

    #[test]
    fn p19_neighboring_directions_are_not_correlated() {
        for step in (0..125u32).map(|i| [i % 5, i / 5 % 5, i / 25].map(|c| c.wrapping_sub(2))).filter(|s| *s != [0; 3])
        {
            let (mut sum, mut count) = (0.0, 0.0);
            for (cell, a) in directions() {
                let b = direction(std::array::from_fn(|c| cell[c].wrapping_add(step[c])), 1 << 20);
                sum += (0..3).map(|c| a[c] * b[c]).sum::<f64>();
                count += 1.0;
            }
            assert!((sum / count).abs() < 0.02, "{step:?}: {}", sum / count);
        }
    }
}
