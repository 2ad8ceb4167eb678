//! Answers: the fastest candidate within an error, and those that the times do not tell from it.

use super::Row;
use super::front::cheapest;
use serde::Serialize;

/// Errors that the fastest candidate is asked for.
const BOUNDS: [f64; 3] = [1e-1, 1e-2, 1e-3];

/// The fastest candidate within an error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// The largest error.
    pub error_at_most: f64,
    /// Index of the fastest row, if there is any.
    pub candidate: Option<usize>,
    /// Other rows within the error whose interval of time overlaps that of the fastest.
    pub not_separable: Vec<usize>,
}

/// The answers for rows of one truth, by falling error. What blending may lose must lie within the error beforehand:
/// drivers round in their own ways, and a measurement of one of them promises nothing.
pub fn answers(rows: &[Row], of: &[usize]) -> Vec<Answer> {
    let answer = |bound: f64| {
        let safe = of.iter().copied().filter(|&index| rows[index].candidate.blend_bound() <= bound);
        let within: Vec<usize> = safe.filter(|&index| rows[index].point().1 <= bound).collect();
        let points: Vec<(f64, f64)> = within.iter().map(|&index| rows[index].point()).collect();
        let candidate = cheapest(&points, bound).map(|place| within[place]);
        let is_like = |&other: &usize| {
            candidate.is_some_and(|best| other != best && rows[other].time().overlaps(&rows[best].time()))
        };
        let not_separable = within.iter().copied().filter(is_like).collect();
        Answer { error_at_most: bound, candidate, not_separable }
    };
    BOUNDS.into_iter().map(answer).collect()
}
