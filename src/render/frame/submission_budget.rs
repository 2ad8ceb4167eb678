//! Sizes of submissions, and the points at which a picture may be stopped.
//!
//! Role: predicts from past submissions how many samples the next one may hold. Invariant: a submission takes at most
//! [`SUBMISSION_MS`] at the highest cost per sample of this picture and the previous one. Without measurements it is
//! small, and it never holds more than [`GROWTH`] times the samples of its predecessor.

use crate::render::error::RenderError;

/// Target time of a submission, milliseconds. Lower: the fixed cost shows. Higher: a desktop on this device stutters
/// (and resets it after two seconds), and interaction lags.
pub(crate) const SUBMISSION_MS: f64 = 25.0;
/// Largest growth from one submission to the next. Higher: empty regions predict too little cost for the following
/// ones.
pub const GROWTH: f64 = 4.0;
/// Samples of the first submission. Higher: too slow for the slowest modules on the slowest devices. Lower: the fixed
/// cost shows.
pub const FIRST: f64 = 65_536.0;
/// Shortest time that measures the cost of a sample, milliseconds; below, the fixed cost dominates.
const TELLING_MS: f64 = 0.15 * SUBMISSION_MS;

/// Number of samples in the next submission of a program.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SubmissionBudget {
    next: f64,
    /// Highest cost of a sample in the previous picture or so far in this one, milliseconds.
    dearest: Option<f64>,
    /// Highest cost of a sample in this picture, milliseconds.
    seen: Option<f64>,
    /// Samples of the largest submission that was too short to measure.
    light: f64,
    is_new: bool,
    /// Fixed size of every submission.
    #[cfg(test)]
    fixed: Option<f64>,
}

impl Default for SubmissionBudget {
    fn default() -> SubmissionBudget {
        SubmissionBudget {
            next: FIRST,
            dearest: None,
            seen: None,
            light: 0.0,
            is_new: true,
            #[cfg(test)]
            fixed: None,
        }
    }
}

impl SubmissionBudget {
    /// Budget with submissions of a fixed size.
    #[cfg(test)]
    pub(crate) fn fixed(samples: f64) -> SubmissionBudget {
        SubmissionBudget { fixed: Some(samples), ..SubmissionBudget::default() }
    }

    /// Starts a picture; returns whether it is the first.
    pub fn begin(&mut self) -> bool {
        let most = (self.light > 0.0).then_some(TELLING_MS / self.light);
        self.dearest = self.seen.take().or(self.dearest.map(|dearest| most.map_or(dearest, |most| dearest.min(most))));
        self.light = 0.0;
        std::mem::replace(&mut self.is_new, false)
    }

    /// Largest number of samples in the next submission.
    pub fn samples(&self) -> f64 {
        #[cfg(test)]
        if let Some(samples) = self.fixed {
            return samples;
        }
        self.dearest.map_or(self.next, |dearest| self.next.min(SUBMISSION_MS / dearest))
    }

    /// Records the samples and milliseconds of a submission.
    pub fn took(&mut self, samples: f64, ms: f64) {
        let asked = self.samples().max(samples);
        if ms >= TELLING_MS {
            let cost = ms / samples.max(1.0);
            self.seen = Some(self.seen.map_or(cost, |seen| seen.max(cost)));
            self.dearest = Some(self.dearest.map_or(cost, |dearest| dearest.max(cost)));
        } else {
            self.light = self.light.max(samples);
        }
        // A partial submission at the end of a picture can only lower the estimate.
        let most = if samples < 0.5 * asked { 1.0 } else { GROWTH };
        self.next = asked * (SUBMISSION_MS * samples / asked / ms.max(1e-3)).min(most);
    }
}

/// Control over the submissions of a picture.
pub(crate) struct SubmissionControl<'a> {
    /// Sizes of submissions.
    pub budget: &'a mut SubmissionBudget,
    /// Whether the picture ends unfinished; called before each submission with the milliseconds on the device and the part
    /// that is done.
    pub stop: &'a dyn Fn(f64, f32) -> bool,
}

impl SubmissionControl<'_> {
    pub(crate) fn check(&self, ms: f64, part: f32) -> Result<(), RenderError> {
        if (self.stop)(ms, part) { Err(RenderError::Stopped) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Submissions of a picture as pairs of samples and milliseconds; `cost` maps the finished share to the cost of a
    /// sample.
    fn picture(budget: &mut SubmissionBudget, samples: f64, cost: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        budget.begin();
        let (mut done, mut all) = (0.0, Vec::new());
        while done < samples {
            let taken = budget.samples().min(samples - done);
            let ms = 0.3 + taken * cost(done / samples);
            budget.took(taken, ms);
            all.push([taken, ms]);
            done += taken;
        }
        all
    }

    const DEAR: f64 = 1e-5; // milliseconds of a sample
    const WHOLE: f64 = 3e8;

    #[test]
    fn an_empty_start_does_not_inflate_the_next_submission() {
        let cost = |done: f64| if done < 0.3 { 1e-9 } else { DEAR };
        let mut budget = SubmissionBudget::default();
        picture(&mut budget, 1e7, |_| DEAR); // a preview
        for _ in 0..2 {
            let all = picture(&mut budget, WHOLE, cost);
            let longest = all.iter().map(|[_, ms]| *ms).fold(0.0, f64::max);
            assert!(longest < 1.5 * SUBMISSION_MS, "{longest}");
        }
    }

    #[test]
    fn submissions_start_small_and_grow_to_their_budget() {
        for cost in [1e-9, 1e-7, 1e-6, 1e-4] {
            let all = picture(&mut SubmissionBudget::default(), WHOLE.min(100.0 * SUBMISSION_MS / cost), |_| cost);
            assert!(all[0][0] <= FIRST);
            let grown = |pair: &[[f64; 2]]| pair[1][0] <= GROWTH * pair[0][0] * 1.001;
            assert!(all.windows(2).all(grown), "{cost}");
            assert!(all.iter().all(|[_, ms]| *ms < 1.1 * SUBMISSION_MS), "{cost}");
            let few = 12.0 + 1.3 * all.iter().map(|[_, ms]| ms).sum::<f64>() / SUBMISSION_MS;
            assert!((all.len() as f64) < few, "{cost}: {} submissions", all.len());
        }
    }

    #[test]
    fn what_was_dear_is_forgotten_with_the_pictures_after_it() {
        let mut budget = SubmissionBudget::default();
        picture(&mut budget, 1e8, |_| DEAR);
        (0..3).for_each(|_| drop(picture(&mut budget, 1e9, |_| DEAR / 50.0)));
        let cheap = picture(&mut budget, 1e9, |_| DEAR / 50.0);
        assert!(cheap.len() < 15, "{}", cheap.len());
    }
}
