//! Keyframes: values at times, and the way from one to the next.

use crate::scene::fields::setting::choices;
use serde::{Deserialize, Serialize};
use toml::Value;

choices! {
    /// The way to the next keyframe.
    pub enum Ease {
        /// Evenly.
        #[default]
        Linear = "linear",
        /// With a speed that does not jump at the keyframes, and never beyond their values.
        Smooth = "smooth",
        /// At once, at the time of the next keyframe.
        Hold = "hold",
    }
}

/// A value at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Key {
    /// Time, seconds.
    pub time: f64,
    /// The value of the field.
    pub value: Value,
    /// The way to the next keyframe.
    #[serde(default)]
    pub ease: Ease,
}

/// Numbers of keyframes between which a number moves.
pub(super) struct Curve<'a> {
    /// Time, ease and numbers of each keyframe, in the order of time.
    pub(super) knots: &'a [(f64, Ease, Vec<f64>)],
    /// Seconds after which they repeat.
    pub(super) period: Option<f64>,
}

impl Curve<'_> {
    /// Time, ease and number of a keyframe; those of a loop go on before the first and after the last.
    fn knot(&self, index: isize, channel: usize) -> Option<(f64, Ease, f64)> {
        let count = self.knots.len() as isize;
        let (time, ease, numbers) = &self.knots[index.rem_euclid(count) as usize];
        let turns = index.div_euclid(count) as f64;
        let shift = if turns == 0.0 { 0.0 } else { self.period? * turns };
        Some((time + shift, *ease, numbers[channel]))
    }

    /// Speed at a keyframe: 0 at the ends and at extremes, so that no value is beyond those of the keyframes.
    /// Source: Fritsch and Butland 1984, A method for constructing local monotone piecewise cubic interpolants.
    fn speed(&self, index: isize, channel: usize) -> f64 {
        let around = [index - 1, index, index + 1].map(|index| self.knot(index, channel));
        let [Some((t0, _, a)), Some((t1, _, b)), Some((t2, _, c))] = around else { return 0.0 };
        let (before, after) = ((b - a) / (t1 - t0), (c - b) / (t2 - t1));
        if before * after <= 0.0 {
            return 0.0;
        }
        let (long, short) = (2.0 * (t2 - t1) + (t1 - t0), (t2 - t1) + 2.0 * (t1 - t0));
        (long + short) / (long / before + short / after)
    }

    /// The numbers at a time.
    pub(super) fn at(&self, time: f64) -> Vec<f64> {
        let place = self.knots.partition_point(|(own, ..)| *own <= time) as isize - 1;
        (0..self.knots[0].2.len()).map(|channel| self.number(place, channel, time)).collect()
    }

    /// A number between the keyframes `place` and the next.
    fn number(&self, place: isize, channel: usize, time: f64) -> f64 {
        let (from, to) = (self.knot(place, channel), self.knot(place + 1, channel));
        let (Some((t0, ease, a)), Some((t1, _, b))) = (from, to) else {
            return from.or(to).map_or(0.0, |(_, _, end)| end);
        };
        let (length, part) = (t1 - t0, (time - t0) / (t1 - t0));
        match ease {
            Ease::Hold => a,
            Ease::Linear => a + (b - a) * part,
            Ease::Smooth => {
                let (rest, slow) = (1.0 - part, part * part * (3.0 - 2.0 * part));
                let speeds = [place, place + 1].map(|index| length * self.speed(index, channel));
                a + (b - a) * slow + part * rest * (speeds[0] * rest - speeds[1] * part)
            }
        }
    }
}
