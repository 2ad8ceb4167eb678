//! What pictures of a curve say about others of it, in numbers.

use super::{SAMPLES, VERIFIED};

/// After two whole pictures of a curve that fail, the next one has so many times the samples.
const STRIDE: f64 = 1.4;
/// Times that differ by less than this factor are close: a machine is disturbed by as much.
const CLOSE: f64 = 1.5;
/// The highest order in the step that a picture has, and that of an error which few pixels have.
pub(super) const ORDER: f64 = 2.0;
pub(super) const STUCK: f64 = 1.0;
/// An error that twice the samples leave at this part of what it was is one that no samples remove, or that few pixels have;
/// fewer samples than [`FLAT_FROM`] say nothing about it.
const STAYS: f64 = 0.85;
const FLAT_FROM: u32 = 128;

/// When it is late, a small picture whose error is below so many times the one that it may have is near enough for a whole one.
pub(super) const NEAR: f64 = 1.5;

/// Whether the error of a curve stays what it was, by its samples and errors before and now.
pub(super) fn stays((fewer, before): (u32, f64), (samples, now): (u32, f64)) -> bool {
    samples >= FLAT_FROM.max(2 * fewer) && now > STAYS * before
}

/// The fewest samples that may do where so many have an error of `times` the one that they may have.
pub(super) fn next(samples: u32, times: f64) -> f64 {
    (f64::from(samples) * times.powf(1.0 / ORDER)).max(f64::from(samples) + 1.0)
}

/// The fewest samples that whole pictures of a curve do not speak against which failed: of each its samples, and its error in
/// parts of the one that it may have. More than they had, and no fewer than would do if the error went down by [`ORDER`].
/// After two of them, or where it `is_stuck`, small pictures are worth little, as a few pixels have most of the error: then
/// not a few more either, unless there are no more.
pub(super) fn least_hopeful(failed: &[(u32, f64)], is_stuck: bool) -> u32 {
    let Some((most, error)) = failed.iter().copied().max_by_key(|(samples, _)| *samples) else { return 1 };
    let stride = if failed.len() >= 2 || is_stuck { STRIDE } else { 1.0 };
    let order = if is_stuck { STUCK } else { ORDER };
    let next = f64::from(most) * stride.max(error.powf(1.0 / order));
    (next.min(f64::from(SAMPLES[1])).ceil() as u32).max(most + 1)
}

/// Whether no more whole pictures are held against the reference, after so many.
pub(super) fn has_ended(verified: usize, is_found: bool, is_late: bool) -> bool {
    let is_long = verified >= VERIFIED;
    is_found && (is_late || is_long) || is_late && is_long
}

/// Of curves and times, the fastest first, those that are too close to the fastest to tell which is: each curve once, and
/// none where the fastest is alone.
pub(super) fn close<C: PartialEq>(times: &[(C, f64)]) -> Vec<usize> {
    let is_first = |index: usize| times[..index].iter().all(|(curve, _)| *curve != times[index].0);
    let limit = times.first().map_or(0.0, |(_, fastest)| CLOSE * fastest);
    let close: Vec<usize> = (0..times.len()).filter(|&index| times[index].1 <= limit && is_first(index)).collect();
    if close.len() < 2 { Vec::new() } else { close }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn after_a_failure_fewer_samples_are_not_tried_and_after_two_nor_are_a_few_more() {
        let near = |failed: &[u32]| failed.iter().map(|samples| (*samples, 1.01)).collect::<Vec<_>>();
        let tried = |failed: &[u32]| {
            [50, 100, 101, 139, 142, 400].map(|samples| samples >= least_hopeful(&near(failed), false))
        };
        assert_eq!(tried(&[]), [true; 6]);
        assert_eq!(tried(&[100]), [false, false, true, true, true, true]);
        assert_eq!(tried(&[100, 40]), [false, false, false, false, true, true]);
        assert_eq!(tried(&[100, 280]), [false, false, false, false, false, true]);
        let last = SAMPLES[1];
        assert_eq!(least_hopeful(&near(&[last - 1, last - 2]), false), last, "the most there are");
        assert!(least_hopeful(&near(&[last, last - 1]), false) > last);
        assert_eq!(least_hopeful(&[(100, 9.0)], false), 300, "an error of 9 times the bound needs 3 times the samples");
        assert_eq!(least_hopeful(&[(100, 9.0)], true), 900, "and 9 times as many where few pixels have it");
        assert_eq!(least_hopeful(&[(40, 100.0), (100, 1.1)], false), 140, "that of the most samples counts");
    }

    #[test]
    fn whole_pictures_are_looked_at_while_none_keeps_the_bound_and_it_is_early() {
        let ends = |verified| {
            [[false, false], [false, true], [true, false], [true, true]]
                .map(|[found, late]| has_ended(verified, found, late))
        };
        assert_eq!(ends(VERIFIED - 1), [false, false, false, true], "late alone ends nothing before a bound is kept");
        assert_eq!(ends(VERIFIED), [false, true, true, true]);
    }

    #[test]
    fn an_error_stays_that_twice_the_samples_leave_as_it_was() {
        assert!(stays((64, 1e-2), (128, 1e-2)) && stays((128, 1e-2), (512, 2e-2)));
        assert!(!stays((64, 1e-2), (128, 8e-3)), "it goes down, if slowly");
        assert!(!stays((100, 1e-2), (199, 1e-2)), "of not twice as many samples");
        assert!(!stays((8, 1e-2), (127, 1e-2)), "of so few samples all pictures are wrong");
    }

    #[test]
    fn close_times_are_those_of_other_curves_within_half_of_the_fastest() {
        assert_eq!(close(&[("a", 10.0), ("a", 11.0), ("b", 12.0), ("b", 13.0), ("c", 15.0), ("d", 15.1)]), [0, 2, 4]);
        assert_eq!(close(&[("a", 10.0), ("a", 11.0), ("b", 16.0)]), [0; 0]);
        assert_eq!(close::<u8>(&[]), [0; 0]);
    }
}
