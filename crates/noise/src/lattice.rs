//! Lattice noise of any [`Knots`]; with hashed ones, that of `glsl/lattice_noise.glsl`.

use super::knots::Knots;
use super::weights::{Weights, absolute_sum};

/// Distance from the origin in cells beyond which coordinates are clamped. f32 has no fraction left soon after.
pub(super) const FARTHEST: f64 = 1_048_576.0;

/// Repetition of the lattice, by octave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Period {
    /// Cells of the first octave, a power of two up to 2^20.
    pub cells: u32,
    /// Whether all octaves repeat where the first does, each after twice as many of its cells as the one before.
    pub growing: bool,
    /// Octaves after which growth starts over, a power of two: those of one fetch.
    pub cycle: u32,
}

impl Period {
    /// A repetition too far away to be visible.
    pub const ENDLESS: Period = Period::same(1 << 20);

    /// Every octave repeats after `cells` of its own: one block at all scales.
    pub const fn same(cells: u32) -> Period {
        Period { cells, growing: false, cycle: 16 }
    }

    /// Every octave repeats where the first does: one block of all octaves.
    pub const fn growing(cells: u32) -> Period {
        Period { cells, growing: true, cycle: 16 }
    }

    /// Period of an octave, in its cells.
    pub(crate) fn of_octave(self, octave: u32) -> u32 {
        self.cells << if self.growing { octave & (self.cycle - 1) } else { 0 }
    }
}

/// Lattice noise.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lattice {
    /// Interpolation weights.
    pub weights: Weights,
}

impl Lattice {
    /// Gradient (per lattice cell) and value of the noise at `p`, in lattice cells.
    ///
    /// The lattice repeats after `period` cells, a power of two. The value lies in [-0.867, 0.867] and is 0 at lattice points,
    /// where the gradient is their direction. `p` is finite.
    pub fn sample(self, p: [f64; 3], period: u32) -> ([f64; 3], f64) {
        self.sample_of(Knots::Hashed(period), p)
    }

    /// Gradient and value of the noise of any knots. That of [`Knots::Values`] has a gradient of 0 at lattice points.
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

#[cfg(test)]
mod tests {
    use super::super::table::Noise;
    use super::super::weights::tests::points;
    use super::*;

    type Sample<'a> = dyn Fn([f64; 3]) -> ([f64; 3], f64) + 'a;
    const WEIGHTS: [Weights; 2] = [Weights::Cubic, Weights::Quintic];

    #[test]
    fn the_gradient_is_the_derivative_of_the_noise() {
        let h = 1e-5;
        for (p, weights) in points(1_000).zip(WEIGHTS.into_iter().cycle()) {
            let table = Noise::new(3, weights);
            let samples: [&Sample; 2] = [&|p| Lattice { weights }.sample(p, 256), &|p| table.sample(p, 256)];
            for sample in samples {
                for (axis, expected) in sample(p).0.into_iter().enumerate() {
                    let at = |step: f64| sample(std::array::from_fn(|a| p[a] + if a == axis { step } else { 0.0 })).1;
                    let slope = (at(h) - at(-h)) / (2.0 * h);
                    assert!((slope - expected).abs() < 1e-8, "{slope} against {expected}");
                }
            }
        }
    }

    #[test]
    fn p15_noise_and_its_gradient_stay_within_their_bounds() {
        for (weights, steepest) in [(Weights::Cubic, 2.2), (Weights::Quintic, 2.8)] {
            let table = Noise::new(2, weights);
            for p in points(100_000) {
                for (gradient, value) in [Lattice { weights }.sample(p, 256), table.sample(p, 256)] {
                    assert!(value.abs() <= 0.8661);
                    assert!(gradient.iter().map(|c| c * c).sum::<f64>().sqrt() <= steepest);
                }
            }
        }
    }

    #[test]
    fn p21_turbulence_stays_in_range_and_fades_to_its_mean() {
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
