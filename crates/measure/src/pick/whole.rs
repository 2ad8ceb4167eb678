//! Whole pictures, held against the reference in as many of their pixels as a bound of their error takes.

use super::bound::{ErrorBound, Verified};
use super::reference_sample::{ReferenceSample, draw};
use super::search::Search;
use crate::compare::Session;
use crate::metric::Metric;
use crate::reference::ReferenceError;
use hypertexture::render::{Frame, RenderError};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;

/// Pixels that are held against the reference at first; their number doubles until it is decided.
const PIXELS: usize = 1024;
/// Pixels at most, while more samples may do instead. Lower: pictures have more samples than they need.
pub(super) const MOST_PIXELS: usize = 4 * PIXELS;
/// Error of the reference in parts of the bound. Lower: it takes longer. Higher: it is a part of the stated error.
const OWN: f64 = 0.04;
/// Samples of the pictures whose difference tells where errors are, in parts of the picture's own; the second is drawn of
/// fast pictures only.
const OTHER_SAMPLES: [f64; 2] = [0.7, 1.6];
/// A picture that takes less than this is fast, and is drawn again for its time, milliseconds.
const AGAIN_MS: f64 = 200.0;

/// Draws whole pictures and bounds their errors.
pub(super) struct Whole<'a> {
    session: Session<'a>,
    bound: ErrorBound,
    sample: Option<ReferenceSample>,
}

impl<'a> Whole<'a> {
    pub(super) fn new(session: Session<'a>, bound: ErrorBound) -> Whole<'a> {
        Whole { session, bound, sample: None }
    }

    /// Draws a scene and looks at pixels until they show whether it keeps the bound: `most` of them, or all where the metric
    /// is of the worst pixels. Beside the error, the one that `most` pixels would state at best.
    pub(super) fn verify(
        &mut self,
        search: &mut Search<'_>,
        scene: &Scene,
        most: usize,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<(Verified, f64, Frame), RenderError> {
        let Whole { session, bound, sample } = self;
        let ErrorBound { metric, error } = *bound;
        let (frame, mut ms) = draw(&mut search.painter, scene, 1.0)?;
        if frame.pixels.as_flattened().iter().any(|channel| !channel.is_finite()) {
            return Err(RenderError::Worker("some of its pixels are NaN or infinite".into()));
        }
        let sample = match (&mut *sample, search.unverified.is_none()) {
            (Some(sample), _) => sample,
            (none, true) => none.insert(ReferenceSample::by_reference(*session, scene, OWN * error).map_err(ended)?),
            (none, false) => none.insert(
                ReferenceSample::by_finer_picture(&mut search.painter, *session, scene, *bound)
                    .map_err(|error| RenderError::Worker(error.to_string()))?,
            ),
        };
        let verified = |sample: &ReferenceSample, scores: Option<&[f64]>, ms| {
            let ([estimate, open], pixels) = (sample.own(metric), sample.counts());
            let found = sample.error(&frame, metric) + estimate;
            let below = scores.map(|scores| sample.at_most(&frame, scores, metric) + estimate);
            Verified { error: below.filter(|_| found <= error).unwrap_or(found), found, estimate, open, pixels, ms }
        };
        let first = verified(sample, None, ms);
        if first.found > error {
            return Ok((first, first.found, frame));
        }
        if ms < AGAIN_MS {
            ms = ms.min(draw(&mut search.painter, scene, 1.0)?.1); // a first run is slower
        }
        let mut scores = Vec::new();
        let others = &OTHER_SAMPLES[..if ms < AGAIN_MS { 2 } else { 1 }];
        for other in others.iter().filter_map(|times| with_samples(scene, *times, session.library)) {
            let other = draw(&mut search.painter, &other, 1.0)?.0;
            let by_other = sample.scores(&frame, &other, *bound);
            scores.resize(by_other.len(), 0.0);
            scores.iter_mut().zip(by_other).for_each(|(score, by_other)| *score = by_other.max(*score));
        }
        let most = if matches!(metric, Metric::Max | Metric::P999) { usize::MAX } else { most };
        let mut pixels = PIXELS;
        loop {
            sample.look(*session, &scores, pixels, progress).map_err(ended)?;
            let verified = verified(sample, Some(&scores), ms);
            // The part of the pixels that were not compared falls at most with their number.
            let squares = [verified.found, verified.error].map(|error| error * error);
            let by_most = squares[0] + (squares[1] - squares[0]) * pixels as f64 / most as f64;
            let is_in_vain = pixels >= most || most < usize::MAX && by_most > error * error;
            if sample.is_whole() || verified.found > error || verified.error <= error {
                return Ok((verified, verified.error, frame));
            }
            if is_in_vain {
                return Ok((verified, by_most.sqrt(), frame));
            }
            pixels *= 2;
        }
    }
}

/// The scene with so many times its samples; `None` where its check refuses them.
fn with_samples(scene: &Scene, times: f64, library: &Library) -> Option<Scene> {
    let mut other = scene.clone();
    other.quality.samples = (times * f64::from(scene.quality.samples)).ceil() as u32;
    other.check(library).is_ok().then_some(other)
}

/// A reference that the small picture has and the whole has not.
fn ended(error: ReferenceError) -> RenderError {
    match error {
        ReferenceError::Render(error) => error,
        other => RenderError::Worker(other.to_string()),
    }
}
