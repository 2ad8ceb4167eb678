//! What pictures drawn so far say about what is worth drawing.

use super::super::{CARE, rules};
use super::{Drawn, HOPE, Lesson, OF_TARGET, SLOWER, Search};
use crate::compare::candidates::{Candidate, Curve};
use crate::pick::candidates;
use hypertexture::scene::{Integration, TargetFormat};

impl Search<'_> {
    /// What the error of a small picture of a curve is to be multiplied by to get that of the whole.
    pub(super) fn factor(&self, curve: &Curve) -> f64 {
        if let Some(own) = self.lessons.iter().rev().find(|lesson| lesson.curve == *curve) {
            return own.factor;
        }
        let sum: f64 = self.lessons.iter().map(|lesson| lesson.factor.ln()).sum();
        (sum / self.lessons.len().max(1) as f64).exp()
    }

    /// The error that the small picture of a curve may have.
    pub(super) fn target(&self, curve: &Curve) -> f64 {
        CARE * self.bound.error / self.factor(curve)
    }

    /// The error of the whole picture, as known or as it should be.
    pub(super) fn error(&self, drawn: &Drawn) -> f64 {
        self.lesson(drawn).map_or_else(|| drawn.error * self.factor(&drawn.candidate.curve()), |lesson| lesson.error)
    }

    pub(super) fn fits(&self, drawn: &Drawn) -> bool {
        match self.lesson(drawn) {
            Some(lesson) => lesson.error <= self.bound.error,
            None => self.error(drawn) <= CARE * self.bound.error && !self.is_near_failed(drawn),
        }
    }

    /// The fewest samples of a curve that whole pictures of it which failed do not speak against; of one that is stuck, those of
    /// the other pass as well.
    pub(super) fn least_hopeful(&self, curve: &Curve) -> u32 {
        let bound = self.bound.error;
        let is_stuck = self.stuck.iter().any(|stuck| has_samples_of(stuck, curve));
        let speaks = |of: &Curve| of == curve || is_stuck && has_samples_of(of, curve);
        let failed = self.lessons.iter().filter(|lesson| speaks(&lesson.curve) && lesson.error > bound);
        let failed = failed.map(|lesson| (lesson.scene.quality.samples, lesson.error / bound));
        rules::least_hopeful(&failed.collect::<Vec<_>>(), is_stuck)
    }

    pub(super) fn is_near_failed(&self, drawn: &Drawn) -> bool {
        drawn.candidate.samples() < self.least_hopeful(&drawn.candidate.curve())
    }

    pub(super) fn lesson(&self, drawn: &Drawn) -> Option<&Lesson> {
        self.lessons.iter().find(|lesson| lesson.scene == drawn.candidate.scene)
    }

    /// The picture of a curve that is stuck near the bound, where nothing keeps it so far: small ones with more samples would say
    /// no more of it, and take longer than the whole. After a whole one that failed, as many more samples as that asks for.
    pub(super) fn worth_a_whole(&mut self) -> Option<Drawn> {
        if self.fitting() > 0 {
            return None;
        }
        let hopeful = |drawn: &&Drawn| self.error(drawn) <= HOPE * self.bound.error;
        let last = self.stuck.iter().filter_map(|curve| self.nearest_of(curve)).filter(hopeful);
        let more = |last: &Drawn| {
            let samples = self.least_hopeful(&last.candidate.curve()).max(last.candidate.samples());
            let times = f64::from(samples) / f64::from(last.candidate.samples());
            let candidate = candidates::with_samples(&last.candidate, samples);
            let is_allowed = candidate.blend_bound() <= self.bound.error && candidate.scene.check(self.library).is_ok();
            is_allowed.then(|| Drawn { candidate, error: last.error / times, ms: last.ms * times, runs: last.runs })
        };
        let next = last.filter_map(more).filter(|next| self.lesson(next).is_none());
        let next = next.min_by(|a, b| a.error.total_cmp(&b.error))?;
        if !self.drawn.iter().any(|drawn| drawn.candidate.scene == next.candidate.scene) {
            self.drawn.push(next.clone());
        }
        Some(next)
    }

    /// Whether what is known of other curves says that this one is slower than one that fits, or never fits. Its program
    /// would take a driver longer than all its pictures.
    pub(super) fn is_hopeless(&self, family: &Candidate) -> bool {
        let (curve, families) = (family.curve(), &self.ahead.families.kept);
        let first = |strategy: &str| families.iter().map(Candidate::curve).find(|other| other.strategy == strategy);
        let Some(base) = first(&curve.strategy).filter(|base| *base != curve) else { return false };
        // Another pass, integration or target does not mend what a strategy makes of its noise; another filter may.
        if (base.block, base.filter) == (curve.block, curve.filter) && self.flat.contains(&base) {
            return true;
        }
        let best =
            self.drawn.iter().filter(|drawn| self.fits(drawn)).map(|drawn| drawn.ms).fold(f64::INFINITY, f64::min);
        let is_slow = |ms: f64| ms > SLOWER * best;
        // A target of fewer bits needs no fewer samples, and may not take as many.
        let exact = Curve { target: curve.target.map(|_| TargetFormat::Float32), ..curve.clone() };
        if exact != curve {
            let Some(exact) = self.nearest_of(&exact) else { return true };
            let bound = candidates::with_samples(family, exact.candidate.samples()).blend_bound();
            return is_slow(exact.ms / OF_TARGET) || bound > self.bound.error;
        }
        // Slices take about as many times longer than rays with segments as with points.
        let points = |of: &Curve| Curve { integration: Integration::Point, ..of.clone() };
        let rays = Curve { integration: curve.integration, ..base.clone() };
        let known = [&points(&curve), &rays].map(|other| self.nearest_of(other).filter(|drawn| self.fits(drawn)));
        if curve != points(&curve)
            && let [Some(slices), Some(rays)] = known
            && self.nearest_of(&base).is_some_and(|base| is_slow(slices.ms * rays.ms / base.ms))
        {
            return true;
        }
        // Whatever a method takes more than rays of points, it takes about as much more with every strategy.
        let others = families.iter().map(Candidate::curve).filter(|other| other.strategy != curve.strategy);
        let method = |of: &Curve| (of.pass, of.integration, of.target);
        let same_block = |other: &Curve| curve.block.is_none() || other.block.is_none() || curve.block == other.block;
        let alike = others.filter(|other| method(other) == method(&curve) && same_block(other));
        let ms = |curve: &Curve| self.nearest_of(curve).map(|drawn| drawn.ms);
        let more = alike.filter_map(|other| Some(ms(&other)? / ms(&first(&other.strategy)?)?));
        let more = more.fold(f64::INFINITY, f64::min);
        more.is_finite() && ms(&base).is_some_and(|ms| is_slow(ms * more))
    }

    /// The fastest picture of a curve that fits, or that with the most samples of those that do not.
    pub(super) fn nearest_of(&self, curve: &Curve) -> Option<&Drawn> {
        let own = || self.drawn.iter().filter(|drawn| drawn.candidate.curve() == *curve);
        let fitting = own().filter(|drawn| self.fits(drawn)).min_by(|a, b| a.ms.total_cmp(&b.ms));
        fitting.or_else(|| own().max_by_key(|drawn| drawn.candidate.samples()))
    }

    /// The fewest samples of a curve that may do: those of its last picture that does not, which says how many more, and more than
    /// those of the other pass, which has the same samples. No fewer than whole pictures leave.
    pub(super) fn least(&self, curve: &Curve, target: f64) -> f64 {
        let drawn = self.drawn.iter().filter(|drawn| has_samples_of(&drawn.candidate.curve(), curve));
        let fails = drawn.filter(|drawn| drawn.error > target);
        let least = fails.map(|drawn| match drawn.candidate.curve() == *curve {
            true => f64::from(drawn.candidate.samples()),
            false => rules::next(drawn.candidate.samples(), drawn.error / target),
        });
        least.fold(f64::from(self.least_hopeful(curve)), f64::max)
    }
}

/// Whether the pictures of two curves have the same samples: by rays or by slices.
fn has_samples_of(curve: &Curve, other: &Curve) -> bool {
    Curve { pass: other.pass, target: other.target, ..curve.clone() } == *other
}
