//! The range of the noise over a box.
//!
//! Role: bounds as tight as a block of texels gives, without a block. Invariant: every value of [`Lattice::sample_of`] in the
//! box lies in the range. Within a cell the noise is linear in each of six numbers, the weights of its far sides and the place
//! in the box, so that over all of them its extremes are at their ends.

use super::lattice::{FARTHEST, Lattice};
use super::{Knots, NOISE_BOUND, Weights};

/// Boxes that are looked at on their own are at most so long, in lattice cells. Less: slower. More: wider ranges.
const PIECE: f64 = 0.5;
/// A box that is longer has the range of all noise. More: hardly narrower, and much slower.
const LONGEST: f64 = 1.5;
/// Cells that such a box reaches into along an axis.
const MOST_CELLS: usize = 3;
/// What f64 rounds, and GLSL in its constants, which have 32 bits.
pub const ROUNDED: f64 = 1e-7;

impl Lattice {
    /// Bounds of the value of the noise of these knots over a box, in lattice cells.
    pub fn range(self, knots: Knots, low: [f64; 3], high: [f64; 3]) -> [f64; 2] {
        let Some((parts, counts)) = parts(low, high) else { return [-NOISE_BOUND, NOISE_BOUND] };
        let mut all = [f64::INFINITY, f64::NEG_INFINITY];
        for z in &parts[2][..counts[2]] {
            for y in &parts[1][..counts[1]] {
                for x in &parts[0][..counts[0]] {
                    self.weights.include(&mut all, [x, y, z], knots);
                }
            }
        }
        [(all[0] - ROUNDED).max(-NOISE_BOUND), (all[1] + ROUNDED).min(NOISE_BOUND)]
    }
}

/// The parts of a box within cells, by axis, and how many; none of a box that is too long.
pub(super) fn parts(low: [f64; 3], high: [f64; 3]) -> Option<([[Parts; MOST_CELLS]; 3], [usize; 3])> {
    let mut parts = [const { [const { Parts { base: 0, ends: [0.0; 3], count: 0 } }; MOST_CELLS] }; 3];
    let mut counts = [0; 3];
    for axis in 0..3 {
        let [from, to] = [low[axis], high[axis]].map(|end| end.clamp(-FARTHEST, FARTHEST));
        if (to - from).is_nan() || to - from > LONGEST {
            return None;
        }
        let mut cell = from.floor();
        while cell <= to {
            parts[axis][counts[axis]] = Parts::of(from - cell, to - cell, cell as i32);
            (counts[axis], cell) = (counts[axis] + 1, cell + 1.0);
        }
    }
    Some((parts, counts))
}

/// The part of a range within a cell, in one piece or two.
pub(super) struct Parts {
    pub(super) base: i32,
    /// Of the pieces, from the base: as many as there are and one more.
    ends: [f64; 3],
    count: usize,
}

impl Parts {
    /// From where to where.
    pub(super) fn whole(&self) -> [f64; 2] {
        [self.ends[0], self.ends[self.count]]
    }

    fn of(low: f64, high: f64, base: i32) -> Parts {
        let [from, to] = [low.max(0.0), high.min(1.0)];
        match to - from > PIECE {
            true => Parts { base, ends: [from, 0.5 * (from + to), to], count: 2 },
            false => Parts { base, ends: [from, to, to], count: 1 },
        }
    }
}

/// At a corner of a cell: the value in the middle of a piece, and how far it is from there to the ends along each axis.
pub(super) type Knot = [f64; 4];

impl Weights {
    /// Takes in the range over the part of a cell.
    fn include(self, all: &mut [f64; 2], parts: [&Parts; 3], of: Knots) {
        let mut corners = [[0.0; 4]; 8];
        for (corner, found) in corners.iter_mut().enumerate() {
            let place = |axis: usize| (parts[axis].base as u32).wrapping_add((corner >> axis & 1) as u32);
            *found = of.at([0, 1, 2].map(place));
        }
        for piece in 0..parts[0].count * parts[1].count * parts[2].count {
            let (x, rest) = (piece % parts[0].count, piece / parts[0].count);
            let at = [x, rest % parts[1].count, rest / parts[1].count];
            let (mut middle, mut half, mut far) = ([0.0; 3], [0.0; 3], [[0.0; 2]; 3]);
            for axis in 0..3 {
                let [low, high] = [parts[axis].ends[at[axis]], parts[axis].ends[at[axis] + 1]];
                (middle[axis], half[axis]) = (0.5 * (low + high), 0.5 * (high - low));
                far[axis] = [self.fade(low).0, self.fade(high).0];
            }
            let mut knots = [[0.0; 4]; 8];
            for (corner, (knot, [own, x, y, z])) in knots.iter_mut().zip(corners).enumerate() {
                let away = |axis: usize| middle[axis] - (corner >> axis & 1) as f64;
                let value = own + x * away(0) + y * away(1) + z * away(2);
                *knot = [value, x * half[0], y * half[1], z * half[2]];
            }
            for [value, x, y, z] in faded::<4>(faded::<2>(faded::<1>(knots, far[0]), far[1]), far[2]) {
                let reach = x.abs() + y.abs() + z.abs();
                *all = [all[0].min(value - reach), all[1].max(value + reach)];
            }
        }
    }
}

/// Along one axis, the pairs of sides become the pairs of ends of a range of the weight of the far side.
#[inline(always)]
pub(super) fn faded<const AXIS: usize>(knots: [Knot; 8], [low, high]: [f64; 2]) -> [Knot; 8] {
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

#[cfg(test)]
mod tests {
    use super::*;
    use support::random::SplitMix;

    #[test]
    fn no_value_in_a_box_is_outside_of_its_range_and_ranges_are_narrow() {
        let mut random = SplitMix(11);
        let kinds = [Knots::Hashed(1 << 20), Knots::Hashed(4), Knots::Tables, Knots::Values];
        for (side, knots) in [1e-3, 0.05, 0.1, 0.2, 0.4, 0.8, 1.5].into_iter().flat_map(|s| kinds.map(|k| (s, k))) {
            let (mut width, mut seen) = (0.0, 0.0);
            for number in 0..200 {
                let noise = Lattice { weights: [Weights::Cubic, Weights::Quintic][number % 2] };
                let low: [f64; 3] = std::array::from_fn(|_| 40.0 * random.unit() - 20.0);
                let high = low.map(|low| low + side * random.unit());
                let [least, most] = noise.range(knots, low, high);
                let mut found = [f64::INFINITY, f64::NEG_INFINITY];
                for point in 0..500 {
                    let part: [f64; 3] = std::array::from_fn(|a| match point {
                        ..8 => f64::from(point >> a & 1),
                        _ => random.unit(),
                    });
                    let (slope, value) =
                        noise.sample_of(knots, [0, 1, 2].map(|a| low[a] + part[a] * (high[a] - low[a])));
                    assert!((least..=most).contains(&value), "{value} in [{least}, {most}], {low:?} to {high:?}");
                    assert!(slope.iter().all(|along| along.abs() <= knots.steepest()), "{slope:?} of {knots:?}");
                    found = [found[0].min(value), found[1].max(value)];
                }
                (width, seen) = (width + most - least, seen + found[1] - found[0]);
            }
            println!("{side}, {knots:?}: {:.2} times as wide as what is seen, {:.3}", width / seen, seen / 200.0);
            assert!(width < 3.0 * seen, "{side}, {knots:?}: {} times", width / seen);
        }
    }
}
