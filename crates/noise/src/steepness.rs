//! The range of the gradient of the noise over a box: how steep it may be along each axis.
//!
//! Role: noise whose place changes along a ray is bounded by its value in the middle and by these slopes, far narrower than
//! by the box around its places. Invariant: the gradient of every [`Lattice::sample_of`] in the box lies in the range; so does what
//! two values in the box differ by, divided by how far they are apart along an axis.

use super::lattice::Lattice;
use super::range::{Knot, Parts, ROUNDED, faded, parts};
use super::{Knots, Weights};

impl Lattice {
    /// Bounds of the gradient of the noise of these knots over a box, per axis and lattice cell.
    pub fn gradient_range(self, knots: Knots, low: [f64; 3], high: [f64; 3]) -> [[f64; 2]; 3] {
        let steepest = knots.steepest();
        let Some((parts, [x, y, z])) = parts(low, high) else { return [[-steepest, steepest]; 3] };
        let mut all = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        for z in &parts[2][..z] {
            for y in &parts[1][..y] {
                for x in &parts[0][..x] {
                    self.weights.include_gradient(&mut all, [x, y, z], knots);
                }
            }
        }
        let held = |[low, high]: [f64; 2]| [(low - ROUNDED).max(-steepest), (high + ROUNDED).min(steepest)];
        all.map(held)
    }
}

impl Weights {
    /// Takes in the range over the part of a cell.
    fn include_gradient(self, all: &mut [[f64; 2]; 3], parts: [&Parts; 3], of: Knots) {
        let mut knots = [[0.0; 4]; 8];
        let mut directions = [[0.0; 4]; 8];
        let (mut middle, mut half, mut far, mut steep) = ([0.0; 3], [0.0; 3], [[0.0; 2]; 3], [[0.0; 2]; 3]);
        for axis in 0..3 {
            let [low, high] = parts[axis].whole();
            (middle[axis], half[axis]) = (0.5 * (low + high), 0.5 * (high - low));
            let [(from, rise), (to, fall)] = [self.fade(low), self.fade(high)];
            far[axis] = [from, to];
            // It rises up to the middle of the cell and falls behind it.
            let top = if low < 0.5 && high > 0.5 { self.fade(0.5).1 } else { rise.max(fall) };
            steep[axis] = [rise.min(fall), top];
        }
        for corner in 0..8 {
            let place = |axis: usize| (parts[axis].base as u32).wrapping_add((corner >> axis & 1) as u32);
            let [own, x, y, z] = of.at([0, 1, 2].map(place));
            let away = |axis: usize| middle[axis] - (corner >> axis & 1) as f64;
            directions[corner] = [x, y, z, 0.0];
            knots[corner] = [own + x * away(0) + y * away(1) + z * away(2), x * half[0], y * half[1], z * half[2]];
        }
        // The mean of the directions, and the slope of each weight times what it fades between.
        let means = faded::<4>(faded::<2>(faded::<1>(directions, far[0]), far[1]), far[2]);
        let across = [
            faded::<4>(faded::<2>(differences::<1>(knots), far[1]), far[2]),
            faded::<4>(faded::<1>(differences::<2>(knots), far[0]), far[2]),
            faded::<2>(faded::<1>(differences::<4>(knots), far[0]), far[1]),
        ];
        for axis in 0..3 {
            let mut mean = [f64::INFINITY, f64::NEG_INFINITY];
            let mut step = mean;
            for end in 0..8 {
                let [value, x, y, z] = across[axis][end];
                let reach = x.abs() + y.abs() + z.abs();
                step = [step[0].min(value - reach), step[1].max(value + reach)];
                mean = [mean[0].min(means[end][axis]), mean[1].max(means[end][axis])];
            }
            let [flat, steep] = steep[axis];
            let low = mean[0] + if step[0] < 0.0 { steep * step[0] } else { flat * step[0] };
            let high = mean[1] + if step[1] > 0.0 { steep * step[1] } else { flat * step[1] };
            all[axis] = [all[axis][0].min(low), all[axis][1].max(high)];
        }
    }
}

/// What the far side of an axis has more than the near one, at both.
fn differences<const AXIS: usize>(knots: [Knot; 8]) -> [Knot; 8] {
    let of = |corner: usize| std::array::from_fn(|part| knots[corner | AXIS][part] - knots[corner & !AXIS][part]);
    [0, 1, 2, 3, 4, 5, 6, 7].map(of)
}

#[cfg(test)]
mod tests {
    use super::*;
    use support::random::SplitMix;

    #[test]
    fn no_gradient_in_a_box_is_outside_of_its_range_and_ranges_are_narrow() {
        let mut random = SplitMix(12);
        for side in [1e-3, 0.05, 0.1, 0.2, 0.4] {
            let (mut width, mut seen) = (0.0, 0.0);
            for number in 0..400 {
                let noise = Lattice { weights: [Weights::Cubic, Weights::Quintic][number % 2] };
                let knots = [Knots::Hashed(1 << 20), Knots::Hashed(4), Knots::Tables, Knots::Values][number / 2 % 4];
                let low: [f64; 3] = std::array::from_fn(|_| 40.0 * random.unit() - 20.0);
                let high = low.map(|low| low + side * random.unit());
                let range = noise.gradient_range(knots, low, high);
                let mut found = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
                for point in 0..500 {
                    let part: [f64; 3] = std::array::from_fn(|a| match point {
                        ..8 => f64::from(point >> a & 1),
                        _ => random.unit(),
                    });
                    let p = std::array::from_fn(|a| low[a] + part[a] * (high[a] - low[a]));
                    let gradient = noise.sample_of(knots, p).0;
                    for axis in 0..3 {
                        let ([least, most], slope) = (range[axis], gradient[axis]);
                        assert!((least..=most).contains(&slope), "{slope} in [{least}, {most}], {low:?} to {high:?}");
                        found[axis] = [found[axis][0].min(slope), found[axis][1].max(slope)];
                    }
                }
                for axis in 0..3 {
                    width += range[axis][1] - range[axis][0];
                    seen += found[axis][1] - found[axis][0];
                }
            }
            println!("{side}: {:.2} times as wide as what is seen, {:.3}", width / seen, seen / 1200.0);
            assert!(width < 4.0 * seen, "{side}: {} times", width / seen);
        }
    }
}
