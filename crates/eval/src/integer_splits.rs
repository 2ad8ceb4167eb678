//! Positions on a segment where numbers cross integers, and the parts between them.

/// Most integers that a segment is split at. Higher: one more part each; longer segments have wide bounds anyway.
const MAX_SPLITS: usize = 4;
/// Most times that a segment is split. Numbers that depend on lattice cells are narrower in the parts and cross integers
/// elsewhere.
const SPLITS: u32 = 2;
/// Widest position of a crossing, in units of the segment. Higher: more of the segment is in two parts.
const WIDEST: f64 = 1.0 / 16.0;
/// Rounding of positions.
const NEAR: f64 = 1e-9;
/// The positions before and behind the segment, less the rounding that [`IntegerSplits::is_end`] allows.
const OUTSIDE: [[f64; 2]; 2] = [[f64::NEG_INFINITY, -1.0 - NEAR], [1.0 + NEAR, f64::INFINITY]];

/// Crossings of integers by the numbers of one lane. Crossings within some billionths of the segment count as one.
#[derive(Clone, Copy, Debug)]
pub struct IntegerSplits {
    /// Ranges of the first `count` crossings.
    crossings: [[f64; 2]; MAX_SPLITS],
    count: usize,
    /// Whether there are others, or crossings without a known position.
    is_incomplete: bool,
    /// Ranges of crossings at the ends of this part, whose other sides are in the adjacent parts.
    ends: [[f64; 2]; 2],
    /// Number of splits so far.
    depth: u32,
}

impl Default for IntegerSplits {
    fn default() -> IntegerSplits {
        IntegerSplits { crossings: [[0.0; 2]; MAX_SPLITS], count: 0, is_incomplete: false, ends: OUTSIDE, depth: 0 }
    }
}

impl IntegerSplits {
    /// Whether a crossing in this range is at an end of the part, so that the number stays on its side at the middle.
    /// Notes the crossing otherwise.
    pub(crate) fn is_end(&mut self, [from, to]: [f64; 2]) -> bool {
        if self.ends.iter().any(|[low, high]| low - NEAR <= from && to <= high + NEAR) {
            return true;
        }
        let known = &self.crossings[..self.count];
        // Noise reads a number once for each component: a narrow crossing repeats. Wide ones may be of two numbers.
        let same = |[low, high]: &[f64; 2]| high - low < 4.0 * NEAR && low - NEAR <= from && to <= high + NEAR;
        if known.iter().any(same) {
            return false;
        }
        let apart = known.iter().all(|[low, high]| *high < from || to < *low);
        if to - from < WIDEST && apart && self.count < MAX_SPLITS {
            self.crossings[self.count] = [from - NEAR, to + NEAR];
            self.count += 1;
        } else {
            self.is_incomplete = true;
        }
        false
    }

    /// Notes a number that crosses several integers.
    pub(crate) fn skip(&mut self) {
        self.is_incomplete = true;
    }

    /// The parts of the segment, each with its range and its splits; none if splitting does not help.
    pub(crate) fn parts(&self) -> Vec<([f64; 2], IntegerSplits)> {
        if self.is_incomplete || self.count == 0 || self.depth == SPLITS {
            return Vec::new();
        }
        let mut crossings = self.crossings[..self.count].to_vec();
        crossings.sort_by(|a, b| a[0].total_cmp(&b[0]));
        crossings.insert(0, OUTSIDE[0]);
        crossings.push(OUTSIDE[1]);
        let parts = crossings.windows(2).map(|ends| {
            let [from, to] = [ends[0][0].max(-1.0), ends[1][1].min(1.0)];
            let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
            let within = |place: f64| (place - middle) / half;
            (
                [from, to],
                IntegerSplits {
                    ends: [ends[0].map(within), ends[1].map(within)],
                    depth: self.depth + 1,
                    ..IntegerSplits::default()
                },
            )
        });
        parts.filter(|([from, to], _)| from < to).collect()
    }
}
