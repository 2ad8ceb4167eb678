//! Small pictures of candidates, and which of them is worth a whole one.

mod prospects;

use super::ahead::Ahead;
use super::known::{Known, draw};
use super::{CARE, ErrorBound, PATIENCE, PickError, SAMPLES, Verified, candidates, rules};
use crate::compare::candidates::{Candidate, Curve};
use crate::compare::{CompareError, Session};
use crate::reference::ReferenceError;
use crate::worker::Painter;
use hypertexture::render::{Frame, RenderError};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use std::time::Instant;

/// Longest side of the small pictures, pixels. Smaller: few pixels meet an edge, and llvmpipe, which gives each thread squares
/// of 64 pixels, draws with one of them. Larger: they take longer than the picture that is asked for.
const SMALL: u32 = 96;
/// Pixels of the small picture that are held against the reference.
const PIXELS: usize = 512;
/// Their reference may be wrong by this part of the bound: it decides what is drawn whole, and no more.
const OWN: f64 = 0.1;
/// Samples of the picture that these are chosen in.
const LOOK: u32 = 64;
/// Runs of a small picture that may be the fastest, of which the fastest counts; of one that takes longer than so many
/// milliseconds, only where another one is close.
const RUNS: usize = 3;
const AGAIN_MS: f64 = 50.0;
/// Curves that take longer than this times the fastest that fits are not drawn on.
const SLOWER: f64 = 1.5;
/// A target of fewer bits makes slices at most so many times faster.
const OF_TARGET: f64 = 2.0;
/// What is to replace the best must be so much faster, or have so many fewer samples; the second when it is late.
const FASTER: [f64; 2] = [0.95, 0.85];
/// Where nothing fits, so many curves are drawn to their limit.
const TO_LIMIT: usize = 3;
/// Where nothing fits, the nearest are drawn whole if they are not farther off than this times the bound.
const HOPE: f64 = 4.0;

/// A candidate that was drawn small.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    pub(super) candidate: Candidate,
    pub(super) error: f64,
    /// Milliseconds that the whole picture should take, by the fastest of so many runs.
    pub(super) ms: f64,
    runs: usize,
}

/// What a whole picture has taught.
struct Lesson {
    curve: Curve,
    scene: Scene,
    /// Its error, and that over the one of the small picture.
    error: f64,
    factor: f64,
}

/// Small pictures and what they are held against.
pub(super) struct Search<'a> {
    began: Instant,
    pub(super) painter: Painter<'a>,
    library: &'a Library,
    bound: ErrorBound,
    ahead: &'a Ahead<'a>,
    known: Known,
    drawn: Vec<Drawn>,
    lessons: Vec<Lesson>,
    /// Curves whose error no samples remove.
    flat: Vec<Curve>,
    /// Curves with no error but that of their steps, whose small pictures are near when it is late, or stay off as far with
    /// twice the samples: few pixels have that error, and the whole picture has others.
    stuck: Vec<Curve>,
    /// Candidates that could not be drawn; no other of their curves is tried.
    pub(super) failed: Vec<(Candidate, RenderError)>,
    /// Why there is no reference, where there is none.
    pub(super) unverified: Option<String>,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        stage: Session<'a>,
        scene: &Scene,
        bound: ErrorBound,
        ahead: &'a Ahead<'a>,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<Search<'a>, PickError> {
        let (began, mut painter, mut failed) = (Instant::now(), stage.painter(), Vec::new());
        let mut first = None;
        for family in &ahead.families.kept {
            let candidate = candidates::with_samples(family, LOOK);
            match painter.render(&small(&candidate.scene)) {
                Ok(frame) => first = Some((small(&candidate.scene), frame)),
                Err(error) => failed.push((candidate, error)),
            }
            if first.is_some() {
                break;
            }
        }
        let Some((look, frame)) = first else {
            return Err(failed.into_iter().next().map_or(CompareError::Nothing.into(), |(_, error)| error.into()));
        };
        let by_reference = Known::by_reference(stage, &look, OWN * bound.error).and_then(|mut known| {
            let scores = known.scores(&frame, &frame, bound);
            known.look(stage, &scores, PIXELS, progress).map(|()| known)
        });
        let (known, unverified) = match by_reference {
            Ok(known) => (known, None),
            Err(ReferenceError::Render(error)) => return Err(error.into()),
            Err(ReferenceError::Stopped) => return Err(PickError::Stopped),
            Err(why) => {
                let own = (bound.metric, bound.error);
                (Known::by_finer_picture(&mut painter, stage, &small(scene), own)?, Some(why.to_string()))
            }
        };
        Ok(Search {
            began,
            painter,
            library: stage.library,
            bound,
            ahead,
            known,
            drawn: Vec::new(),
            lessons: Vec::new(),
            flat: Vec::new(),
            stuck: Vec::new(),
            failed,
            unverified,
        })
    }

    /// What is worth a whole picture: the fastest that should keep the bound, if it should be faster than the best so far;
    /// where there is none yet, at last the nearest.
    pub(super) fn next(&mut self, best: Option<&Drawn>, progress: &dyn Fn(f32)) -> Option<Drawn> {
        let ahead = self.ahead;
        if let Some(stuck) = self.worth_a_whole() {
            return Some(stuck);
        }
        for (index, family) in ahead.families.kept.iter().enumerate() {
            let is_late = self.is_late() && self.fitting() > 0 && self.nearest_of(&family.curve()).is_none();
            if !is_late && !self.is_hopeless(family) {
                ahead.wait_for(index);
                self.follow(family);
            }
            progress((index + 1) as f32 / ahead.families.kept.len() as f32 * 0.5);
            if let Some(stuck) = self.worth_a_whole() {
                return Some(stuck);
            }
        }
        ahead.end();
        self.time_again();
        let fitting = self.drawn.iter().filter(|drawn| self.fits(drawn));
        let next = match fitting.min_by(|a, b| a.ms.total_cmp(&b.ms)).cloned() {
            Some(fastest) => Some(self.fewer(fastest)),
            None => self.nearest(),
        };
        let is_faster = |next: &Drawn, best: &Drawn| {
            let has_fewer = next.candidate.curve() == best.candidate.curve(); // samples, of the same curve
            next.ms < self.faster() * best.ms || has_fewer
        };
        next.filter(|next| self.lesson(next).is_none() && best.is_none_or(|best| is_faster(next, best)))
    }

    /// What a whole picture of a candidate has shown.
    pub(super) fn learn(&mut self, drawn: &Drawn, error: f64) {
        let factor = (error / drawn.error.max(f64::MIN_POSITIVE)).clamp(0.01, 10.0);
        let Candidate { scene, .. } = &drawn.candidate;
        self.lessons.push(Lesson { curve: drawn.candidate.curve(), scene: scene.clone(), error, factor });
    }

    /// A candidate cannot be drawn.
    pub(super) fn fail(&mut self, candidate: Candidate, error: RenderError) {
        self.drawn.retain(|drawn| drawn.candidate.curve() != candidate.curve());
        self.failed.push((candidate, error));
    }

    /// Whether it has taken long enough.
    pub(super) fn is_late(&self) -> bool {
        self.began.elapsed() > PATIENCE
    }

    fn faster(&self) -> f64 {
        FASTER[usize::from(self.is_late())]
    }

    /// How many curves were not tried, where that was for the time.
    pub(super) fn untried(&self) -> usize {
        let untried = |family: &&Candidate| self.nearest_of(&family.curve()).is_none() && !self.is_hopeless(family);
        if self.is_late() { self.ahead.families.kept.iter().filter(untried).count() } else { 0 }
    }

    /// How many candidates were drawn.
    pub(super) fn count(&self) -> usize {
        self.drawn.len()
    }

    /// How many of them should keep the bound.
    pub(super) fn fitting(&self) -> usize {
        self.drawn.iter().filter(|drawn| self.fits(drawn)).count()
    }

    /// The fastest of another pass than the best that should keep the bound, and how many times longer it takes.
    pub(super) fn other_pass(&self, best: &Drawn) -> Option<(String, f64)> {
        let pass = best.candidate.scene.quality.pass;
        let others = self.drawn.iter().filter(|drawn| drawn.candidate.scene.quality.pass != pass && self.fits(drawn));
        let other = others.min_by(|a, b| a.ms.total_cmp(&b.ms))?;
        Some((other.candidate.label(), other.ms / best.ms.max(1e-6)))
    }

    /// Why nothing was picked; `nearest` is the whole picture with the least error.
    pub(super) fn refusal(&mut self, bound: ErrorBound, nearest: Option<(Drawn, Verified)>) -> PickError {
        if self.drawn.is_empty() && !self.failed.is_empty() {
            return self.failed.swap_remove(0).1.into();
        }
        let least = || self.drawn.iter().min_by(|a, b| a.error.total_cmp(&b.error));
        let [own, _] = self.known.own(bound.metric);
        let (nearest, found, own) = match (nearest, least()) {
            (Some((nearest, verified)), _) => (nearest.candidate.label(), verified.error, verified.estimate),
            (None, Some(near)) => (near.candidate.label(), near.error + own, own),
            (None, None) => ("none".into(), f64::INFINITY, 0.0),
        };
        PickError::Bound { metric: bound.metric, asked: bound.error, nearest, own, found, allow: None }
    }

    /// The candidate drawn small, now or before; `None` where that cannot be.
    fn small(&mut self, candidate: Candidate) -> Option<Drawn> {
        if let Some(known) = self.drawn.iter().find(|drawn| drawn.candidate.scene == candidate.scene) {
            return Some(known.clone());
        }
        let is_of_failed = |(failed, _): &(Candidate, RenderError)| failed.curve() == candidate.curve();
        let is_refused = candidate.blend_bound() > self.bound.error || candidate.scene.check(self.library).is_err();
        if is_refused || self.failed.iter().any(is_of_failed) {
            return None;
        }
        match self.measure(&candidate) {
            Ok((error, ms, runs)) => {
                log::debug!("{}: {error:.2e} in a small picture, {ms:.1} ms of the whole", candidate.label());
                self.drawn.push(Drawn { candidate, error, ms, runs });
                self.drawn.last().cloned()
            }
            Err(error) => {
                self.failed.push((candidate, error));
                None
            }
        }
    }

    /// Error of a candidate, and its time by so many runs: more than one, if it fits and is fast.
    fn measure(&mut self, candidate: &Candidate) -> Result<(f64, f64, usize), RenderError> {
        let (frame, mut ms) = self.draw(candidate)?;
        let error = self.known.error(&frame, self.bound.metric);
        let is_fast = error <= self.target(&candidate.curve()) && frame.measurements.gpu_ms < AGAIN_MS;
        let runs = if is_fast { RUNS } else { 1 };
        for _ in 1..runs {
            ms = ms.min(self.draw(candidate)?.1);
        }
        Ok((error, ms, runs))
    }

    /// A small picture, and the time that the whole one should take.
    fn draw(&mut self, candidate: &Candidate) -> Result<(Frame, f64), RenderError> {
        let scene = small(&candidate.scene);
        let pixels = |of: &Scene| of.image.size.iter().map(|side| f64::from(*side)).product::<f64>();
        draw(&mut self.painter, &scene, pixels(&candidate.scene) / pixels(&scene))
    }

    /// Times again what fits, where curves are close and were timed once; where it is late, no more than that.
    fn time_again(&mut self) {
        for run in 1..RUNS {
            if run > 1 && self.is_late() {
                return;
            }
            let mut fitting: Vec<usize> =
                (0..self.drawn.len()).filter(|&index| self.fits(&self.drawn[index])).collect();
            fitting.sort_by(|a, b| self.drawn[*a].ms.total_cmp(&self.drawn[*b].ms));
            let times: Vec<(Curve, f64)> =
                fitting.iter().map(|&index| (self.drawn[index].candidate.curve(), self.drawn[index].ms)).collect();
            let close = rules::close(&times).into_iter().map(|place| fitting[place]);
            let once: Vec<usize> = close.filter(|index| self.drawn[*index].runs < RUNS).collect();
            if once.is_empty() {
                return;
            }
            for index in once {
                let candidate = self.drawn[index].candidate.clone();
                // One that cannot be drawn again shows that where it is drawn whole.
                let Ok((_, ms)) = self.draw(&candidate) else { return };
                let drawn = &mut self.drawn[index];
                (drawn.ms, drawn.runs) = (drawn.ms.min(ms), drawn.runs + 1);
            }
        }
    }

    /// Draws a curve with more and more samples until it fits, or takes longer than one that fits.
    fn follow(&mut self, family: &Candidate) {
        let target = self.target(&family.curve());
        let [fewest, most] = SAMPLES;
        let steps = (0..).map(|step| (f64::from(fewest) * 2f64.powf(f64::from(step) / 2.0)).round() as u32);
        let mut least = self.least(&family.curve(), target);
        let mut before: Option<(u32, f64)> = None;
        for samples in steps.take_while(|samples| *samples <= most).collect::<Vec<_>>() {
            if f64::from(samples) < least {
                continue;
            }
            let Some(Drawn { error, ms, .. }) = self.small(candidates::with_samples(family, samples)) else { return };
            let fitting = self.drawn.iter().filter(|drawn| self.fits(drawn)).map(|drawn| drawn.ms);
            if error <= target || ms > SLOWER * fitting.fold(f64::INFINITY, f64::min) {
                return;
            }
            let curve = family.curve();
            let list = match curve.block {
                Some(_) => Some(&mut self.flat), // a block of noise is wrong by itself, and more samples show no other error
                None => (self.is_late() && self.lessons.is_empty()).then_some(&mut self.stuck),
            };
            let is_near = curve.block.is_none() && error <= rules::NEAR * target;
            let stays = before.is_some_and(|fewer| rules::stays(fewer, (samples, error)));
            if let Some(list) = list.filter(|_| is_near || stays) {
                list.push(curve);
                return;
            }
            if before.is_none_or(|(fewer, _)| samples >= 2 * fewer) {
                before = Some((samples, error));
            }
            least = rules::next(samples, error / target);
        }
    }

    /// The same curve with fewer samples, if they do: between those that fit and those before that do not.
    fn fewer(&mut self, fits: Drawn) -> Drawn {
        let (curve, most) = (fits.candidate.curve(), fits.candidate.samples());
        let mut is_first = true;
        loop {
            let own = self.drawn.iter().filter(|drawn| drawn.candidate.curve() == curve && !self.fits(drawn));
            let before =
                own.filter(|drawn| drawn.candidate.samples() < most).max_by_key(|drawn| drawn.candidate.samples());
            let Some(before) = before else { return fits };
            let [n, m] = [before.candidate.samples(), most].map(f64::from);
            let errors = [self.error(before), self.error(&fits)];
            // Where the error goes down evenly; then in the middle of what is left.
            let even = (errors[0] / (CARE * self.bound.error)).ln() / (errors[0] / errors[1]).ln();
            let fewer = (n * (m / n).powf(if std::mem::take(&mut is_first) { even } else { 0.5 })).ceil();
            let fewer = fewer.max(f64::from(self.least_hopeful(&curve)));
            if fewer.is_nan() || fewer >= self.faster() * m || fewer <= n {
                return fits;
            }
            match self.small(candidates::with_samples(&fits.candidate, fewer as u32)) {
                Some(fewer) if self.fits(&fewer) => return fewer,
                Some(_) => {}
                None => return fits,
            }
        }
    }

    /// Of curves that do not fit, drawn to their limit, the nearest that was not drawn whole. One whose block of noise keeps it
    /// far from the bound is left as it is.
    fn nearest(&mut self) -> Option<Drawn> {
        let last = |family: &Candidate| {
            let own = self.drawn.iter().filter(|drawn| drawn.candidate.curve() == family.curve());
            let is_open =
                |last: &&Drawn| !self.flat.contains(&family.curve()) || self.error(last) <= HOPE * self.bound.error;
            own.max_by_key(|drawn| drawn.candidate.samples()).filter(is_open).map(|last| {
                let more = f64::from(SAMPLES[1]) / f64::from(last.candidate.samples());
                (last.error / more.powf(rules::ORDER), family.clone())
            })
        };
        let mut hopeful: Vec<(f64, Candidate)> = self.ahead.families.kept.iter().filter_map(last).collect();
        hopeful.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, family) in hopeful.into_iter().take(TO_LIMIT) {
            let mut samples = SAMPLES[1];
            while samples > SAMPLES[0] && self.small(candidates::with_samples(&family, samples)).is_none() {
                samples /= 2;
            }
        }
        let hope = |drawn: &&Drawn| {
            !self.is_near_failed(drawn) && (self.lessons.is_empty() || self.error(drawn) <= HOPE * self.bound.error)
        };
        self.drawn.iter().filter(hope).min_by(|a, b| a.error.total_cmp(&b.error)).cloned()
    }
}

/// The scene, smaller.
fn small(scene: &Scene) -> Scene {
    let mut small = scene.clone();
    let longest = scene.image.size[0].max(scene.image.size[1]);
    if longest > SMALL {
        let scale = f64::from(SMALL) / f64::from(longest);
        small.image.size = scene.image.size.map(|side| ((f64::from(side) * scale).round() as u32).max(1));
    }
    small
}
