//! The fastest settings of a scene within an error.
//!
//! Role: scene and bound -> the same scene with other accuracy settings, and why these. Candidates that cannot keep the bound
//! are left out beforehand; the others are drawn small, cheapest first, and held against the f64 reference in some pixels.
//! The fastest that should fit is drawn whole and held against the reference there; what is found corrects what small
//! pictures say, until nothing faster should fit. Invariants: only what is there for speed changes, so every candidate has
//! the truth of the scene as it is; what is refused was tried to its limit. Source: the protocol of numerical
//! work-precision diagrams; ratio estimators for the whole picture.

mod ahead;
mod candidates;
mod known;
mod rules;
mod search;
mod store;

use crate::measure::compare::{CompareError, Failure, Stage};
use crate::measure::metric::{Errors, Metric};
use crate::measure::reference::ReferenceError;
use crate::render::{Frame, RenderError};
use crate::scene::{RayPath, Scene};
use ahead::Ahead;
use known::{Known, draw};
use search::{Drawn, Search};
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use std::time::Duration;

/// Pixels of the whole picture that are held against the reference, at most.
const PIXELS: usize = 1024;
/// Whole pictures that are held against the reference, at most; twice as many while it is early and none keeps the bound.
const VERIFIED: usize = 8;
/// A whole picture is taken whose error is below this part of the bound: the rest is for the pixels that were not looked
/// at. Less: slower. More: bounds are broken.
const CARE: f64 = 0.95;
/// A whole picture that takes less than this is drawn again for its time, milliseconds.
const AGAIN_MS: f64 = 200.0;
/// The reference of a whole picture may be wrong by this part of the bound. Less: it takes longer. More: it is a part of the
/// error that is stated.
const OWN: f64 = 0.04;
/// A picture with so many times the samples of another one differs from it enough to show where that may have errors.
const OTHER: [RangeInclusive<f64>; 2] = [0.25..=0.75, 1.5..=4.0];
/// The first whole picture is drawn again with so many times the samples, few of which are at the same places: what one of the
/// two overlooks, the other may find.
const APART: f64 = 0.7;
/// The same where rays bend, if a picture may have as many: what is thin in glass at a glance, fewer samples overlook as well.
const APART_BENT: f64 = 2.0;
/// After so long nothing is begun that only may be faster than what keeps the bound.
const PATIENCE: Duration = Duration::from_secs(4);
/// The fewest and the most samples of a candidate.
const SAMPLES: [u32; 2] = [8, 4096];

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

/// What was found of a whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verified {
    /// Its error: that over the pixels that were looked at, with what the truth may be wrong by itself; or, if it is larger,
    /// what they say of the difference from other samples over all pixels.
    pub error: f64,
    /// What the truth may be wrong by itself, as far as samples say; a part of the error.
    pub estimate: f64,
    /// Pixels that were looked at, and in how many of them it is proven that the truth has overlooked nothing.
    pub pixels: [usize; 2],
    /// Milliseconds of the whole picture on the device.
    pub ms: f64,
}

/// What was picked.
#[derive(Clone, Debug)]
pub struct Pick {
    /// The scene, drawn with the settings that were picked.
    pub scene: Scene,
    /// Those settings in words.
    pub settings: String,
    /// What was found of the whole picture.
    pub verified: Verified,
    /// Why that is not by the reference, where there is none.
    pub unverified: Option<String>,
    /// Candidates that were left out beforehand, that were drawn, and that kept the bound; and methods that were not tried,
    /// since something kept the bound and time was up.
    pub counts: [usize; 4],
    /// The fastest settings of another pass that should keep the bound: in words, and how many times longer they should
    /// take.
    pub other: Option<(String, f64)>,
    /// Candidates that could not be drawn.
    pub failures: Vec<Failure>,
    /// Whether it is remembered from an earlier time.
    pub remembered: bool,
    /// The whole picture, where it was drawn for this.
    pub picture: Option<Frame>,
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
    /// Nobody waits for it any more.
    #[error("stopped")]
    Stopped,
    /// Nothing is that accurate.
    #[error(
        "no settings draw this scene with a {metric} error of {asked:e}: the nearest, {nearest}, has {}; allow that, or try another `--metric`",
        known(*found, *own)
    )]
    Bound {
        /// How it is measured.
        metric: Metric,
        /// What was asked for.
        asked: f64,
        /// The nearest settings in words.
        nearest: String,
        /// What the truth may be wrong by itself; a part of the error.
        own: f64,
        /// Its error.
        found: f64,
    },
}

/// An error, and how much of it is that of the truth, where that is much.
fn known(error: f64, own: f64) -> String {
    match own > 0.1 * error {
        true => format!("{error:.1e}, of which the truth may be wrong by {own:.1e} itself"),
        false => format!("{error:.1e}"),
    }
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
/// Small pictures are at most 96 pixels wide; the reference is computed for some hundred of their pixels, and for a
/// thousand of the whole. `progress` is called with the part that is done, roughly. A candidate that cannot be drawn is
/// left out, and told.
///
/// # Errors
/// The scene cannot be drawn, or no settings keep the bound.
pub fn pick(
    stage: Stage<'_>,
    scene: &Scene,
    bound: ErrorBound,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Pick, PickError> {
    let families = candidates::families(scene, stage.library, bound.error, stage.gpu.info().filters_by_few_bits())?;
    let ahead = Ahead::new(&families, stage.library, stage.gpu.info().cpu);
    std::thread::scope(|scope| {
        // Without a thread, each is linked where it is needed.
        let _ = std::thread::Builder::new().spawn_scoped(scope, || ahead.link(scene));
        let picked = fastest(stage, scene, bound, &ahead, progress);
        ahead.end();
        picked
    })
}

/// The fastest of the settings whose programs are linked ahead.
fn fastest(
    stage: Stage<'_>,
    scene: &Scene,
    bound: ErrorBound,
    ahead: &Ahead<'_>,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Pick, PickError> {
    let mut search = Search::new(stage, scene, bound, ahead, &|done| progress(0.2 * done))?;
    let mut whole = Whole { stage, bound, known: None, other: None };
    let mut best: Option<(Drawn, Verified, Frame)> = None;
    let mut nearest: Option<(String, [f64; 2])> = None;
    for round in 0..2 * VERIFIED {
        let share = |done: f32| progress((0.2 + 0.7 * (round as f32 + done) / VERIFIED as f32).min(0.9));
        if rules::has_ended(round, best.is_some(), search.is_late()) {
            break;
        }
        let Some(next) = search.next(best.as_ref().map(|(drawn, ..)| drawn), &share) else { break };
        let (verified, frame) = match whole.verify(&mut search, &next.candidate.scene, &share) {
            Ok(verified) => verified,
            Err(_) if (stage.stop)() => return Err(PickError::Stopped),
            Err(error) => {
                search.fail(next.candidate, error);
                continue;
            }
        };
        let (label, error) = (next.candidate.label(), verified.error);
        log::info!("{label}: {:.2e} in a small picture, {error:.2e} of the whole in {:.1} ms", next.error, verified.ms);
        search.learn(&next, error);
        if nearest.as_ref().is_none_or(|(_, [nearest, _])| error < *nearest) {
            nearest = Some((label, [error, verified.estimate]));
        }
        if error <= CARE * bound.error && best.as_ref().is_none_or(|(_, best, _)| verified.ms < best.ms) {
            best = Some((next, verified, frame));
        }
    }
    progress(1.0);
    let Some((drawn, verified, frame)) = best else { return Err(search.refusal(bound, nearest)) };
    Ok(Pick {
        settings: drawn.candidate.label(),
        counts: [ahead.families.left_out, search.count(), search.fitting(), search.untried()],
        other: search.other_pass(&drawn),
        scene: drawn.candidate.scene,
        verified,
        failures: search.failed.iter().map(Failure::of).collect(),
        unverified: search.unverified,
        remembered: false,
        picture: Some(frame),
    })
}

/// Whole pictures, and what is known of them.
struct Whole<'a> {
    stage: Stage<'a>,
    bound: ErrorBound,
    known: Option<Known>,
    /// The last picture that another one may be held against; no more, since it may be large.
    other: Option<(Scene, Frame)>,
}

impl Whole<'_> {
    /// Draws a scene with the painter of a search, holds it against what is known, and finds its error. What the search has no
    /// reference for has none here.
    fn verify(
        &mut self,
        search: &mut Search<'_>,
        scene: &Scene,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<(Verified, Frame), RenderError> {
        let Whole { stage, bound, known, other } = self;
        let (painter, has_reference) = (&mut search.painter, search.unverified.is_none());
        let (frame, mut ms) = draw(painter, scene, 1.0)?;
        let with = |samples: u32| {
            let mut scene = scene.clone();
            scene.quality.samples = samples;
            scene
        };
        let known = match known {
            Some(known) => known,
            none => none.insert(match has_reference {
                true => {
                    let times = |times: f64| with((times * f64::from(scene.quality.samples)).ceil() as u32);
                    let bends = scene.effect.ray_path == RayPath::Refracted;
                    let more = Some(times(APART_BENT)).filter(|more| bends && more.check(stage.library).is_ok());
                    let apart = more.unwrap_or_else(|| times(APART));
                    let drawn = draw(painter, &apart, 1.0)?.0;
                    let (_, apart) = other.insert((apart, drawn));
                    Known::by_reference(*stage, scene, [&frame, apart], PIXELS, OWN * bound.error, progress)
                        .map_err(ended)?
                }
                false => Known::by_finer_picture(painter, *stage, scene, (bound.metric, bound.error))
                    .map_err(|error| RenderError::Worker(error.to_string()))?,
            }),
        };
        let of = |errors: Errors| errors.by(bound.metric);
        let estimate = of(known.own);
        let found = known.error(&frame, bound.metric) + estimate;
        let pixels = [known.count(), known.proven];
        if found > CARE * bound.error {
            *other = Some((scene.clone(), frame.clone()));
            return Ok((Verified { error: found, estimate, pixels, ms }, frame));
        }
        if ms < AGAIN_MS {
            ms = ms.min(draw(painter, scene, 1.0)?.1); // short times are disturbed by what is done once
        }
        // A few pixels with most of the error may not be among those that are known: the difference from other samples is
        // known in all of them, and how it is related to the error in those.
        let samples = scene.quality.samples;
        let serves = |(own, _): &(Scene, Frame)| {
            let times = f64::from(own.quality.samples) / f64::from(samples);
            let mut alike = with(own.quality.samples);
            // Rays and slices have the same samples, and end as early as they say.
            alike.quality.pass = own.quality.pass;
            alike.quality.early_termination = own.quality.early_termination;
            OTHER.iter().any(|range| range.contains(&times)) && *own == alike
        };
        let (_, other) = match other.take().filter(serves) {
            Some(serving) => other.insert(serving),
            None => {
                let half = with((samples / 2).max(1));
                let frame = draw(painter, &half, 1.0)?.0;
                other.insert((half, frame))
            }
        };
        let all: Vec<[f64; 4]> = other.pixels.iter().map(|pixel| pixel.map(f64::from)).collect();
        let (here, everywhere) = (of(known.difference(&frame, other)), of(Errors::between(&frame.pixels, &all)));
        let error = found.max(if here > 0.0 { everywhere * found / here } else { everywhere });
        Ok((Verified { error, estimate, pixels, ms }, frame))
    }
}

/// A reference that was there for the small picture and is not for the whole.
fn ended(error: ReferenceError) -> RenderError {
    match error {
        ReferenceError::Render(error) => error,
        other => RenderError::Worker(other.to_string()),
    }
}
