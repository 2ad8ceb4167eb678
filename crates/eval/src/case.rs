//! Where on its segment the numbers of a lane pass integers, and the parts that it is cut into there.

/// Integers that a segment is cut at; each is one part more. Where it passes more, it is too long for narrow bounds.
const MOST: usize = 4;
/// A segment is cut so often: numbers that depend on cells are narrower in the parts, and pass integers elsewhere.
const CUTS: u32 = 2;
/// Integers are passed within so much of a segment, at most: more of it would be in two parts.
const WIDEST: f64 = 1.0 / 16.0;
/// Rounding of places.
const NEAR: f64 = 1e-9;
/// Before the segment and behind it, less the rounding that [`Case::is_end`] allows.
const OUTSIDE: [[f64; 2]; 2] = [[f64::NEG_INFINITY, -1.0 - NEAR], [1.0 + NEAR, f64::INFINITY]];

/// Where on its segment the numbers of a lane pass integers. Numbers that pass within some billionths of the segment pass
/// together: what is between them is shorter than rounding.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// From where to where, as many as `count`.
    passed: [[f64; 2]; MOST],
    count: usize,
    /// There are others, or it is not known where.
    more: bool,
    /// Numbers that pass an integer here lie where they are in the middle: the other side is in another part.
    ends: [[f64; 2]; 2],
    /// How often the segment was cut.
    cuts: u32,
}

impl Default for Case {
    fn default() -> Case {
        Case { passed: [[0.0; 2]; MOST], count: 0, more: false, ends: OUTSIDE, cuts: 0 }
    }
}

impl Case {
    /// Whether a number that passes an integer within these places may be taken as it is in the middle.
    pub(super) fn is_end(&mut self, [from, to]: [f64; 2]) -> bool {
        if self.ends.iter().any(|[low, high]| low - NEAR <= from && to <= high + NEAR) {
            return true;
        }
        let known = &self.passed[..self.count];
        // The same number again, as noise reads it for each of its components: it passes where it did. Of two that pass
        // somewhere in a wider range, one may be beyond its integer and the other not.
        let same = |[low, high]: &[f64; 2]| high - low < 4.0 * NEAR && low - NEAR <= from && to <= high + NEAR;
        if known.iter().any(same) {
            return false;
        }
        let apart = known.iter().all(|[low, high]| *high < from || to < *low);
        if to - from < WIDEST && apart && self.count < MOST {
            self.passed[self.count] = [from - NEAR, to + NEAR];
            self.count += 1;
        } else {
            self.more = true;
        }
        false
    }

    /// A number passes several integers.
    pub(super) fn skip(&mut self) {
        self.more = true;
    }

    /// Parts of the segment, from where to where, and the case of each.
    pub(super) fn parts(&self) -> Vec<([f64; 2], Case)> {
        if self.more || self.count == 0 || self.cuts == CUTS {
            return Vec::new();
        }
        let mut passed = self.passed[..self.count].to_vec();
        passed.sort_by(|a, b| a[0].total_cmp(&b[0]));
        passed.insert(0, OUTSIDE[0]);
        passed.push(OUTSIDE[1]);
        let parts = passed.windows(2).map(|ends| {
            let [from, to] = [ends[0][0].max(-1.0), ends[1][1].min(1.0)];
            let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
            let within = |place: f64| (place - middle) / half;
            (
                [from, to],
                Case { ends: [ends[0].map(within), ends[1].map(within)], cuts: self.cuts + 1, ..Case::default() },
            )
        });
        parts.filter(|([from, to], _)| from < to).collect()
    }
}
