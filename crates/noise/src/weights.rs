//! Interpolation of lattice noise, and the bounds of noise and turbulence.

/// Bound of |noise|.
pub const NOISE_BOUND: f64 = 0.867;
/// Bound of the noise gradient per lattice cell (2.8 for quintic weights and unit gradients).
pub const NOISE_GRADIENT_BOUND: f64 = 3.0;
/// Bound of the gradient of eight octaves of turbulence, per lattice cell of the first octave.
pub const TURBULENCE_GRADIENT_BOUND: f64 = 24.0;
/// Largest turbulence that a block can hold. The sum of all octaves stays below 1.733.
pub const TURBULENCE_BOUND: f64 = 2.0;

/// Interpolation weights between lattice points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weights {
    /// `3 t^2 - 2 t^3` (PH 2.3, 1989): the curvature jumps at lattice planes.
    Cubic,
    /// `6 t^5 - 15 t^4 + 10 t^3` (Perlin 2002).
    #[default]
    Quintic,
}

impl Weights {
    /// Mean of |noise| of unit gradients, read through a linear filter from a block of `texels` per cell, at least 2.
    /// Equals `MEANS_IN_BLOCKS` and `MEAN_OF_GRADIENTS` in `glsl/weights`.
    pub fn mean_of_block(self, texels: u32) -> f32 {
        let means = match self {
            Weights::Cubic => [0.105, 0.135, 0.145, 0.147, 0.148],
            Weights::Quintic => [0.108, 0.141, 0.152, 0.155, 0.156],
        };
        means[(texels.max(2).ilog2() as usize - 1).min(4)]
    }

    /// Weight of the far side at `t` in [0, 1], and its slope.
    pub(super) fn fade(self, t: f64) -> (f64, f64) {
        match self {
            Weights::Cubic => (t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t)),
            Weights::Quintic => (t * t * t * (t * (t * 6.0 - 15.0) + 10.0), 30.0 * t * t * (t * (t - 2.0) + 1.0)),
        }
    }

    /// Gradient and value at `t` in [0, 1]^3 of a cell; `knot` gives value and gradient of each corner.
    pub(super) fn interpolate(self, t: [f64; 3], knot: impl Fn([usize; 3]) -> [f64; 4]) -> ([f64; 3], f64) {
        let fade = t.map(|t| self.fade(t).0);
        let slope = t.map(|t| self.fade(t).1);
        let (mut gradient, mut value) = ([0.0; 3], 0.0);
        for corner in 0..8 {
            let side = [corner & 1, corner >> 1 & 1, corner >> 2];
            let [own, knot @ ..] = knot(side);
            let weight: [f64; 3] = std::array::from_fn(|a| if side[a] == 1 { fade[a] } else { 1.0 - fade[a] });
            let there = own + (0..3).map(|a| knot[a] * (t[a] - side[a] as f64)).sum::<f64>();
            value += weight[0] * weight[1] * weight[2] * there;
            for a in 0..3 {
                let others = weight[(a + 1) % 3] * weight[(a + 2) % 3];
                let sign = if side[a] == 1 { 1.0 } else { -1.0 };
                gradient[a] += others * (weight[a] * knot[a] + sign * slope[a] * there);
            }
        }
        (gradient, value)
    }
}

/// Sum over octaves of |noise| / 2^i, with its gradient; `octave` gives gradient and value of octave i, per cell of that octave.
pub(super) fn absolute_sum(octaves: u32, octave: impl Fn(u32) -> ([f64; 3], f64)) -> ([f64; 3], f64) {
    let (mut gradient, mut value) = ([0.0; 3], 0.0);
    for index in 0..octaves {
        let (g, n) = octave(index);
        value += n.abs() / f64::from(1u32 << index);
        for a in 0..3 {
            gradient[a] += n.signum() * g[a];
        }
    }
    (gradient, value)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use hypertexture_support::random::SplitMix;

    /// Random points in [-32, 32]^3.
    pub(crate) fn points(count: u32) -> impl Iterator<Item = [f64; 3]> {
        let mut random = SplitMix(7);
        (0..count).map(move |_| std::array::from_fn(|_| random.unit() * 64.0 - 32.0))
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
}
