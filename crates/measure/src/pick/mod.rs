//! The fastest settings of a scene within an error.
//!
//! Role: scene and bound -> the same scene with other accuracy settings, and why these. Candidates that cannot keep the bound
//! are left out beforehand; the others are drawn small, cheapest first, and held against the f64 reference in some pixels.
//! The fastest that should fit is drawn whole and held against the reference in a sample of its pixels, which grows until a
//! bound of the whole picture's error is within what is asked; what is found corrects what small pictures say, until nothing
//! faster should fit. Invariants: only what is there for speed changes, so every candidate has the truth of the scene as it is;
//! an error that is stated is an upper bound; what is refused was tried to its limit. Source: the protocol of numerical
//! work-precision diagrams.

mod ahead;
mod candidates;
mod known;
mod rules;
mod sample;
mod search;
mod store;

use crate::compare::{CompareError, Failure, Session};
use crate::metric::Metric;
use crate::reference::ReferenceError;
use crate::statistics::rounded_up;
use ahead::Ahead;
use hypertexture::render::{Frame, RenderError};
use hypertexture::scene::{RayPath, Scene};
use hypertexture::shader::Library;
use known::{Known, draw};
use search::{Drawn, Search};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Pixels of the whole picture that are held against the reference at first.
const PIXELS: usize = 1024;
/// So many of them at most, by doubling, while more samples may do instead. Fewer: pictures have more samples than they need.
const MORE: usize = 4 * PIXELS;
/// Whole pictures that are held against the reference, at most; twice as many while it is early and none keeps the bound.
const VERIFIED: usize = 8;
/// A picture is worth a whole one whose error should be below this part of the bound: the rest is for the pixels that are not
/// looked at. Less: slower pictures are picked. More: whole ones are drawn in vain.
const CARE: f64 = 0.85;
/// A whole picture that takes less than this is drawn again for its time, milliseconds.
const AGAIN_MS: f64 = 200.0;
/// The reference of a whole picture may be wrong by this part of the bound. Less: it takes longer. More: it is a part of the
/// error that is stated.
const OWN: f64 = 0.04;
/// A whole picture is drawn again with so many times the samples, few of which are at the same places: what one of the two
/// overlooks, the other may find.
const APART: f64 = 0.7;
/// The same where rays bend, if a picture may have as many: what is thin in glass at a glance, fewer samples overlook as well.
const APART_BENT: f64 = 2.0;
/// An error that is advised instead of one that cannot be kept is so many times that of the nearest picture; larger by as much
/// each time that it cannot be kept either, and so often.
const ADVISED: f64 = 1.1;
const ADVISED_TIMES: usize = 4;
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
    /// What its error is below, with 99.9 % of confidence in the pixels that were chosen to be looked at; with what the truth
    /// may be wrong by itself as far as samples say.
    pub error: f64,
    /// Its error by the pixels that were looked at.
    pub found: f64,
    /// What the truth may be wrong by itself, as far as samples say; a part of the error.
    pub estimate: f64,
    /// The same with all the opacity that bounds leave open; no part of the error.
    pub open: f64,
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
        "no settings draw this scene with a {metric} error of {asked:e}: the nearest, {nearest}, has {}; {}try another `--metric`",
        known(*found, *own),
        allow.map(|error| format!("{error:e} can be kept: allow that, or ")).unwrap_or_default()
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
        /// Its error, or what that is below.
        found: f64,
        /// An error that can be kept: it was tried.
        allow: Option<f64>,
    },
}

/// An error, and how much of it is that of the truth, where that is much.
fn known(error: f64, own: f64) -> String {
    match own > 0.1 * error {
        true => format!("{:.1e}, of which the truth may be wrong by {own:.1e} itself", rounded_up(error)),
        false => format!("{:.1e}", rounded_up(error)),
    }
}

/// As [`pick`], remembered on disk by scene, bound, device and driver.
///
/// # Errors
/// As [`pick`].
pub fn remembered(
    stage: Session<'_>,
    scene: &Scene,
    bound: ErrorBound,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Pick, PickError> {
    let key = store::key(stage, scene, bound)?;
    if let Some(pick) = store::load(key) {
        return Ok(pick);
    }
    let picked = within(stage, scene, bound, progress).or_else(|error| {
        let (error, advised) = advise(stage, scene, error, progress)?;
        if let Some((bound, pick)) = advised {
            store::save(store::key(stage, scene, bound)?, &pick);
        }
        Err(error)
    });
    picked.inspect(|pick| store::save(key, pick))
}

/// Picks the fastest settings for a scene within an error on this device.
///
/// Small pictures are at most 96 pixels wide; the reference is computed for some hundred of their pixels, and for a
/// thousand of the whole or more. `progress` is called with the part that is done, roughly. A candidate that cannot be drawn is
/// left out, and told.
///
/// # Errors
/// The scene cannot be drawn, or no settings keep the bound.
pub fn pick(
    stage: Session<'_>,
    scene: &Scene,
    bound: ErrorBound,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Pick, PickError> {
    within(stage, scene, bound, progress).or_else(|error| Err(advise(stage, scene, error, progress)?.0))
}

/// Adds to a bound that cannot be kept one that can: it is tried. Beside it, what is picked within that.
fn advise(
    stage: Session<'_>,
    scene: &Scene,
    refused: PickError,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<(PickError, Option<(ErrorBound, Pick)>), PickError> {
    let PickError::Bound { metric, asked, nearest, own, found, .. } = refused else { return Err(refused) };
    let mut error = found;
    let mut advised = None;
    for _ in 0..ADVISED_TIMES {
        let bound = ErrorBound { metric, error: rounded_up(ADVISED * error) };
        if !bound.error.is_finite() {
            break;
        }
        match within(stage, scene, bound, progress) {
            Ok(pick) => {
                advised = Some((bound, pick));
                break;
            }
            Err(PickError::Bound { found, .. }) => error = found.max(bound.error),
            Err(error) => return Err(error),
        }
    }
    let allow = advised.as_ref().map(|(bound, _)| bound.error);
    Ok((PickError::Bound { metric, asked, nearest, own, found, allow }, advised))
}

/// [`pick`] without advice.
fn within(
    stage: Session<'_>,
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
    stage: Session<'_>,
    scene: &Scene,
    bound: ErrorBound,
    ahead: &Ahead<'_>,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Pick, PickError> {
    let mut search = Search::new(stage, scene, bound, ahead, &|done| progress(0.2 * done))?;
    let mut whole = Whole { stage, bound, known: None };
    let mut best: Option<(Drawn, Verified, Frame)> = None;
    let mut nearest: Option<(Drawn, Verified)> = None;
    for round in 0..2 * VERIFIED {
        let share = |done: f32| progress((0.2 + 0.7 * (round as f32 + done) / VERIFIED as f32).min(0.9));
        if rules::has_ended(round, best.is_some(), search.is_late()) {
            break;
        }
        let Some(next) = search.next(best.as_ref().map(|(drawn, ..)| drawn), &share) else { break };
        let (verified, expected, frame) = match whole.verify(&mut search, &next.candidate.scene, MORE, &share) {
            Ok(verified) => verified,
            Err(_) if (stage.stop)() => return Err(PickError::Stopped),
            Err(error) => {
                search.fail(next.candidate, error);
                continue;
            }
        };
        let (label, Verified { error, found, ms, .. }) = (next.candidate.label(), verified);
        log::info!(
            "{label}: {:.2e} in a small picture, {found:.2e} of the whole, below {error:.2e}, in {ms:.1} ms",
            next.error
        );
        search.learn(&next, expected);
        let rank = |of: &Verified| (of.found > bound.error, of.error);
        if nearest.as_ref().is_none_or(|(_, nearest)| rank(&verified) < rank(nearest)) {
            nearest = Some((next.clone(), verified));
        }
        if error <= bound.error && best.as_ref().is_none_or(|(_, best, _)| verified.ms < best.ms) {
            best = Some((next, verified, frame));
        }
    }
    // Before a bound is refused that the nearest keeps as far as was seen, all of its pixels are looked at.
    if let (None, Some((drawn, last))) = (&best, &mut nearest)
        && last.found <= bound.error
    {
        let share = |done: f32| progress(0.9 + 0.1 * done);
        let (verified, _, frame) = whole.verify(&mut search, &drawn.candidate.scene, usize::MAX, &share)?;
        *last = verified;
        if verified.error <= bound.error {
            best = Some((drawn.clone(), verified, frame));
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
    stage: Session<'a>,
    bound: ErrorBound,
    known: Option<Known>,
}

impl Whole<'_> {
    /// Draws a scene with the painter of a search, and looks at pixels, `most` of them or, where the metric is of the worst pixels,
    /// all, until they show that the picture keeps the bound or does not. Beside what was found, the error that `most` pixels would
    /// show at best. What the search has no reference for has none here.
    fn verify(
        &mut self,
        search: &mut Search<'_>,
        scene: &Scene,
        most: usize,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<(Verified, f64, Frame), RenderError> {
        let Whole { stage, bound, known } = self;
        let ErrorBound { metric, error } = *bound;
        let (frame, mut ms) = draw(&mut search.painter, scene, 1.0)?;
        if frame.pixels.as_flattened().iter().any(|channel| !channel.is_finite()) {
            return Err(RenderError::Worker("some of its pixels are no numbers".into()));
        }
        let known = match (&mut *known, search.unverified.is_none()) {
            (Some(known), _) => known,
            (none, true) => none.insert(Known::by_reference(*stage, scene, OWN * error).map_err(ended)?),
            (none, false) => none.insert(
                Known::by_finer_picture(&mut search.painter, *stage, scene, (metric, error))
                    .map_err(|error| RenderError::Worker(error.to_string()))?,
            ),
        };
        let verified = |known: &Known, scores: Option<&[f64]>, ms| {
            let ([estimate, open], pixels) = (known.own(metric), known.counts());
            let found = known.error(&frame, metric) + estimate;
            let below = scores.map(|scores| known.at_most(&frame, scores, metric) + estimate);
            Verified { error: below.filter(|_| found <= error).unwrap_or(found), found, estimate, open, pixels, ms }
        };
        let first = verified(known, None, ms);
        if first.found > error {
            return Ok((first, first.found, frame));
        }
        if ms < AGAIN_MS {
            ms = ms.min(draw(&mut search.painter, scene, 1.0)?.1); // short times are disturbed by what is done once
        }
        let apart = draw(&mut search.painter, &apart(scene, stage.library), 1.0)?.0;
        let scores = known.scores(&frame, &apart, *bound);
        let most = if matches!(metric, Metric::Max | Metric::P999) { usize::MAX } else { most };
        let mut pixels = PIXELS;
        loop {
            known.look(*stage, &scores, pixels, progress).map_err(ended)?;
            let verified = verified(known, Some(&scores), ms);
            // What the pixels that were not looked at may have goes down with their number at most.
            let squares = [verified.found, verified.error].map(|error| error * error);
            let by_most = squares[0] + (squares[1] - squares[0]) * pixels as f64 / most as f64;
            let is_in_vain = pixels >= most || most < usize::MAX && by_most > error * error;
            if known.is_whole() || verified.found > error || verified.error <= error {
                return Ok((verified, verified.error, frame));
            }
            if is_in_vain {
                return Ok((verified, by_most.sqrt(), frame));
            }
            pixels *= 2;
        }
    }
}

/// A scene with other samples, of which few are at the same places.
fn apart(scene: &Scene, library: &Library) -> Scene {
    let times = |times: f64| {
        let mut other = scene.clone();
        other.quality.samples = (times * f64::from(scene.quality.samples)).ceil() as u32;
        other
    };
    let bends = scene.effect.ray_path == RayPath::Refracted;
    let more = Some(times(APART_BENT)).filter(|more| bends && more.check(library).is_ok());
    more.unwrap_or_else(|| times(APART))
}

/// A reference that was there for the small picture and is not for the whole.
fn ended(error: ReferenceError) -> RenderError {
    match error {
        ReferenceError::Render(error) => error,
        other => RenderError::Worker(other.to_string()),
    }
}
