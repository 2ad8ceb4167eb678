//! The fastest settings of a scene within an error.
//!
//! Role: scene and bound -> the same scene with other accuracy settings, and why these. Candidates that cannot keep the bound
//! are left out beforehand; the others are drawn small against a finer small picture, cheapest first; the
//! winner is held against the f64 reference in some pixels of the whole picture, and on a violation the next
//! one is taken. Invariant: only what is there for speed changes, so every candidate has the truth of the scene as it is.
//! Source: the protocol of numerical work-precision diagrams; Richardson's extrapolation for the finer picture.

mod candidates;
mod store;
mod verify;

pub use verify::Verified;

use crate::measure::compare::candidates::Candidate;
use crate::measure::compare::{CompareError, Failure, Stage};
use crate::measure::reference::ReferenceError;
use crate::measure::statistics::{largest, weighted_quantile, weighted_rms};
use crate::measure::worker::Painter;
use crate::render::RenderError;
use crate::scene::Scene;
use crate::shader::Library;
use std::fmt;

/// Longest side of the small pictures, pixels. Smaller: few pixels meet an edge. Larger: they take longer than the
/// picture that is asked for.
const SMALL: u32 = 64;
/// A candidate is taken whose error is this much below the bound. Nearer to 1: the whole picture, which the small one stands
/// for, breaks the bound more often. Farther: too careful to be fast.
const SAFETY: f64 = 1.6;
/// The finer picture should be wrong by less than this part of the bound.
const FINER: f64 = 0.25;
/// Samples of the finer picture to begin with, and at most.
const FINEST: [u32; 2] = [1024, 16_384];
/// Runs of a small picture, of which the fastest counts.
const RUNS: usize = 3;
/// The highest order in the step that a picture has: so many fewer samples are not tried.
const ORDER: f64 = 2.0;
/// An error that twice the samples leave at this part of what it was is one that no samples remove; fewer samples than
/// these say nothing about it.
const STAYS: f64 = 0.85;
const FLAT_FROM: u32 = 128;
/// The fewest and the most samples of a candidate.
const SAMPLES: [u32; 2] = [8, 4096];
/// Winners that are held against the reference, at most.
const VERIFIED: usize = 6;

/// How an error is measured; all of premultiplied linear RGBA, in units of the brightest white.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Metric {
    /// Root of the mean square over pixels and channels.
    #[default]
    Rmse,
    /// The largest of any pixel that was looked at.
    Max,
    /// What 99.9 % of the pixels that were looked at stay below.
    P999,
    /// Root of the mean square of the opacity alone.
    Opacity,
}

impl Metric {
    /// Every metric with its name.
    pub const ALL: [(&str, Metric); 4] =
        [("rmse", Metric::Rmse), ("max", Metric::Max), ("p999", Metric::P999), ("opacity", Metric::Opacity)];

    /// The error of pixels against others; each pair stands for as many as its weight says.
    fn of(self, pairs: impl Iterator<Item = ([f64; 4], [f64; 4], f64)>) -> f64 {
        let differences =
            pairs.map(|(a, b, weight)| (std::array::from_fn::<f64, 4, _>(|c| (a[c] - b[c]).abs()), weight));
        let worst = |(channels, weight): ([f64; 4], f64)| (largest(channels), weight);
        match self {
            Metric::Rmse => {
                weighted_rms(differences.flat_map(|(channels, weight)| channels.map(|difference| (difference, weight))))
            }
            Metric::Opacity => weighted_rms(differences.map(|(channels, weight)| (channels[3], weight))),
            Metric::Max => largest(differences.map(worst).map(|(worst, _)| worst)),
            Metric::P999 => weighted_quantile(differences.map(worst).collect(), 1e-3),
        }
    }
}

impl fmt::Display for Metric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Metric::ALL.iter().find(|(_, metric)| metric == self).map(|(name, _)| *name);
        f.write_str(name.unwrap_or_default())
    }
}

/// An error that a picture may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorBound {
    /// How it is measured.
    pub metric: Metric,
    /// The largest error, above 0.
    pub error: f64,
}

impl ErrorBound {
    /// A bound on an error.
    ///
    /// # Errors
    /// Not above 0, or not finite.
    pub fn new(metric: Metric, error: f64) -> Result<ErrorBound, PickError> {
        if !error.is_finite() || error <= 0.0 {
            return Err(PickError::Value(error));
        }
        Ok(ErrorBound { metric, error })
    }
}

/// What was picked.
#[derive(Clone, Debug, PartialEq)]
pub struct Pick {
    /// The scene, drawn with the settings that were picked.
    pub scene: Scene,
    /// Those settings in words.
    pub settings: String,
    /// Its error in a small picture.
    pub error: f64,
    /// Milliseconds of the small picture on the device.
    pub small_ms: f64,
    /// What the reference says of it; `None` where the scene has none.
    pub verified: Option<Verified>,
    /// Why there is no reference, where there is none.
    pub unverified: Option<String>,
    /// Candidates that were left out beforehand, that were drawn, and that kept the bound.
    pub counts: [usize; 3],
    /// The fastest settings of another pass that keep the bound: in words, with its milliseconds.
    pub other: Option<(String, f64)>,
    /// Candidates that could not be drawn.
    pub failures: Vec<Failure>,
    /// Whether it is remembered from an earlier time.
    pub remembered: bool,
}

/// Why nothing was picked.
#[derive(Debug, thiserror::Error)]
pub enum PickError {
    /// No error that a picture can have.
    #[error("a largest error of {0}: it must be above 0, such as 1e-3")]
    Value(f64),
    /// The scene cannot be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// No settings draw it.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// Nothing is that accurate.
    #[error("no settings draw this scene with a {metric} error of {asked:e}: the nearest, {nearest}, has {found:.1e}")]
    Bound {
        /// How it is measured.
        metric: Metric,
        /// What was asked for.
        asked: f64,
        /// The nearest settings in words.
        nearest: String,
        /// Its error.
        found: f64,
    },
}

/// A candidate that was drawn small.
#[derive(Clone, Debug)]
struct Drawn {
    candidate: Candidate,
    /// With that of the finer picture.
    error: f64,
    ms: f64,
}

/// As [`pick`], remembered on disk by scene, bound, device and driver.
///
/// # Errors
/// As [`pick`].
pub fn remembered(
    stage: Stage<'_>,
    scene: &Scene,
    bound: ErrorBound,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Pick, PickError> {
    let key = store::key(stage, scene, bound)?;
    if let Some(pick) = store::load(key) {
        return Ok(pick);
    }
    let pick = pick(stage, scene, bound, progress)?;
    store::save(key, &pick);
    Ok(pick)
}

/// Picks the fastest settings for a scene within an error on this device.
///
/// Small pictures are at most 64 pixels wide; the reference is computed for 1024 to 2048 pixels of the whole. `progress` is
/// called with the part that is done, roughly. A candidate that cannot be drawn is left out, and told.
///
/// # Errors
/// The scene cannot be drawn, or no settings keep the bound.
pub fn pick(
    stage: Stage<'_>,
    scene: &Scene,
    bound: ErrorBound,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Pick, PickError> {
    let mut search = Search::new(stage, scene, bound)?;
    progress(0.1);
    let families = candidates::families(scene, stage.library, bound.error)?;
    let (mut drawn, mut target) = (Vec::new(), bound.error / SAFETY);
    let mut tried: Vec<Scene> = Vec::new();
    for round in 0..VERIFIED {
        for (index, family) in families.kept.iter().enumerate() {
            search.draw(family, target, &mut drawn);
            if round == 0 {
                progress(0.1 + 0.6 * (index + 1) as f32 / families.kept.len() as f32);
            }
        }
        let fits = |drawn: &&Drawn| drawn.error <= target && !tried.contains(&drawn.candidate.scene);
        let mut fitting: Vec<&Drawn> = drawn.iter().filter(fits).collect();
        fitting.sort_by(|a, b| a.ms.total_cmp(&b.ms));
        let Some(best) = fitting.first().copied().cloned() else { break };
        let kept = fitting.len();
        let pass = best.candidate.scene.quality.pass;
        let other = fitting.iter().find(|drawn| drawn.candidate.scene.quality.pass != pass);
        let other = other.map(|drawn| (drawn.candidate.label(), drawn.ms));
        let share = |done: f32| progress(0.7 + 0.3 * done);
        let verified = match verify::verify(stage, &best.candidate.scene, bound, &share) {
            Ok(verified) => Ok(verified),
            Err(ReferenceError::NoLimit(why)) => Err(why.to_string()),
            Err(ReferenceError::Exact(error)) => Err(error.to_string()),
            Err(ReferenceError::Render(error)) => {
                tried.push(best.candidate.scene.clone());
                search.failed.push((best.candidate, error));
                continue;
            }
        };
        let found = verified.as_ref().map_or(0.0, |verified| verified.error);
        log::info!("{}: {:.2e} in a small picture, {found:.2e} of the whole", best.candidate.label(), best.error);
        if found > bound.error {
            tried.push(best.candidate.scene);
            target *= 0.8 * bound.error / found; // what is missing in a small picture is missing in the next one too
            continue;
        }
        let unverified = verified.as_ref().err().cloned();
        return Ok(Pick {
            settings: best.candidate.label(),
            scene: best.candidate.scene,
            error: best.error,
            small_ms: best.ms,
            verified: verified.ok(),
            unverified,
            counts: [families.left_out, drawn.len(), kept],
            other,
            failures: search.failed.iter().map(Failure::of).collect(),
            remembered: false,
        });
    }
    if drawn.is_empty() && !search.failed.is_empty() {
        return Err(search.failed.swap_remove(0).1.into());
    }
    let nearest = drawn.iter().min_by(|a, b| a.error.total_cmp(&b.error));
    let (nearest, found) = nearest.map_or(("none".into(), f64::INFINITY), |near| (near.candidate.label(), near.error));
    Err(PickError::Bound { metric: bound.metric, asked: bound.error, nearest, found })
}

/// Small pictures and what they are held against.
struct Search<'a> {
    painter: Painter<'a>,
    library: &'a Library,
    bound: ErrorBound,
    finer: Vec<[f32; 4]>,
    /// Error of the finer picture.
    floor: f64,
    /// Candidates that could not be drawn; no other of their families is tried.
    failed: Vec<(Candidate, RenderError)>,
}

impl<'a> Search<'a> {
    fn new(stage: Stage<'a>, scene: &Scene, bound: ErrorBound) -> Result<Search<'a>, PickError> {
        let mut painter = stage.painter();
        let mut draw = |samples| -> Result<Vec<[f32; 4]>, PickError> {
            let mut drawn = Err(CompareError::Nothing.into());
            for scene in candidates::finest(scene, stage.library, samples)? {
                drawn = painter.render(&small(&scene)).map(|frame| frame.pixels).map_err(PickError::from);
                if drawn.is_ok() {
                    break;
                }
            }
            drawn
        };
        let [mut samples, most] = FINEST;
        let mut before = draw(samples / 2)?;
        let (finer, floor) = loop {
            let finer = draw(samples)?;
            // Richardson's estimate for the lowest order that pictures show, 0.8: the difference / (2^0.8 - 1).
            let floor = metric(bound.metric, &finer, &before) / (2f64.powf(0.8) - 1.0);
            if floor <= FINER * bound.error || 2 * samples > most {
                break (finer, floor);
            }
            (samples, before) = (2 * samples, finer);
        };
        Ok(Search { painter, library: stage.library, bound, finer, floor, failed: Vec::new() })
    }

    /// Draws a family with more and more samples until one fits, and none that takes longer than one that fits.
    fn draw(&mut self, family: &Candidate, target: f64, drawn: &mut Vec<Drawn>) {
        if self.failed.iter().any(|(candidate, _)| candidate.curve() == family.curve()) {
            return;
        }
        let [fewest, most] = SAMPLES;
        let steps = (0..).map(|step| (f64::from(fewest) * 2f64.powf(f64::from(step) / 2.0)).round() as u32);
        let mut least = 0.0;
        let mut before: Option<(u32, f64)> = None;
        for samples in steps.take_while(|samples| *samples <= most) {
            let candidate = candidates::with_samples(family, samples);
            let known = drawn.iter().position(|drawn| drawn.candidate.scene == candidate.scene);
            let index = match known {
                Some(index) => index,
                None if f64::from(samples) < least => continue,
                None if candidate.scene.check(self.library).is_err() => return,
                None => match self.measure(&candidate, target) {
                    Ok((error, ms)) => {
                        drawn.push(Drawn { candidate, error, ms });
                        drawn.len() - 1
                    }
                    Err(error) => return self.failed.push((candidate, error)),
                },
            };
            let (error, ms) = (drawn[index].error, drawn[index].ms);
            let fastest =
                drawn.iter().filter(|drawn| drawn.error <= target).map(|drawn| drawn.ms).fold(f64::INFINITY, f64::min);
            if error <= target || ms > 1.5 * fastest {
                return;
            }
            // Its noise is what it has for error, and more samples show no other.
            let stays = |(fewer, larger): (u32, f64)| samples >= 2 * fewer && error > STAYS * larger;
            if samples >= FLAT_FROM && before.is_some_and(stays) {
                return;
            }
            if before.is_none_or(|(fewer, _)| samples >= 2 * fewer) {
                before = Some((samples, error));
            }
            least = f64::from(samples) * (error / target).powf(1.0 / ORDER); // fewer would not do
        }
    }

    /// Draws a candidate: its error with that of the finer picture, and its time; again for that, if it has fewer errors than
    /// `target`.
    fn measure(&mut self, candidate: &Candidate, target: f64) -> Result<(f64, f64), RenderError> {
        let scene = small(&candidate.scene);
        let mut draw = || -> Result<(Vec<[f32; 4]>, f64), RenderError> {
            let frame = self.painter.render(&scene)?;
            Ok((frame.pixels, frame.measurements.gpu_ms + frame.measurements.shadow_ms.unwrap_or(0.0)))
        };
        let (pixels, mut ms) = draw()?;
        let error = metric(self.bound.metric, &pixels, &self.finer) + self.floor;
        if error <= target {
            for _ in 1..RUNS {
                ms = ms.min(draw()?.1);
            }
        }
        Ok((error, ms))
    }
}

fn metric(metric: Metric, found: &[[f32; 4]], truth: &[[f32; 4]]) -> f64 {
    metric.of(found.iter().zip(truth).map(|(a, b)| (a.map(f64::from), b.map(f64::from), 1.0)))
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
