//! The noise of `glsl/lattice_noise.glsl`: directions from an integer hash of the cell; and the same of other [`Knots`].

use super::{Knots, Weights, absolute_sum};

/// Components of the 24 directions (a, a, c) in every order and with every sign: 2 a^2 + c^2 = 1, and with
/// 2 a^4 + c^4 = 3 / 5 the moments up to the fifth order are those of the sphere.
const MINOR: f64 = 0.350_021_174_581_540_7;
const MAJOR: f64 = 0.868_890_300_722_201_2;
/// A third and two thirds of all hashes.
const THIRDS: [u32; 2] = [0x5555_5555, 0xaaaa_aaaa];
const STRIDE: [u32; 3] = [0x8da6_b343, 0xd816_3841, 0xcb1a_b31f];
/// Cells from the origin; beyond, the noise is that of this border. f32 has no fraction left soon after.
pub(super) const FARTHEST: f64 = 1_048_576.0;

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

/// After how many cells the lattice of each octave repeats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Period {
    /// Cells of the first octave, a power of two up to 2^20.
    pub cells: u32,
    /// Whether each octave repeats after twice as many of its cells as the one before: where the first does.
    pub growing: bool,
    /// Octaves after which that begins anew, a power of two: those that one fetch brings.
    pub cycle: u32,
}

impl Period {
    /// No repetition that a picture could show.
    pub const ENDLESS: Period = Period::same(1 << 20);

    /// Every octave repeats after as many of its cells: one block is looked up at all scales.
    pub const fn same(cells: u32) -> Period {
        Period { cells, growing: false, cycle: 16 }
    }

    /// Every octave repeats where the first does: a block holds them all.
    pub const fn growing(cells: u32) -> Period {
        Period { cells, growing: true, cycle: 16 }
    }

    /// Cells of an octave after which it repeats.
    pub fn of_octave(self, octave: u32) -> u32 {
        self.cells << if self.growing { octave & (self.cycle - 1) } else { 0 }
    }
}

/// The noise.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lattice {
    /// How directions fade into each other.
    pub weights: Weights,
}

impl Lattice {
    /// Gradient (per lattice cell) and value of the noise at `p`, in lattice cells.
    ///
    /// The lattice repeats after `period` cells, a power of two. The value lies in [-0.867, 0.867], is 0 at lattice
    /// points and has their direction as its gradient there. Any finite `p`.
    pub fn sample(self, p: [f64; 3], period: u32) -> ([f64; 3], f64) {
        self.sample_of(Knots::Hashed(period), p)
    }

    /// The same of a lattice with these knots. Values are not 0 at lattice points, and their gradient is.
    pub fn sample_of(self, knots: Knots, p: [f64; 3]) -> ([f64; 3], f64) {
        let inside = p.map(|c| c.clamp(-FARTHEST, FARTHEST));
        let base = inside.map(f64::floor);
        let t: [f64; 3] = std::array::from_fn(|axis| inside[axis] - base[axis]);
        let cell = base.map(|c| c as i32 as u32);
        self.weights.interpolate(t, |side| knots.at(std::array::from_fn(|a| cell[a].wrapping_add(side[a] as u32))))
    }

    /// Gradient (per cell of the first octave) and value of the turbulence at `p`: the sum over octaves of
    /// |noise(2^i p)| / 2^i, in [0, 1.733]. The gradient jumps where an octave crosses zero.
    pub fn turbulence(self, p: [f64; 3], period: Period, octaves: u32) -> ([f64; 3], f64) {
        absolute_sum(octaves, |octave| {
            let scale = f64::from(1u32 << octave);
            self.sample(p.map(|p| p * scale), period.of_octave(octave))
        })
    }
}

/// The hash of a cell; a power of two of cells after which it repeats.
fn hash(cell: [u32; 3], period: u32) -> u32 {
    let strides = cell.map(|c| c & (period - 1)).into_iter().zip(STRIDE);
    let h = strides.fold(0, |h, (c, stride)| h ^ c.wrapping_mul(stride)).wrapping_mul(0x27d4_eb2d);
    h ^ (h >> 15)
}

/// The direction of a lattice point.
pub(super) fn direction(cell: [u32; 3], period: u32) -> [f64; 3] {
    let h = hash(cell, period);
    let major = usize::from(h >= THIRDS[0]) + usize::from(h >= THIRDS[1]);
    DIRECTIONS[major][h as usize & 7]
}

#[cfg(test)]
mod tests {
    use super::super::tests::points;
    use super::*;

    const WEIGHTS: [Weights; 2] = [Weights::Cubic, Weights::Quintic];

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

    #[test]
    fn the_gradient_is_the_derivative_of_the_noise() {
        let h = 1e-5;
        for (p, weights) in points(1_000).zip(WEIGHTS.into_iter().cycle()) {
            let noise = Lattice { weights };
            let (gradient, _) = noise.sample(p, 256);
            for (axis, expected) in gradient.into_iter().enumerate() {
                let at =
                    |step: f64| noise.sample(std::array::from_fn(|a| p[a] + if a == axis { step } else { 0.0 }), 256).1;
                let slope = (at(h) - at(-h)) / (2.0 * h);
                assert!((slope - expected).abs() < 1e-8, "{slope} against {expected}");
            }
        }
    }

    #[test]
    fn p15_noise_and_its_gradient_stay_within_their_bounds() {
        for (weights, steepest) in [(Weights::Cubic, 2.2), (Weights::Quintic, 2.8)] {
            for p in points(50_000) {
                let (gradient, value) = Lattice { weights }.sample(p, 256);
                assert!(value.abs() <= 0.8661);
                assert!(gradient.iter().map(|c| c * c).sum::<f64>().sqrt() <= steepest);
            }
        }
    }

    #[test]
    fn p21_turbulence_stays_within_its_range_and_octaves_fade_to_the_mean_of_the_noise() {
        let (mut largest, mut sum) = (0.0f64, [0.0; 2]);
        for p in points(200_000) {
            largest = largest.max(Lattice::default().turbulence(p, Period::ENDLESS, 8).1);
            for (sum, weights) in sum.iter_mut().zip(WEIGHTS) {
                *sum += Lattice { weights }.sample(p, 1 << 20).1.abs() / 200_000.0;
            }
        }
        assert!(largest < 1.733);
        println!("mean of |noise|: {sum:?}, largest turbulence {largest}");
        for (sum, weights) in sum.into_iter().zip(WEIGHTS) {
            assert!((f64::from(weights.mean_of_block(u32::MAX)) - sum).abs() < 1e-3, "{weights:?}: {sum}");
        }
    }

    #[test]
    fn m35_octaves_repeat_where_their_period_says_and_not_before() {
        let moved = |p: [f64; 3], by: f64| [p[0] + by, p[1], p[2] - by];
        let noise = Lattice::default();
        let differ = |period: Period, octave: u32, by: f64| {
            let of = |p| noise.sample(p, period.of_octave(octave)).1;
            points(500).map(|p| (of(p) - of(moved(p, by))).abs()).fold(0.0, f64::max)
        };
        let channels = Period { cycle: 4, ..Period::growing(4) };
        for (period, octave, cells) in [
            (Period::same(16), 5, 16.0),
            (Period::growing(4), 5, 128.0),
            (channels, 3, 32.0),
            (channels, 4, 4.0),
            (channels, 7, 32.0),
        ] {
            assert!(differ(period, octave, cells) < 1e-12, "{period:?}, octave {octave}");
            assert!(differ(period, octave, 0.5 * cells) > 0.3, "{period:?}, octave {octave}");
        }
        assert!(differ(Period::ENDLESS, 0, 65_536.0) > 0.3);
    }
}
