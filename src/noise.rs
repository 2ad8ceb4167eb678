//! Lattice noise on the CPU, and the blocks of it that textures are made of.
//!
//! Role: Perlin's gradient noise with an analytic gradient, in f64, and its sum of octaves, sampled into blocks that
//! tile. Invariant: the same seed gives the same block on every machine.
//! Source: PH 2.3 (gradients uniform on the sphere, a hash folded three times, n = 256), Perlin 2002 (quintic weights),
//! MJ 4.1 (a 64^3 block with the gradient in RGB and the noise in A).

use rayon::prelude::*;

/// The gradient of the noise never exceeds this (2.8 for quintic weights and unit gradients), per lattice cell.
pub const NOISE_GRADIENT_BOUND: f64 = 3.0;
/// The gradient of eight octaves of turbulence never exceeds this, per lattice cell of the first octave.
pub const TURBULENCE_GRADIENT_BOUND: f64 = 24.0;
/// The largest value of turbulence that a block can hold; the sum of all octaves stays below 1.733.
pub const TURBULENCE_BOUND: f64 = 2.0;

/// Entries of the permutation and gradient tables: the period of the noise in lattice cells.
const TABLE: usize = 256;

/// How the gradients of the lattice fade into each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weights {
    /// `3 t^2 - 2 t^3` (PH 2.3, 1989): the curvature jumps at lattice planes.
    Cubic,
    /// `6 t^5 - 15 t^4 + 10 t^3` (Perlin 2002).
    #[default]
    Quintic,
}

impl Weights {
    /// Weight of the far side at `t` in [0, 1], and its slope.
    fn fade(self, t: f64) -> (f64, f64) {
        match self {
            Weights::Cubic => (t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t)),
            Weights::Quintic => (t * t * t * (t * (t * 6.0 - 15.0) + 10.0), 30.0 * t * t * (t * (t - 2.0) + 1.0)),
        }
    }
}

/// A gradient noise with its tables.
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
        let mut permutation = [0; TABLE];
        for (index, entry) in permutation.iter_mut().enumerate() {
            *entry = index as u8;
        }
        for last in (1..TABLE).rev() {
            permutation.swap(last, (random.next() % (last as u64 + 1)) as usize);
        }
        let gradients = std::array::from_fn(|_| random.direction());
        Noise { weights, permutation, gradients }
    }

    /// Gradient (per lattice cell) and value of the noise at `p`, in lattice cells.
    ///
    /// The lattice repeats after `period` cells, 1 to 256. The value lies in [-0.867, 0.867], is 0 at lattice points and
    /// has their gradient there. Any finite `p`; far from the origin the digits of its fraction are lost.
    pub fn sample(&self, p: [f64; 3], period: u32) -> ([f64; 3], f64) {
        let base = p.map(f64::floor);
        let t: [f64; 3] = std::array::from_fn(|axis| p[axis] - base[axis]);
        let wrap = |axis: usize, side: usize| (base[axis] as i64 + side as i64).rem_euclid(i64::from(period)) as usize;
        let fade = t.map(|t| self.weights.fade(t).0);
        let slope = t.map(|t| self.weights.fade(t).1);
        let (mut gradient, mut value) = ([0.0; 3], 0.0);
        for corner in 0..8 {
            let side = [corner & 1, corner >> 1 & 1, corner >> 2];
            let knot = self.knot(wrap(0, side[0]), wrap(1, side[1]), wrap(2, side[2]));
            let weight: [f64; 3] = std::array::from_fn(|a| if side[a] == 1 { fade[a] } else { 1.0 - fade[a] });
            let dot: f64 = (0..3).map(|a| knot[a] * (t[a] - side[a] as f64)).sum();
            value += weight[0] * weight[1] * weight[2] * dot;
            for a in 0..3 {
                let others = weight[(a + 1) % 3] * weight[(a + 2) % 3];
                let sign = if side[a] == 1 { 1.0 } else { -1.0 };
                gradient[a] += others * (weight[a] * knot[a] + sign * slope[a] * dot);
            }
        }
        (gradient, value)
    }

    /// Gradient and value of the turbulence at `p`: the sum over octaves of |noise(2^i p)| / 2^i.
    ///
    /// `p` and `period` in lattice cells of the first octave. The gradient jumps where an octave crosses zero.
    pub fn turbulence(&self, p: [f64; 3], period: u32, octaves: u32) -> ([f64; 3], f64) {
        let (mut gradient, mut value) = ([0.0; 3], 0.0);
        for octave in 0..octaves {
            let scale = f64::from(1u32 << octave);
            let (g, n) = self.sample(p.map(|p| p * scale), period << octave);
            value += n.abs() / scale;
            for a in 0..3 {
                gradient[a] += n.signum() * g[a];
            }
        }
        (gradient, value)
    }

    /// PH 2.3: the gradient of a lattice point by a hash folded three times.
    fn knot(&self, i: usize, j: usize, k: usize) -> [f64; 3] {
        let phi = |index: usize| usize::from(self.permutation[index % TABLE]);
        self.gradients[phi(i + phi(j + phi(k)))]
    }
}

/// A block of noise: `size`^3 texels of RGBA, 16 bits each, x fastest; gradient in RGB, noise in A.
///
/// The block holds `cells` lattice cells on each axis and tiles without a seam. Texel i lies at `(i + 0.5) / size`.
/// A channel c holds `0.5 + 0.5 c / bound`, with the bound 1 for the noise and [`NOISE_GRADIENT_BOUND`].
pub fn noise_block(noise: &Noise, size: u32, cells: u32) -> Vec<u16> {
    bake(size, cells, |p| {
        let (gradient, value) = noise.sample(p, cells);
        [
            signed(gradient[0] / NOISE_GRADIENT_BOUND),
            signed(gradient[1] / NOISE_GRADIENT_BOUND),
            signed(gradient[2] / NOISE_GRADIENT_BOUND),
            signed(value),
        ]
    })
}

/// A block of turbulence: as [`noise_block`], with `value / TURBULENCE_BOUND` in A.
///
/// Octaves whose cells are narrower than two texels are left out: PH 3.1, a texture cannot hold them. Returns the
/// octaves that it holds.
pub fn turbulence_block(noise: &Noise, size: u32, cells: u32, octaves: u32) -> (Vec<u16>, u32) {
    let held = (0..octaves).take_while(|octave| (cells << octave) * 2 <= size).count() as u32;
    let texels = bake(size, cells, |p| {
        let (gradient, value) = noise.turbulence(p, cells, held);
        [
            signed(gradient[0] / TURBULENCE_GRADIENT_BOUND),
            signed(gradient[1] / TURBULENCE_GRADIENT_BOUND),
            signed(gradient[2] / TURBULENCE_GRADIENT_BOUND),
            unsigned(value / TURBULENCE_BOUND),
        ]
    });
    (texels, held)
}

fn bake(size: u32, cells: u32, texel: impl Fn([f64; 3]) -> [u16; 4] + Sync) -> Vec<u16> {
    let at = |index: usize| (index as f64 + 0.5) / f64::from(size) * f64::from(cells);
    let side = size as usize;
    let mut block = vec![0u16; side * side * side * 4];
    block.par_chunks_mut(side * side * 4).enumerate().for_each(|(z, slice)| {
        for (index, out) in slice.chunks_exact_mut(4).enumerate() {
            out.copy_from_slice(&texel([at(index % side), at(index / side), at(z)]));
        }
    });
    block
}

fn signed(value: f64) -> u16 {
    unsigned(0.5 + 0.5 * value)
}

fn unsigned(value: f64) -> u16 {
    (value * 65535.0).round() as u16
}

/// Vigna's SplitMix64: a small generator whose sequence is fixed for ever.
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// PH 2.3: a point in the cube, kept when it lies in the ball, brought to the sphere.
    fn direction(&mut self) -> [f64; 3] {
        loop {
            let p: [f64; 3] = std::array::from_fn(|_| (self.next() >> 11) as f64 / (1u64 << 52) as f64 - 1.0);
            let n2: f64 = p.iter().map(|c| c * c).sum();
            if (1e-6..=1.0).contains(&n2) {
                return p.map(|c| c / n2.sqrt());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(count: u32) -> impl Iterator<Item = [f64; 3]> {
        let mut random = SplitMix(7);
        (0..count)
            .map(move |_| std::array::from_fn(|_| (random.next() >> 11) as f64 / (1u64 << 53) as f64 * 64.0 - 32.0))
    }

    #[test]
    fn p15_noise_is_zero_at_lattice_points_and_has_their_gradient() {
        let noise = Noise::new(1, Weights::Quintic);
        for (i, j, k) in [(0, 0, 0), (3, 250, 17), (255, 1, 128)] {
            let (gradient, value) = noise.sample([f64::from(i), f64::from(j), f64::from(k)], 256);
            assert_eq!(value, 0.0);
            assert_eq!(gradient, noise.knot(i as usize, j as usize, k as usize));
        }
    }

    #[test]
    fn p16_the_weights_of_both_sides_sum_to_one() {
        for weights in [Weights::Cubic, Weights::Quintic] {
            for t in (0..=100).map(|t| f64::from(t) / 100.0) {
                assert!((weights.fade(t).0 + weights.fade(1.0 - t).0 - 1.0).abs() < 1e-12);
            }
        }
        // PH 2.3 in its own form: 2 |t|^3 - 3 t^2 + 1 is the weight of the near side.
        assert!((1.0 - Weights::Cubic.fade(0.3).0 - (2.0 * 0.027 - 3.0 * 0.09 + 1.0)).abs() < 1e-12);
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
    fn p19_one_lookup_correlates_neighboring_gradients_and_three_do_not() {
        let noise = Noise::new(1, Weights::Quintic);
        let once = |i: usize, j: usize, k: usize| noise.gradients[usize::from(noise.permutation[(i + j + k) % TABLE])];
        let thrice = |i: usize, j: usize, k: usize| noise.knot(i, j, k);
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
    fn p15_noise_and_its_gradient_stay_within_their_bounds() {
        for (weights, steepest) in [(Weights::Cubic, 2.2), (Weights::Quintic, 2.8)] {
            let noise = Noise::new(2, weights);
            for p in points(100_000) {
                let (gradient, value) = noise.sample(p, 256);
                assert!(value.abs() <= 0.8661);
                assert!(gradient.iter().map(|c| c * c).sum::<f64>().sqrt() <= steepest);
            }
        }
    }

    #[test]
    fn m16_the_curvature_jumps_at_lattice_planes_in_1989_and_no_longer_in_2002() {
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
    fn the_gradient_is_the_derivative_of_the_noise() {
        let h = 1e-5;
        for (p, weights) in points(2_000).zip([Weights::Cubic, Weights::Quintic].into_iter().cycle()) {
            let noise = Noise::new(3, weights);
            let (gradient, _) = noise.sample(p, 256);
            for axis in 0..3 {
                let mut ahead = p;
                let mut behind = p;
                ahead[axis] += h;
                behind[axis] -= h;
                let slope = (noise.sample(ahead, 256).1 - noise.sample(behind, 256).1) / (2.0 * h);
                assert!((slope - gradient[axis]).abs() < 1e-8, "{slope} against {}", gradient[axis]);
            }
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

    #[test]
    fn m34_a_block_holds_the_noise_at_texel_centers_to_half_a_code() {
        let noise = Noise::new(6, Weights::Quintic);
        let block = noise_block(&noise, 16, 4);
        for (index, texel) in block.chunks_exact(4).enumerate() {
            let at = |i: usize| (i as f64 + 0.5) / 16.0 * 4.0;
            let (gradient, value) = noise.sample([at(index % 16), at(index / 16 % 16), at(index / 256)], 4);
            let decoded = f64::from(texel[3]) / 65535.0 * 2.0 - 1.0;
            assert!((decoded - value).abs() <= 1.001 / 65535.0);
            let decoded = (f64::from(texel[0]) / 65535.0 * 2.0 - 1.0) * NOISE_GRADIENT_BOUND;
            assert!((decoded - gradient[0]).abs() <= 1.001 * NOISE_GRADIENT_BOUND / 65535.0);
        }
    }

    #[test]
    fn octaves_that_a_block_cannot_hold_are_left_out() {
        let noise = Noise::new(6, Weights::Quintic);
        assert_eq!(turbulence_block(&noise, 16, 2, 8).1, 3);
        assert_eq!(turbulence_block(&noise, 32, 2, 8).1, 4);
        assert_eq!(turbulence_block(&noise, 16, 2, 2).1, 2);
    }
}
