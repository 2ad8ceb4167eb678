//! Bounds along segments, split where numbers cross integers.
//!
//! Role: a segment across a border of lattice cells has wide bounds however short it is, because the hash of a cell may be
//! anything; on either side of the border they are narrow. The affine form of a number gives the position of the crossing
//! up to its rest; both parts include that uncertainty.
//! Invariant: for each position on a segment there is a part in which every number is on its actual side of an integer.

use crate::bind::BoundProgram;
use crate::error::ExactError;
use crate::evaluate::Invocations;
use crate::integer_splits::IntegerSplits;
use crate::numbers::affine::Affine;
use crate::numbers::interval::Interval;
use crate::numbers::segment_bounds::SegmentBounds;

impl BoundProgram<'_> {
    /// Bounds of the channel of [`Program::read_channel`](crate::Program::read_channel) along each segment. Segments whose
    /// bounds are `open` are split.
    ///
    /// # Errors
    /// As [`BoundProgram::run`].
    pub fn bounds(
        &self,
        lanes: &Invocations<Affine>,
        open: &dyn Fn(usize, SegmentBounds) -> bool, // dyn: generic callers would compile the evaluator again
    ) -> Result<Vec<SegmentBounds>, ExactError> {
        let mut of: Vec<usize> = (0..lanes.fragment_coordinates.len()).collect();
        let mut found: Vec<Option<SegmentBounds>> = vec![None; of.len()];
        let (mut lanes, mut splits) = (lanes.clone(), vec![IntegerSplits::default(); of.len()]);
        while !of.is_empty() {
            let mut outputs = self.evaluate(&lanes, &mut splits, None)?.0;
            let values = outputs.pop_first().map(|(_, values)| values).unwrap_or_default();
            let mut next: Vec<(usize, usize, [f64; 2], IntegerSplits)> = Vec::new();
            for (at, [value, ..]) in values.into_iter().enumerate() {
                let (lane, own) = (of[at], value.bounds());
                let parts = if open(lane, own) { splits[at].parts() } else { Vec::new() };
                if parts.is_empty() {
                    found[lane] = Some(found[lane].map_or(own, |found| found.join(own)));
                }
                next.extend(parts.into_iter().map(|(part, splits)| (at, lane, part, splits)));
            }
            let part = |values: &Vec<[Affine; 4]>| -> Vec<[Affine; 4]> {
                next.iter().map(|(at, _, part, _)| values[*at].map(|value| value.part(*part))).collect()
            };
            lanes = Invocations {
                fragment_coordinates: part(&lanes.fragment_coordinates),
                varyings: lanes.varyings.iter().map(|(location, values)| (*location, part(values))).collect(),
            };
            (of, splits) = next.into_iter().map(|(_, lane, _, splits)| (lane, splits)).unzip();
        }
        Ok(found.into_iter().map(|value| value.unwrap_or(SegmentBounds::of(Interval::WHOLE))).collect())
    }
}
