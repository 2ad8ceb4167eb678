//! Ranges of the noise and of its gradient over boxes.
//!
//! Role: bounds as tight as a block of texels gives, without a block. The gradient's range bounds noise whose place moves
//! along a ray: its value in the middle and these slopes are far tighter than the range over the box of its places.
//! Invariant: value and gradient of every [`Lattice::sample_of`] in a box lie in their ranges. Within a cell the noise is
//! linear in each of six numbers, the weights of the far sides and the offsets in the box, so its extremes over all of them
//! are at their ends.

use super::knots::Knots;
use super::lattice::{FARTHEST, Lattice};
use super::weights::{NOISE_BOUND, Weights};

/// Longest part of a box bounded by itself, in lattice cells. Lower is slower; higher widens ranges.
const PIECE: f64 = 0.5;
/// Longest box that is looked at, in lattice cells; longer ones get the range of all noise. Higher is much slower and hardly
/// narrower.
const MAX_BOX: f64 = 1.5;
/// Most cells along an axis that such a box touches.
const MOST_CELLS: usize = 3;
/// Rounding errors of f64, and of GLSL constants, which have 32 bits.
pub const ROUNDED: f64 = 1e-7;
/// The empty range.
const EMPTY: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

impl Lattice {
    /// Range of the noise of `knots` over a box in lattice cells.
    pub fn range(self, knots: Knots, low: [f64; 3], high: [f64; 3]) -> [f64; 2] {
        let mut all = EMPTY;
        if for_each_cell(low, high, |cell| self.weights.include(&mut all, cell, knots)) {
            [(all[0] - ROUNDED).max(-NOISE_BOUND), (all[1] + ROUNDED).min(NOISE_BOUND)]
        } else {
            [-NOISE_BOUND, NOISE_BOUND]
        }
    }

    /// Range of the gradient of the noise of `knots` over a box in lattice cells, per axis and cell.
    pub fn gradient_range(self, knots: Knots, low: [f64; 3], high: [f64; 3]) -> [[f64; 2]; 3] {
        let steepest = knots.steepest();
        let mut all = [EMPTY; 3];
        if for_each_cell(low, high, |cell| self.weights.include_gradient(&mut all, cell, knots)) {
            all.map(|[low, high]| [(low - ROUNDED).max(-steepest), (high + ROUNDED).min(steepest)])
        } else {
            [[-steepest, steepest]; 3]
        }
    }
}

/// Calls `on` with the parts of a box within each cell, by axis. Returns false for a box that is too long.
#[inline(always)]
fn for_each_cell(low: [f64; 3], high: [f64; 3], mut on: impl FnMut([&Parts; 3])) -> bool {
    let mut parts = [const { [const { Parts { base: 0, ends: [0.0; 3], count: 0 } }; MOST_CELLS] }; 3];
    let mut counts = [0; 3];
    for axis in 0..3 {
        let [from, to] = [low[axis], high[axis]].map(|end| end.clamp(-FARTHEST, FARTHEST));
        if (to - from).is_nan() || to - from > MAX_BOX {
            return false;
        }
        let mut cell = from.floor();
        while cell <= to {
            parts[axis][counts[axis]] = Parts::of(from - cell, to - cell, cell as i32);
            (counts[axis], cell) = (counts[axis] + 1, cell + 1.0);
        }
    }
    for z in &parts[2][..counts[2]] {
        for y in &parts[1][..counts[1]] {
            for x in &parts[0][..counts[0]] {
                on([x, y, z]);
            }
        }
    }
    true
}

/// The part of an interval within a cell, in one piece or two.
struct Parts {
    /// The cell.
    base: i32,
    /// Ends of the pieces, from the base: one more than there are pieces.
    ends: [f64; 3],
    count: usize,
}

impl Parts {
    fn of(low: f64, high: f64, base: i32) -> Parts {
        let [from, to] = [low.max(0.0), high.min(1.0)];
        if to - from > PIECE {
            Parts { base, ends: [from, 0.5 * (from + to), to], count: 2 }
        } else {
            Parts { base, ends: [from, to, to], count: 1 }
        }
    }
}

/// Values and gradients at the corners of a cell.
fn corners(parts: [&Parts; 3], knots: Knots) -> [[f64; 4]; 8] {
    let cell = |corner: usize, axis: usize| (parts[axis].base as u32).wrapping_add((corner >> axis & 1) as u32);
    std::array::from_fn(|corner| knots.at([0, 1, 2].map(|axis| cell(corner, axis))))
}

/// Of a corner of a cell: the value in the middle of a piece, and its change from there to the end along each axis.
type Knot = [f64; 4];

#[inline(always)]
fn centered(corners: [[f64; 4]; 8], middle: [f64; 3], half: [f64; 3]) -> [Knot; 8] {
    let mut knots = [[0.0; 4]; 8];
    for (corner, (knot, [own, x, y, z])) in knots.iter_mut().zip(corners).enumerate() {
        let away = |axis: usize| middle[axis] - (corner >> axis & 1) as f64;
        let value = own + x * away(0) + y * away(1) + z * away(2);
        *knot = [value, x * half[0], y * half[1], z * half[2]];
    }
    knots
}

/// The range of values whose middle and changes are a knot.
#[inline(always)]
fn include_knot(range: &mut [f64; 2], [value, x, y, z]: Knot) {
    let reach = x.abs() + y.abs() + z.abs();
    *range = [range[0].min(value - reach), range[1].max(value + reach)];
}

impl Weights {
    /// Extends a range by that of the noise in a cell.
    fn include(self, all: &mut [f64; 2], parts: [&Parts; 3], knots: Knots) {
        let corners = corners(parts, knots);
        for piece in 0..parts[0].count * parts[1].count * parts[2].count {
            let (x, rest) = (piece % parts[0].count, piece / parts[0].count);
            let at = [x, rest % parts[1].count, rest / parts[1].count];
            let (mut middle, mut half, mut far) = ([0.0; 3], [0.0; 3], [[0.0; 2]; 3]);
            for axis in 0..3 {
                let [low, high] = [parts[axis].ends[at[axis]], parts[axis].ends[at[axis] + 1]];
                (middle[axis], half[axis]) = (0.5 * (low + high), 0.5 * (high - low));
                far[axis] = [self.fade(low).0, self.fade(high).0];
            }
            for knot in faded::<4>(faded::<2>(faded::<1>(centered(corners, middle, half), far[0]), far[1]), far[2]) {
                include_knot(all, knot);
            }
        }
    }

    /// Extends ranges by those of the gradient in a cell.
    fn include_gradient(self, all: &mut [[f64; 2]; 3], parts: [&Parts; 3], knots: Knots) {
        let (mut middle, mut half, mut far, mut steep) = ([0.0; 3], [0.0; 3], [[0.0; 2]; 3], [[0.0; 2]; 3]);
        for axis in 0..3 {
            let [low, high] = [parts[axis].ends[0], parts[axis].ends[parts[axis].count]];
            (middle[axis], half[axis]) = (0.5 * (low + high), 0.5 * (high - low));
            let [(from, rise), (to, fall)] = [self.fade(low), self.fade(high)];
            far[axis] = [from, to];
            // The slope of a weight rises up to the middle of the cell and falls behind it.
            let top = if low < 0.5 && high > 0.5 { self.fade(0.5).1 } else { rise.max(fall) };
            steep[axis] = [rise.min(fall), top];
        }
        let corners = corners(parts, knots);
        let directions = corners.map(|[_, x, y, z]| [x, y, z, 0.0]);
        let knots = centered(corners, middle, half);
        // The mean of the directions, and the slope of each weight times the difference that it interpolates.
        let means = faded::<4>(faded::<2>(faded::<1>(directions, far[0]), far[1]), far[2]);
        let across = [
            faded::<4>(faded::<2>(differences::<1>(knots), far[1]), far[2]),
            faded::<4>(faded::<1>(differences::<2>(knots), far[0]), far[2]),
            faded::<2>(faded::<1>(differences::<4>(knots), far[0]), far[1]),
        ];
        for axis in 0..3 {
            let (mut mean, mut step) = (EMPTY, EMPTY);
            for end in 0..8 {
                include_knot(&mut step, across[axis][end]);
                mean = [mean[0].min(means[end][axis]), mean[1].max(means[end][axis])];
            }
            let [flat, steep] = steep[axis];
            let low = mean[0] + if step[0] < 0.0 { steep * step[0] } else { flat * step[0] };
            let high = mean[1] + if step[1] > 0.0 { steep * step[1] } else { flat * step[1] };
            all[axis] = [all[axis][0].min(low), all[axis][1].max(high)];
        }
    }
}

/// Interpolates along an axis: each pair of sides becomes the values at both ends of a range of the far side's weight.
#[inline(always)]
fn faded<const AXIS: usize>(knots: [Knot; 8], [low, high]: [f64; 2]) -> [Knot; 8] {
    let mut found = knots;
    for near in 0..8 {
        if near & AXIS == 0 {
            for part in 0..4 {
                let (a, step) = (knots[near][part], knots[near | AXIS][part] - knots[near][part]);
                (found[near][part], found[near | AXIS][part]) = (a + low * step, a + high * step);
            }
        }
    }
    found
}

/// Far side minus near side along an axis, stored at both.
fn differences<const AXIS: usize>(knots: [Knot; 8]) -> [Knot; 8] {
    let of = |corner: usize| std::array::from_fn(|part| knots[corner | AXIS][part] - knots[corner & !AXIS][part]);
    [0, 1, 2, 3, 4, 5, 6, 7].map(of)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture_support::random::SplitMix;

    #[test]
    fn ranges_hold_every_value_and_gradient_and_are_narrow() {
        let mut random = SplitMix(11);
        let kinds = [Knots::Hashed(1 << 20), Knots::Hashed(4), Knots::Tables, Knots::Values];
        for (side, knots) in [1e-3, 0.05, 0.1, 0.2, 0.4, 0.8, 1.5].into_iter().flat_map(|s| kinds.map(|k| (s, k))) {
            // Of the value and of the gradient, over all boxes.
            let (mut widths, mut seen) = ([0.0; 2], [0.0; 2]);
            for number in 0..200 {
                let noise = Lattice { weights: [Weights::Cubic, Weights::Quintic][number % 2] };
                let low: [f64; 3] = std::array::from_fn(|_| 40.0 * random.unit() - 20.0);
                let high = low.map(|low| low + side * random.unit());
                let [x, y, z] = noise.gradient_range(knots, low, high);
                let ranges = [noise.range(knots, low, high), x, y, z];
                let mut found = [EMPTY; 4];
                for point in 0..500 {
                    let part: [f64; 3] = std::array::from_fn(|a| match point {
                        ..8 => f64::from(point >> a & 1),
                        _ => random.unit(),
                    });
                    let ([x, y, z], value) =
                        noise.sample_of(knots, [0, 1, 2].map(|a| low[a] + part[a] * (high[a] - low[a])));
                    assert!([x, y, z].iter().all(|along| along.abs() <= knots.steepest()), "{x} {y} {z} of {knots:?}");
                    for ((value, [least, most]), found) in [value, x, y, z].into_iter().zip(ranges).zip(&mut found) {
                        assert!((least..=most).contains(&value), "{value} in [{least}, {most}], {low:?} to {high:?}");
                        *found = [found[0].min(value), found[1].max(value)];
                    }
                }
                for (i, (range, found)) in ranges.into_iter().zip(found).enumerate() {
                    widths[i.min(1)] += range[1] - range[0];
                    seen[i.min(1)] += found[1] - found[0];
                }
            }
            let [value, gradient] = [0, 1].map(|i| widths[i] / seen[i]);
            println!("{side}, {knots:?}: {value:.2} and {gradient:.2} times as wide as seen");
            assert!(value < 3.0 && (gradient < 4.0 || side > 0.4), "{side}, {knots:?}: {value}, {gradient} times");
        }
    }
}
