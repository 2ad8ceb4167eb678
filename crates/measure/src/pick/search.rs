//! Small pictures of the candidates, and the one that is worth a whole picture next.

use super::bound::{ErrorBound, PickError, Verified};
use super::candidates::{Families, SAMPLES, with_samples};
use super::reference_sample::{ReferenceSample, draw};
use crate::compare::Session;
use crate::compare::candidates::{Candidate, Curve};
use crate::reference::ReferenceError;
use crate::worker::Painter;
use hypertexture::render::{Frame, RenderError};
use hypertexture::scene::{Scene, TargetFormat};
use hypertexture::shader::Library;
use std::time::{Duration, Instant};

/// Longest side of a small picture, pixels. Lower: few pixels meet an edge. Higher: small pictures take longer than whole ones.
const SMALL: u32 = 96;
/// Pixels of the small picture that are held against the reference.
const PIXELS: usize = 512;
/// Error of the small reference, in parts of the bound.
const OWN: f64 = 0.1;
/// Part of the bound that the expected error of a whole picture may take. Lower: slower picks. Higher: whole pictures in vain.
const CARE: f64 = 0.85;
/// Methods that take longer than this times the fastest that fits are given up.
const SLOWER: f64 = 1.5;
/// A candidate replaces the best only if it takes less than this part of its time.
const FASTER: f64 = 0.9;
/// Error that twice the samples leave, in parts of the error before, from which on more samples are in vain.
const PLATEAU: f64 = 0.85;
/// Samples below which no plateau is believed.
const PLATEAU_FROM: u32 = 128;
/// Growth of the samples after a whole picture that fails, at least.
const STRIDE: f64 = 1.25;
/// Order of convergence that decides by how many samples to go on after a failure.
const ORDER: f64 = 1.4;
/// If no method fits, draws those whose estimate is below this multiple of the bound.
const TRY_WITHIN: f64 = 4.0;
/// Runs of a small picture that fits, of which the fastest counts, if one takes less than this many milliseconds.
const RUNS: usize = 3;
const AGAIN_MS: f64 = 50.0;
/// Time after which no method is begun if one fits.
const MAX_TIME: Duration = Duration::from_secs(4);

/// A small picture of a method.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trial {
    pub(super) samples: u32,
    pub(super) error: f64,
    /// Expected milliseconds of the whole picture.
    pub(super) ms: f64,
}

/// A candidate with any number of samples.
struct Method {
    candidate: Candidate,
    curve: Curve,
    trials: Vec<Trial>,
    /// Samples and error of its last whole picture, and that error over the one of the small picture.
    whole: Option<(u32, f64, f64)>,
    has_failed: bool,
}

impl Method {
    /// Whether more samples are in vain.
    fn has_plateaued(&self) -> bool {
        let Some(last) = self.trials.iter().max_by_key(|trial| trial.samples) else { return false };
        let fewer = self.trials.iter().filter(|trial| 2 * trial.samples <= last.samples);
        let before = fewer.max_by_key(|trial| trial.samples);
        last.samples >= PLATEAU_FROM && before.is_some_and(|before| last.error > PLATEAU * before.error)
    }
}

/// Small pictures and the reference they are held against.
pub(super) struct Search<'a> {
    began: Instant,
    pub(super) painter: Painter<'a>,
    library: &'a Library,
    bound: ErrorBound,
    sample: ReferenceSample,
    methods: Vec<Method>,
    /// Candidates that could not be drawn; their methods are given up.
    pub(super) failed: Vec<(Candidate, RenderError)>,
    /// The reason for a missing reference.
    pub(super) unverified: Option<String>,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        session: Session<'a>,
        scene: &Scene,
        bound: ErrorBound,
        families: &Families,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<Search<'a>, PickError> {
        let (began, mut painter, mut failed) = (Instant::now(), session.painter(), Vec::new());
        let first = families.kept.iter().find_map(|family| {
            let candidate = with_samples(family, 64);
            let scene = small(&candidate.scene);
            match painter.render(&scene) {
                Ok(frame) => Some((scene, frame)),
                Err(error) => {
                    failed.push((candidate, error));
                    None
                }
            }
        });
        let Some((look, frame)) = first else {
            return Err(failed.into_iter().next().map_or(PickError::Nothing, |(_, error)| error.into()));
        };
        let by_reference = ReferenceSample::by_reference(session, &look, OWN * bound.error).and_then(|mut sample| {
            let scores = sample.scores(&frame, &frame, bound);
            sample.look(session, &scores, PIXELS, progress).map(|()| sample)
        });
        let (sample, unverified) = match by_reference {
            Ok(sample) => (sample, None),
            Err(ReferenceError::Render(error)) => return Err(error.into()),
            Err(ReferenceError::Stopped) => return Err(PickError::Stopped),
            Err(why) => {
                (ReferenceSample::by_finer_picture(&mut painter, session, &small(scene), bound)?, Some(why.to_string()))
            }
        };
        let method = |candidate: &Candidate| Method {
            candidate: candidate.clone(),
            curve: candidate.curve(),
            trials: Vec::new(),
            whole: None,
            has_failed: failed.iter().any(|(failed, _)| failed.curve() == candidate.curve()),
        };
        let methods = families.kept.iter().map(method).collect();
        Ok(Search { began, painter, library: session.library, bound, sample, methods, failed, unverified })
    }

    /// The method and the samples to draw whole next: the fastest that should keep the bound, if it should be faster than the best
    /// so far; where none should, the nearest.
    pub(super) fn next(&mut self, best: Option<Trial>, progress: &dyn Fn(f32)) -> Option<(usize, Trial)> {
        for index in 0..self.methods.len() {
            if !self.is_hopeless(index) {
                self.follow(index);
            }
            progress((index + 1) as f32 / self.methods.len() as f32);
        }
        let next = match self.fastest() {
            Some((index, trial)) => Some((index, self.with_fewer_samples(index, trial))),
            None => self.nearest(),
        };
        next.filter(|(_, trial)| best.is_none_or(|best| trial.ms < FASTER * best.ms))
    }

    /// The candidate of a trial.
    pub(super) fn candidate(&self, (method, trial): (usize, Trial)) -> Candidate {
        with_samples(&self.methods[method].candidate, trial.samples)
    }

    /// Records the error of a whole picture.
    pub(super) fn learn(&mut self, (method, trial): (usize, Trial), error: f64) {
        let factor = (error / trial.error.max(f64::MIN_POSITIVE)).clamp(0.01, 10.0);
        self.methods[method].whole = Some((trial.samples, error, factor));
    }

    /// Gives up the method of a trial that cannot be drawn.
    pub(super) fn fail(&mut self, next: (usize, Trial), error: RenderError) {
        self.failed.push((self.candidate(next), error));
        self.methods[next.0].has_failed = true;
    }

    pub(super) fn is_late(&self) -> bool {
        self.began.elapsed() > MAX_TIME
    }

    /// Candidates that were drawn, those of them that should keep the bound, and methods that were left out as it was late.
    pub(super) fn counts(&self) -> [usize; 3] {
        let drawn = self.methods.iter().map(|method| method.trials.len()).sum();
        let untried = |index: &usize| self.methods[*index].trials.is_empty() && !self.is_slow_or_flat(*index);
        let untried = if self.is_late() { (0..self.methods.len()).filter(untried).count() } else { 0 };
        [drawn, self.fitting().count(), untried]
    }

    /// The fastest candidate of another pass that should keep the bound, and its time in parts of the best.
    pub(super) fn other_pass(&self, (method, best): (usize, Trial)) -> Option<(String, f64)> {
        let pass = self.methods[method].curve.pass;
        let others = self.fitting().filter(|(index, _)| self.methods[*index].curve.pass != pass);
        let other = others.min_by(|a, b| a.1.ms.total_cmp(&b.1.ms))?;
        Some((self.candidate(other).label(), other.1.ms / best.ms.max(1e-6)))
    }

    /// Why nothing was picked; `nearest` is the whole picture with the least error.
    pub(super) fn refusal(&mut self, nearest: Option<((usize, Trial), Verified)>) -> PickError {
        let ErrorBound { metric, error: asked } = self.bound;
        let Some((nearest, verified)) = nearest else {
            let failed = self.failed.drain(..).next();
            return failed.map_or(PickError::Nothing, |(_, error)| error.into());
        };
        let (nearest, size) = (self.candidate(nearest), verified.pixels[0]);
        let all = nearest.scene.image.size.iter().map(|side| *side as usize).product();
        let (nearest, found, own) = (nearest.label(), verified.error, verified.estimate);
        // Without a bound of the pixels that were not compared.
        let compared = (verified.error == verified.found && size < all).then_some([size, all]);
        PickError::Bound { metric, asked, nearest, own, found, compared, allow: None }
    }

    /// Factor from the error of a small picture to that of the whole: of the method itself, or the geometric mean of all.
    fn factor(&self, method: &Method) -> f64 {
        let of = |method: &Method| method.whole.map(|(_, _, factor)| factor);
        let all: Vec<f64> = self.methods.iter().filter_map(of).map(f64::ln).collect();
        of(method).unwrap_or_else(|| (all.iter().sum::<f64>() / all.len().max(1) as f64).exp())
    }

    /// Error of the whole picture: as measured, or as expected.
    fn expected(&self, method: &Method, trial: Trial) -> f64 {
        match method.whole {
            Some((samples, error, _)) if samples == trial.samples => error,
            _ => trial.error * self.factor(method),
        }
    }

    /// Whether a whole picture should keep the bound: not with a few more samples than one that did not.
    fn fits(&self, method: &Method, trial: Trial) -> bool {
        let expected = self.expected(method, trial);
        match method.whole {
            Some((samples, error, _)) if samples == trial.samples => error <= self.bound.error,
            _ => expected <= CARE * self.bound.error && f64::from(trial.samples) >= self.least_samples(method),
        }
    }

    /// Fewest samples that the last whole picture of a method does not speak against.
    fn least_samples(&self, method: &Method) -> f64 {
        let too_few = method.whole.filter(|(_, error, _)| *error > self.bound.error);
        too_few.map_or(f64::from(SAMPLES[0]), |(samples, error, _)| {
            let growth = (error / self.bound.error).powf(1.0 / ORDER).max(STRIDE);
            (f64::from(samples) * growth).ceil().min(f64::from(SAMPLES[1])).max(f64::from(samples) + 1.0)
        })
    }

    /// Trials that should keep the bound.
    fn fitting(&self) -> impl Iterator<Item = (usize, Trial)> {
        let methods = self.methods.iter().enumerate().filter(|(_, method)| !method.has_failed);
        methods.flat_map(move |(index, method)| {
            let trials = method.trials.iter().filter(move |trial| self.fits(method, **trial));
            trials.map(move |trial| (index, *trial))
        })
    }

    fn fastest(&self) -> Option<(usize, Trial)> {
        self.fitting().min_by(|a, b| a.1.ms.total_cmp(&b.1.ms))
    }

    /// Draws a method small, now or before; `None` where it cannot be drawn.
    fn small(&mut self, index: usize, samples: u32) -> Option<Trial> {
        let method = &self.methods[index];
        if let Some(known) = method.trials.iter().find(|trial| trial.samples == samples) {
            return Some(*known);
        }
        let candidate = with_samples(&method.candidate, samples);
        let is_refused = candidate.blend_bound() > self.bound.error || candidate.scene.check(self.library).is_err();
        if is_refused || method.has_failed {
            return None;
        }
        match self.measure(index, &candidate) {
            Ok(trial) => {
                log::debug!("{}: {:.2e} in a small picture, {:.1} ms", candidate.label(), trial.error, trial.ms);
                self.methods[index].trials.push(trial);
                Some(trial)
            }
            Err(error) => {
                self.failed.push((candidate, error));
                self.methods[index].has_failed = true;
                None
            }
        }
    }

    fn measure(&mut self, index: usize, candidate: &Candidate) -> Result<Trial, RenderError> {
        let scene = small(&candidate.scene);
        let pixels = |of: &Scene| of.image.size.iter().map(|side| f64::from(*side)).product::<f64>();
        let times = pixels(&candidate.scene) / pixels(&scene);
        let (frame, ms): (Frame, f64) = draw(&mut self.painter, &scene, times)?;
        let error = self.sample.error(&frame, self.bound.metric);
        let mut trial = Trial { samples: candidate.samples(), error, ms };
        if self.fits(&self.methods[index], trial) && frame.measurements.gpu_ms < AGAIN_MS {
            for _ in 1..RUNS {
                trial.ms = trial.ms.min(draw(&mut self.painter, &scene, times)?.1);
            }
        }
        Ok(trial)
    }

    /// Draws a method with ever more samples until it fits, or is slower than one that fits, or its error stays.
    fn follow(&mut self, index: usize) {
        let mut samples = self.least_samples(&self.methods[index]) as u32;
        while let Some(trial) = self.small(index, samples) {
            let method = &self.methods[index];
            let limit = SLOWER * self.fastest().map_or(f64::INFINITY, |(_, fastest)| fastest.ms);
            if self.fits(method, trial) || trial.ms > limit || samples >= SAMPLES[1] || method.has_plateaued() {
                return;
            }
            let times = (self.expected(method, trial) / (CARE * self.bound.error)).sqrt().max(2.0);
            samples = (f64::from(samples) * times).min(f64::from(SAMPLES[1])) as u32;
        }
    }

    /// The fewest samples that fit, by bisection, to a tenth.
    fn with_fewer_samples(&mut self, index: usize, mut fits: Trial) -> Trial {
        loop {
            let method = &self.methods[index];
            let fewer = method.trials.iter().filter(|trial| trial.samples < fits.samples);
            let Some(fails) = fewer.map(|trial| trial.samples).max() else { return fits };
            let fails = f64::from(fails).max(self.least_samples(method) - 1.0);
            let middle = (fails * f64::from(fits.samples)).sqrt().round();
            if f64::from(fits.samples) < 1.1 * middle || middle <= fails {
                return fits;
            }
            match self.small(index, middle as u32) {
                Some(trial) if self.fits(&self.methods[index], trial) => fits = trial,
                Some(_) => {}
                None => return fits,
            }
        }
    }

    /// Where nothing fits, the trial with the least expected error of those that were not drawn whole.
    fn nearest(&self) -> Option<(usize, Trial)> {
        let is_first = self.methods.iter().all(|method| method.whole.is_none());
        let limit = if is_first { f64::INFINITY } else { TRY_WITHIN * self.bound.error };
        let methods = self.methods.iter().enumerate().filter(|(_, method)| !method.has_failed);
        let last = methods.filter_map(|(index, method)| {
            let last = *method.trials.iter().max_by_key(|trial| trial.samples)?;
            let is_new = method.whole.is_none_or(|(samples, ..)| samples < last.samples);
            (is_new && self.expected(method, last) <= limit).then_some((index, last, self.expected(method, last)))
        });
        last.min_by(|a, b| a.2.total_cmp(&b.2)).map(|(index, last, _)| (index, last))
    }

    /// Whether a method is not worth a picture: it has failed, it is late, or other methods say that it is slow or never fits.
    fn is_hopeless(&self, index: usize) -> bool {
        let method = &self.methods[index];
        let is_begun = !method.trials.is_empty();
        // The first pass and strategy, whose noise has no error of its own, is as accurate as any other method: rays, where the
        // scene has any that can be drawn.
        let first = self.methods.iter().find(|method| !method.has_failed).map(|method| &method.curve);
        let is_exact =
            first.is_some_and(|first| method.curve.strategy == first.strategy && method.curve.pass == first.pass);
        let has_time = !self.is_late() || self.fastest().is_none() && is_exact;
        method.has_failed || !is_begun && (!has_time || self.is_slow_or_flat(index))
    }

    /// Whether methods that were drawn say that this one is slower than one that fits, or never fits. Linking its program takes
    /// longer than all its small pictures.
    fn is_slow_or_flat(&self, index: usize) -> bool {
        let Curve { strategy, pass, integration, block, target, filter } = &self.methods[index].curve;
        let drawn = || self.methods.iter().filter(|method| !method.trials.is_empty());
        let ms = |method: &Method| {
            let fitting = method.trials.iter().filter(|trial| self.fits(method, **trial)).map(|trial| trial.ms);
            let least = fitting.fold(f64::INFINITY, f64::min);
            if least.is_finite() { least } else { method.trials.iter().map(|trial| trial.ms).fold(0.0, f64::max) }
        };
        let limit = SLOWER * self.fastest().map_or(f64::INFINITY, |(_, fastest)| fastest.ms);
        // Neither pass nor integration mends the noise of a strategy.
        let has_its_noise = |of: &Curve| (&of.strategy, &of.block, &of.filter) == (strategy, block, filter);
        if drawn().any(|method| block.is_some() && has_its_noise(&method.curve) && method.has_plateaued()) {
            return true;
        }
        // A target of fewer bits needs as many samples, and halves the time at best.
        if target.is_some_and(|target| target != TargetFormat::Float32) {
            let float = |of: &Curve| {
                has_its_noise(of) && (of.integration, of.target) == (*integration, Some(TargetFormat::Float32))
            };
            return drawn().find(|method| float(&method.curve)).is_none_or(|method| 0.5 * ms(method) > limit);
        }
        // A method costs about as much more than the first of its strategy as with other strategies.
        let first = |strategy: &str| drawn().find(|method| method.curve.strategy == strategy);
        let Some(own) = first(strategy) else { return false };
        let like = |of: &Curve| (of.pass, of.integration, of.target) == (*pass, *integration, *target);
        let others = drawn().filter(|method| method.curve.strategy != *strategy && like(&method.curve));
        let times = others.filter_map(|method| Some(ms(method) / ms(first(&method.curve.strategy)?)));
        let times = times.fold(f64::INFINITY, f64::min);
        times.is_finite() && ms(own) * times > limit
    }
}

/// The scene at a size of [`SMALL`] at most.
fn small(scene: &Scene) -> Scene {
    let mut small = scene.clone();
    let longest = scene.image.size[0].max(scene.image.size[1]);
    if longest > SMALL {
        let scale = f64::from(SMALL) / f64::from(longest);
        small.image.size = scene.image.size.map(|side| ((f64::from(side) * scale).round() as u32).max(1));
    }
    small
}
