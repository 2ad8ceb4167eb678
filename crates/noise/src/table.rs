//! Perlin's noise of 1989: gradients uniform on the sphere, selected by three chained lookups in a permutation.
//!
//! Source: PH 2.3 (n = 256).

use super::weights::{Weights, absolute_sum};
use hypertexture_support::random::SplitMix;

/// Seed of the tables and of random texels. A change changes every picture that uses them.
pub const SEED: u64 = 1989;
/// Entries of the permutation and gradient tables, and the period of the noise in lattice cells.
const TABLE: usize = 256;

/// Gradient noise from tables.
#[derive(Clone)]
pub struct Noise {
    weights: Weights,
    permutation: [u8; TABLE],
    gradients: [[f64; 3]; TABLE],
}

impl Noise {
    /// The noise of a seed.
    pub fn new(seed: u64, weights: Weights) -> Noise {
        let mut random = SplitMix(seed);
        let mut permutation = std::array::from_fn(|index| index as u8);
        random.shuffle(&mut permutation);
        let gradients = std::array::from_fn(|_| random_direction(&mut random));
        Noise { weights, permutation, gradients }
    }

    /// Gradient (per lattice cell) and value of the noise at `p`, in lattice cells.
    ///
    /// The lattice repeats after `period` cells, 1 to 256. The value lies in [-0.867, 0.867] and is 0 at lattice points, where
    /// the gradient is theirs. `p` is finite; far from the origin its fraction loses digits.
    pub fn sample(&self, p: [f64; 3], period: u32) -> ([f64; 3], f64) {
        let base = p.map(f64::floor);
        let t: [f64; 3] = std::array::from_fn(|axis| p[axis] - base[axis]);
        let wrap = |axis: usize, side: usize| (base[axis] as i64 + side as i64).rem_euclid(i64::from(period)) as usize;
        self.weights.interpolate(t, |side| {
            let [x, y, z] = self.knot([0, 1, 2].map(|axis| wrap(axis, side[axis])));
            [0.0, x, y, z]
        })
    }

    /// Gradient and value of the turbulence at `p`: the sum over octaves of |noise(2^i p)| / 2^i.
    ///
    /// `p` and `period` in lattice cells of the first octave. The gradient jumps where an octave crosses zero.
    pub fn turbulence(&self, p: [f64; 3], period: u32, octaves: u32) -> ([f64; 3], f64) {
        absolute_sum(octaves, |octave| {
            let scale = f64::from(1u32 << octave);
            self.sample(p.map(|p| p * scale), (period << octave).min(TABLE as u32))
        })
    }

    /// The permutation and the gradients.
    pub fn tables(&self) -> (&[u8; TABLE], &[[f64; 3]; TABLE]) {
        (&self.permutation, &self.gradients)
    }

    /// Gradient of a lattice point (PH 2.3).
    pub(super) fn knot(&self, [i, j, k]: [usize; 3]) -> [f64; 3] {
        let phi = |index: usize| usize::from(self.permutation[index % TABLE]);
        self.gradients[phi(i + phi(j + phi(k)))]
    }
}

/// Random unit vector by rejection sampling in the ball (PH 2.3).
fn random_direction(random: &mut SplitMix) -> [f64; 3] {
    loop {
        let p: [f64; 3] = std::array::from_fn(|_| (random.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0);
        let n2: f64 = p.iter().map(|c| c * c).sum();
        if (1e-6..=1.0).contains(&n2) {
            return p.map(|c| c / n2.sqrt());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::weights::tests::points;
    use super::*;

    #[test]
    fn p15_noise_is_zero_at_lattice_points_and_has_their_gradient() {
        let noise = Noise::new(1, Weights::Quintic);
        for (i, j, k) in [(0, 0, 0), (3, 250, 17), (255, 1, 128)] {
            let (gradient, value) = noise.sample([f64::from(i), f64::from(j), f64::from(k)], 256);
            assert_eq!(value, 0.0);
            assert_eq!(gradient, noise.knot([i, j, k].map(|c| c as usize)));
        }
    }

    #[test]
    fn p18_gradients_are_uniform_on_the_sphere() {
        let noise = Noise::new(1, Weights::Quintic);
        for g in noise.gradients {
            assert!((g.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-12);
        }
        // The mean of 256 uniform directions has a standard deviation of 1 / sqrt(3 * 256) = 0.036 per axis.
        for axis in 0..3 {
            let mean = noise.gradients.iter().map(|g| g[axis]).sum::<f64>() / 256.0;
            assert!(mean.abs() < 0.15, "axis {axis}: {mean}");
        }
    }

    #[test]
    fn p19_three_lookups_decorrelate_neighboring_gradients() {
        let noise = Noise::new(1, Weights::Quintic);
        let once = |i: usize, j: usize, k: usize| noise.gradients[usize::from(noise.permutation[(i + j + k) % TABLE])];
        let thrice = |i: usize, j: usize, k: usize| noise.knot([i, j, k]);
        let correlation = |knot: &dyn Fn(usize, usize, usize) -> [f64; 3]| {
            let (mut sum, mut count) = (0.0, 0.0);
            for (i, j, k) in (0..40).flat_map(|i| (1..41).flat_map(move |j| (0..40).map(move |k| (i, j, k)))) {
                let (a, b) = (knot(i, j, k), knot(i + 1, j - 1, k));
                sum += (0..3).map(|c| a[c] * b[c]).sum::<f64>();
                count += 1.0;
            }
            sum / count
        };
        assert!((correlation(&once) - 1.0).abs() < 1e-12, "{}", correlation(&once));
        assert!(correlation(&thrice).abs() < 0.03, "{}", correlation(&thrice));
    }

    #[test]
    fn m16_curvature_jumps_at_lattice_planes_in_1989_not_2002() {
        let h = 1e-4;
        let curvature = |noise: &Noise, x: f64| {
            let at = |x| noise.sample([x, 3.4, 7.7], 256).1;
            (at(x + h) - 2.0 * at(x) + at(x - h)) / (h * h)
        };
        for (weights, jumps) in [(Weights::Cubic, true), (Weights::Quintic, false)] {
            let noise = Noise::new(9, weights);
            let jump = (curvature(&noise, 5.0 + 2.0 * h) - curvature(&noise, 5.0 - 2.0 * h)).abs();
            assert_eq!(jump > 0.5, jumps, "{weights:?}: {jump}");
        }
    }

    #[test]
    fn p21_turbulence_stays_within_its_range() {
        let noise = Noise::new(4, Weights::Quintic);
        assert!(points(20_000).all(|p| (0.0..1.733).contains(&noise.turbulence(p, 4, 8).1)));
    }

    #[test]
    fn p17_negative_coordinates_wrap_without_a_seam() {
        let noise = Noise::new(5, Weights::Quintic);
        for p in points(1_000) {
            let shifted = p.map(|c| c + 16.0);
            assert!((noise.sample(p, 16).1 - noise.sample(shifted, 16).1).abs() < 1e-12);
        }
        let (below, above) = (noise.sample([-1e-9, 0.3, 0.4], 16).1, noise.sample([1e-9, 0.3, 0.4], 16).1);
        assert!((below - above).abs() < 1e-8);
    }
}
