//! Bounds case by case: where numbers pass integers.
//!
//! Role: a segment that crosses a border of lattice cells has no narrow bounds as a whole, however short it is, because
//! what a cell is hashed to may be anything; before and behind the border it has. Where a number passes an integer is
//! read off its affine form, up to what is not linear in it; both parts reach over that.
//! Invariant: each place of a segment is in a part in which every number is taken on the side where it is there.

use super::affine::Affine;
use super::case::Case;
use super::interval::Interval;
use super::segment::SegmentBounds;
use super::{BoundProgram, ExactError, Lanes};

impl BoundProgram<'_> {
    /// Bounds of what [`Program::read_channel`](super::Program::read_channel) left, in every lane. Lanes whose bounds are
    /// `open` are computed case by case.
    ///
    /// # Errors
    /// As [`BoundProgram::run`].
    pub fn bounds(
        &self,
        lanes: &Lanes<Affine>,
        open: &dyn Fn(usize, SegmentBounds) -> bool, // not generic: callers would compile the machine again
    ) -> Result<Vec<SegmentBounds>, ExactError> {
        let mut of: Vec<usize> = (0..lanes.fragment_coordinates.len()).collect();
        let mut found: Vec<Option<SegmentBounds>> = vec![None; of.len()];
        let (mut lanes, mut cases) = (lanes.clone(), vec![Case::default(); of.len()]);
        while !of.is_empty() {
            let mut outputs = self.evaluate(&lanes, &mut cases, None)?.0;
            let values = outputs.pop_first().map(|(_, values)| values).unwrap_or_default();
            let mut next: Vec<(usize, usize, [f64; 2], Case)> = Vec::new();
            for (at, [value, ..]) in values.into_iter().enumerate() {
                let (lane, own) = (of[at], value.bounds());
                let parts = if open(lane, own) { cases[at].parts() } else { Vec::new() };
                if parts.is_empty() {
                    found[lane] = Some(found[lane].map_or(own, |found| found.join(own)));
                }
                next.extend(parts.into_iter().map(|(part, case)| (at, lane, part, case)));
            }
            let part = |values: &Vec<[Affine; 4]>| -> Vec<[Affine; 4]> {
                next.iter().map(|(at, _, part, _)| values[*at].map(|value| value.part(*part))).collect()
            };
            lanes = Lanes {
                fragment_coordinates: part(&lanes.fragment_coordinates),
                varyings: lanes.varyings.iter().map(|(location, values)| (*location, part(values))).collect(),
            };
            (of, cases) = next.into_iter().map(|(_, lane, _, case)| (lane, case)).unzip();
        }
        Ok(found.into_iter().map(|value| value.unwrap_or(SegmentBounds::of(Interval::WHOLE))).collect())
    }
}
