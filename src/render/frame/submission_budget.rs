//! How the work of a picture is cut into submissions, and where it may end.
//!
//! Role: what submissions have taken -> how many samples the next one may hold. Invariant: a submission holds no more than
//! what takes [`SUBMISSION_MS`] where it is as dear as the dearest of this picture and of the one before; where nothing is
//! known, it holds few, and never [`GROWTH`] times as many as the one before.

use crate::render::error::RenderError;

/// A submission should take about this many milliseconds. Shorter: the fixed cost of one shows. Longer: a desktop that
/// shares the device stutters, and after two seconds it resets it; a hand that moves waits for as long.
pub const SUBMISSION_MS: f64 = 25.0;
/// A submission holds at most this many times the samples of the one before. More: what is empty says too much of what
/// follows.
pub const GROWTH: f64 = 4.0;
/// Samples of the first submission ever. More: the slowest modules on the slowest devices take too long. Fewer: the fixed
/// cost shows.
pub const FIRST: f64 = 65_536.0;
/// Submissions that take less than this, milliseconds, say nothing of what a sample costs: their fixed cost is as large.
const TELLING_MS: f64 = 0.15 * SUBMISSION_MS;

/// How many samples submissions of a program hold, by what those before have taken.
#[derive(Clone, Debug, PartialEq)]
pub struct SubmissionBudget {
    next: f64,
    /// Milliseconds of a sample where it is dearest: in the picture before, or so far in this one.
    dearest: Option<f64>,
    /// The same in this picture alone.
    seen: Option<f64>,
    /// Samples of its largest submission that took too little to say what a sample costs.
    light: f64,
    is_new: bool,
    /// Samples of every submission, whatever it takes.
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
    /// Submissions of so many samples each.
    #[cfg(test)]
    pub(crate) fn fixed(samples: f64) -> SubmissionBudget {
        SubmissionBudget { fixed: Some(samples), ..SubmissionBudget::default() }
    }

    /// Begins a picture; whether it is the first.
    pub fn begin(&mut self) -> bool {
        let most = (self.light > 0.0).then_some(TELLING_MS / self.light);
        self.dearest = self.seen.take().or(self.dearest.map(|dearest| most.map_or(dearest, |most| dearest.min(most))));
        self.light = 0.0;
        std::mem::replace(&mut self.is_new, false)
    }

    /// How many samples the next submission may hold.
    pub fn samples(&self) -> f64 {
        #[cfg(test)]
        if let Some(samples) = self.fixed {
            return samples;
        }
        self.dearest.map_or(self.next, |dearest| self.next.min(SUBMISSION_MS / dearest))
    }

    /// A submission of so many samples has taken so many milliseconds.
    pub fn took(&mut self, samples: f64, ms: f64) {
        let asked = self.samples().max(samples);
        if ms >= TELLING_MS {
            let cost = ms / samples.max(1.0);
            self.seen = Some(self.seen.map_or(cost, |seen| seen.max(cost)));
            self.dearest = Some(self.dearest.map_or(cost, |dearest| dearest.max(cost)));
        } else {
            self.light = self.light.max(samples);
        }
        // What ends with the picture says that more is too much, not that more would do.
        let most = if samples < 0.5 * asked { 1.0 } else { GROWTH };
        self.next = asked * (SUBMISSION_MS * samples / asked / ms.max(1e-3)).min(most);
    }
}

/// How a picture is cut into submissions, and whether it goes on.
pub struct SubmissionControl<'a> {
    /// What those before have taken.
    pub pace: &'a mut SubmissionBudget,
    /// Whether the picture ends unfinished, after so many milliseconds on the device; asked before each submission.
    pub stop: &'a dyn Fn(f64) -> bool,
}

impl SubmissionControl<'_> {
    pub(crate) fn check(&self, ms: f64) -> Result<(), RenderError> {
        if (self.stop)(ms) { Err(RenderError::Stopped) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Submissions of a picture whose samples cost what `cost` says of how much of it is done: samples and milliseconds.
    fn picture(pace: &mut SubmissionBudget, samples: f64, cost: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        pace.begin();
        let (mut done, mut all) = (0.0, Vec::new());
        while done < samples {
            let taken = pace.samples().min(samples - done);
            let ms = 0.3 + taken * cost(done / samples);
            pace.took(taken, ms);
            all.push([taken, ms]);
            done += taken;
        }
        all
    }

    const DEAR: f64 = 1e-5; // milliseconds of a sample
    const WHOLE: f64 = 3e8;

    #[test]
    fn an_empty_beginning_does_not_make_the_next_submission_the_whole_picture() {
        let cost = |done: f64| if done < 0.3 { 1e-9 } else { DEAR };
        let mut pace = SubmissionBudget::default();
        picture(&mut pace, 1e7, |_| DEAR); // a preview
        for _ in 0..2 {
            let all = picture(&mut pace, WHOLE, cost);
            let longest = all.iter().map(|[_, ms]| *ms).fold(0.0, f64::max);
            assert!(longest < 1.5 * SUBMISSION_MS, "{longest}");
        }
    }

    #[test]
    fn the_first_submissions_are_small_and_grow_to_what_they_may_take() {
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
        let mut pace = SubmissionBudget::default();
        picture(&mut pace, 1e8, |_| DEAR);
        (0..3).for_each(|_| drop(picture(&mut pace, 1e9, |_| DEAR / 50.0)));
        let cheap = picture(&mut pace, 1e9, |_| DEAR / 50.0);
        assert!(cheap.len() < 15, "{}", cheap.len());
    }
}
