//! A quick sweep goes on where it is worth it: with more samples along the front.

use super::Row;
use super::candidates::{Candidate, Curve};
use super::front::{front, still_falls};
use hypertexture::shader::Library;
use std::time::Duration;

/// An error of the scene's own truth that ends the sweep.
const FINAL_ERROR: f64 = 1e-3;
/// Wall clock after which no further samples are begun.
pub(super) const BUDGET: Duration = Duration::from_secs(60);

/// The curves on the front of the scene's own truth that more samples still help, each with twice its most samples and
/// with the place of its finest row; none once an error is small enough. What the check refuses is left out.
pub(super) fn finer(rows: &[(usize, Row)], library: &Library) -> Vec<(usize, Candidate)> {
    let own: Vec<&(usize, Row)> = rows.iter().filter(|(_, row)| row.truth.is_own).collect();
    let points: Vec<(f64, f64)> = own.iter().map(|(_, row)| row.point()).collect();
    if points.iter().any(|point| point.1 <= FINAL_ERROR) {
        return Vec::new();
    }
    let mut curves: Vec<Curve> = Vec::new();
    for curve in front(&points).into_iter().map(|index| own[index].1.candidate.curve()) {
        if !curves.contains(&curve) {
            curves.push(curve);
        }
    }
    let double = |curve: Curve| {
        let mut of: Vec<&&(usize, Row)> = own.iter().filter(|(_, row)| row.candidate.curve() == curve).collect();
        of.sort_by_key(|(_, row)| row.candidate.samples());
        let errors: Vec<(f64, f64)> =
            of.iter().map(|(_, row)| (f64::from(row.candidate.samples()), row.point().1)).collect();
        let (place, finest) = of.last().filter(|_| still_falls(&errors))?;
        let mut candidate = finest.candidate.clone();
        candidate.scene.quality.samples *= 2;
        candidate.scene.check(library).ok().map(|_| (*place, candidate))
    };
    curves.into_iter().filter_map(double).collect()
}

#[cfg(test)]
mod tests {
    use super::super::report::examples;
    use super::*;
    use hypertexture::shader;
    use std::sync::Arc;

    /// Rows of rays alone, with errors of points and segments at 16, 32 and 64 samples.
    fn rows(points: [f64; 3], segments: [f64; 3]) -> Vec<(usize, Row)> {
        let is = |row: &Row, rule: &str| row.candidate.label().starts_with(&format!("encoded 64³, march, {rule},"));
        let all = examples::report().comparison.rows;
        let of = |rule: &str, errors: [f64; 3]| -> Vec<(usize, Row)> {
            let rows = all.iter().filter(|row| is(row, rule)).cloned().zip(errors);
            rows.enumerate()
                .map(|(place, (mut row, error))| {
                    row.metrics.errors.rmse = error;
                    (place, row)
                })
                .collect()
        };
        [of("point", points), of("segment", segments)].concat()
    }

    fn labels(rows: &[(usize, Row)]) -> Vec<String> {
        finer(rows, &shader::shipped())
            .iter()
            .map(|(place, candidate)| format!("{place} {}", candidate.label()))
            .collect()
    }

    #[test]
    fn curves_that_still_fall_are_doubled_until_the_error_is_small() {
        // Points are on the front with 16 samples, segments with 32 and 64; both take as long.
        let both = rows([0.1, 0.06, 0.04], [0.2, 0.05, 0.01]);
        let expected = ["2 encoded 64³, march, point, 128 samples", "2 encoded 64³, march, segment, 128 samples"];
        assert_eq!(labels(&both), expected);
        assert_eq!(labels(&rows([0.1, 0.1, 0.1], [0.2, 0.05, 0.01])), expected[1..], "points have met their floor");
        assert_eq!(labels(&rows([0.1, 0.06, 0.04], [0.2, 0.05, 0.001])), [""; 0], "enough");
    }

    #[test]
    fn other_truths_and_refused_samples_are_not_doubled() {
        let mut other = rows([0.1, 0.06, 0.04], [0.2, 0.05, 0.01]);
        for (_, row) in &mut other {
            Arc::make_mut(&mut row.truth).is_own = false;
        }
        assert_eq!(labels(&other), [""; 0]);
        let mut most = rows([0.1, 0.06, 0.04], [0.2, 0.05, 0.01]);
        for (_, row) in &mut most {
            row.candidate.scene.quality.samples *= 1000;
        }
        let refused = labels(&most);
        assert!(refused.is_empty(), "a ray has at most 100000 samples: {refused:?}");
    }
}
