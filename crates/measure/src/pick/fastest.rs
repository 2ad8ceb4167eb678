//! The search: what is drawn whole, and when it ends.

use super::bound::{ErrorBound, Kept, Pick, PickError, Verified};
use super::search::{Search, Trial};
use super::whole::{MOST_PIXELS, Whole};
use super::{candidates, store};
use crate::compare::{Failure, Session};
use crate::statistics::rounded_up;
use hypertexture::render::Frame;
use hypertexture::scene::Scene;

/// Whole pictures that are held against the reference; twice as many while it is early and none keeps the bound.
const VERIFIED: usize = 8;
/// An error that is advised where one cannot be kept, in parts of that of the nearest picture, and how often it is raised.
const ADVISED: f64 = 1.1;
const ADVISED_TIMES: usize = 4;

/// As [`pick`], remembered on disk by scene, bound, device and driver.
///
/// # Errors
/// As [`pick`].
pub fn remembered(
    session: Session<'_>,
    scene: &Scene,
    bound: ErrorBound,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Pick, PickError> {
    let key = store::key(session, scene, bound)?;
    if let Some(pick) = store::load(key) {
        return Ok(pick);
    }
    let picked = within(session, scene, bound, progress).or_else(|error| {
        let (error, advised) = advise(session, scene, error, progress)?;
        if let Some((bound, pick)) = advised {
            store::save(store::key(session, scene, bound)?, &pick);
        }
        Err(error)
    });
    picked.inspect(|pick| store::save(key, pick))
}

/// Picks the fastest settings for a scene within an error on this device.
///
/// Small pictures are at most 96 pixels wide; the reference is computed for some hundred of their pixels, and for a
/// thousand of the whole or more. `progress` is called with the part that is done, roughly. A candidate that cannot be drawn is
/// left out, and recorded in [`Pick::failures`].
///
/// # Errors
/// The scene cannot be drawn, or no settings keep the bound.
pub fn pick(
    session: Session<'_>,
    scene: &Scene,
    bound: ErrorBound,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Pick, PickError> {
    within(session, scene, bound, progress).or_else(|error| Err(advise(session, scene, error, progress)?.0))
}

/// Adds to a bound that cannot be kept one that can: it is tried. Beside it, what is picked within that.
fn advise(
    session: Session<'_>,
    scene: &Scene,
    refused: PickError,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<(PickError, Option<(ErrorBound, Pick)>), PickError> {
    let PickError::Bound { metric, asked, nearest, own, found, compared, .. } = refused else { return Err(refused) };
    let mut error = found;
    let mut advised = None;
    for _ in 0..ADVISED_TIMES {
        let bound = ErrorBound { metric, error: rounded_up(ADVISED * error) };
        if !bound.error.is_finite() {
            break;
        }
        match within(session, scene, bound, progress) {
            Ok(pick) => {
                advised = Some((bound, pick));
                break;
            }
            Err(PickError::Bound { found, .. }) => error = found.max(bound.error),
            Err(error) => return Err(error),
        }
    }
    let allow = (advised.as_ref()).map(|(bound, pick)| Kept { error: bound.error, by_proof: pick.verified.by_proof() });
    Ok((PickError::Bound { metric, asked, nearest, own, found, compared, allow }, advised))
}

/// [`pick`] without advice.
fn within(
    session: Session<'_>,
    scene: &Scene,
    bound: ErrorBound,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Pick, PickError> {
    let families = candidates::families(scene, session.library, bound.error, session.gpu.info().filters_by_few_bits())?;
    let mut search = Search::new(session, scene, bound, &families, &|done| progress(0.2 * done))?;
    let mut whole = Whole::new(session, bound);
    let mut best: Option<((usize, Trial), Verified, Frame)> = None;
    let mut nearest: Option<((usize, Trial), Verified)> = None;
    for round in 0..2 * VERIFIED {
        let share = |done: f32| progress((0.2 + 0.7 * (round as f32 + done) / VERIFIED as f32).min(0.9));
        let [is_long, is_late] = [round >= VERIFIED, search.is_late()];
        if best.is_some() && (is_late || is_long) || is_late && is_long {
            break;
        }
        let Some(next) = search.next(best.as_ref().map(|((_, trial), ..)| *trial), &share) else { break };
        let candidate = search.candidate(next);
        let (verified, expected, frame) = match whole.verify(&mut search, &candidate.scene, MOST_PIXELS, &share) {
            Ok(verified) => verified,
            Err(_) if (session.stop)() => return Err(PickError::Stopped),
            Err(error) => {
                search.fail(next, error);
                continue;
            }
        };
        let Verified { error, found, ms, .. } = verified;
        let (label, small) = (candidate.label(), next.1.error);
        log::info!(
            "{label}: {small:.2e} in a small picture, {found:.2e} of the whole, below {error:.2e}, in {ms:.1} ms"
        );
        search.learn(next, expected);
        let rank = |of: &Verified| (of.found > bound.error, of.error);
        if nearest.as_ref().is_none_or(|(_, nearest)| rank(&verified) < rank(nearest)) {
            nearest = Some((next, verified));
        }
        if error <= bound.error && best.as_ref().is_none_or(|(_, best, _)| ms < best.ms) {
            best = Some((next, verified, frame));
        }
    }
    // If the nearest keeps the bound in its compared pixels, all its pixels are compared before the bound is refused.
    if let (None, Some((next, last))) = (&best, &mut nearest)
        && last.found <= bound.error
    {
        let share = |done: f32| progress(0.9 + 0.1 * done);
        let scene = search.candidate(*next).scene;
        let (verified, _, frame) = whole.verify(&mut search, &scene, usize::MAX, &share)?;
        *last = verified;
        if verified.error <= bound.error {
            best = Some((*next, verified, frame));
        }
    }
    progress(1.0);
    let Some((next, verified, frame)) = best else { return Err(search.refusal(nearest)) };
    let (candidate, [drawn, fitting, untried]) = (search.candidate(next), search.counts());
    Ok(Pick {
        settings: candidate.label(),
        counts: [families.left_out, drawn, fitting, untried],
        other: search.other_pass(next),
        scene: candidate.scene,
        verified,
        failures: search.failed.iter().map(Failure::of).collect(),
        unverified: search.unverified,
        remembered: false,
        picture: Some(frame),
    })
}
