//! How long a comparison takes, measured on a small part of it before it begins.

use super::candidates::candidates;
use super::ground_truths::GroundTruths;
use super::{CompareError, REPEAT_MS, Session, Settings, WARM_MS, refine};
use crate::reference::{TOLERANCE, reference_pixels, truth_of};
use hypertexture::scene::Scene;
use std::time::{Duration, Instant};

/// Pixels of the reference that are computed for the forecast. Fewer: a part of the picture that is costly is missed.
/// More: the forecast comes later.
const PIXELS: u32 = 48;

/// Expected parts of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// Number of candidates.
    pub candidates: usize,
    /// Number of truths, each with a reference.
    pub truths: usize,
    /// Time of a reference that is not in the cache.
    pub reference: Duration,
    /// Time of a candidate: compiling, its picture and its timed runs.
    pub candidate: Duration,
    /// Longest time in which more samples are begun along the front, once the candidates are done.
    pub front: Duration,
}

impl Forecast {
    /// Forecast for a scene: draws its first candidate, and computes a few pixels of its own reference.
    ///
    /// # Errors
    /// The scene has no candidate.
    pub fn of(session: Session<'_>, scene: &Scene, settings: &Settings) -> Result<Forecast, CompareError> {
        let all = candidates(scene, session.library, &settings.sweep)?;
        let truths = GroundTruths::new(scene, session.library)?;
        let truths = truths.count(session.library, all.iter().map(|candidate| &candidate.scene)).max(1);
        let began = Instant::now();
        // A failure here is reported with its candidate.
        drop(all.first().map(|candidate| session.painter().render(&candidate.scene)));
        let full = usize::from(!settings.sweep.quick);
        let candidate = began.elapsed() + Duration::from_secs_f64(1e-3 * (REPEAT_MS[full] + WARM_MS[full]));
        let [width, height] = scene.image.size;
        let count = (width * height).min(PIXELS);
        let pixels: Vec<[u32; 2]> = (0..count)
            .map(|index| (f64::from(index) + 0.5) / f64::from(count) * f64::from(width * height))
            .map(|place| [place as u32 % width, place as u32 / width])
            .collect();
        let truth = truth_of(scene, session.library)?;
        let began = Instant::now();
        let known =
            reference_pixels(session.library, &truth, session.subject, &pixels, TOLERANCE, &|_| (), session.stop);
        let share = if known.is_ok() { f64::from(width * height) / f64::from(count.max(1)) } else { 0.0 };
        let reference = began.elapsed().mul_f64(share);
        let goes_on = settings.sweep.quick && settings.sweep.samples.is_none();
        let front = if goes_on { refine::BUDGET } else { Duration::ZERO };
        Ok(Forecast { candidates: all.len(), truths, reference, candidate, front })
    }

    /// The time of all.
    pub fn time(&self) -> Duration {
        self.reference * self.truths as u32 + self.candidate * self.candidates as u32 + self.front
    }

    /// Part that is done with so many references and this part of the candidates, without the samples along the front.
    pub fn done(&self, references: f64, candidates: f64) -> f64 {
        let (reference, candidate) =
            (self.reference.as_secs_f64(), self.candidate.as_secs_f64() * self.candidates as f64);
        let all = reference * self.truths as f64 + candidate;
        if all > 0.0 { ((reference * references + candidate * candidates) / all).min(1.0) } else { candidates }
    }

    /// The forecast in words.
    pub fn text(&self) -> String {
        let Forecast { candidates, truths, .. } = self;
        let minutes = (self.time().as_secs_f64() / 60.0).ceil();
        format!("{candidates} candidates, {truths} truths: about {minutes} min, if the machine stays as busy")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_count_as_much_as_they_take() {
        let seconds = Duration::from_secs;
        let (reference, candidate, front) = (seconds(90), seconds(3), seconds(60));
        let forecast = Forecast { candidates: 20, truths: 2, reference, candidate, front };
        assert_eq!(forecast.time(), seconds(300));
        assert_eq!(forecast.text(), "20 candidates, 2 truths: about 5 min, if the machine stays as busy");
        assert_eq!((forecast.done(0.0, 0.0), forecast.done(1.0, 0.5), forecast.done(2.0, 1.0)), (0.0, 0.5, 1.0));
    }
}
