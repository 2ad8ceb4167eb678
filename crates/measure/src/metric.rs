//! Errors of a picture against its reference: the one definition of every error that the program states.
//!
//! All errors are of premultiplied linear RGBA, in which light adds up: 1 is white, or opaque. Pixels have weights, so that
//! a sample of them may stand for all.

use super::statistics::{largest, weighted_quantile, weighted_rms};
use serde::Serialize;
use std::fmt;

/// Fraction of the pixels above [`Errors::p999`].
pub(super) const ABOVE: f64 = 1e-3;

/// One of the [`Errors`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Metric {
    /// [`Errors::rmse`].
    #[default]
    Rmse,
    /// [`Errors::covered_rmse`].
    Covered,
    /// [`Errors::rgb_rmse`].
    Rgb,
    /// [`Errors::opacity_rmse`].
    Opacity,
    /// [`Errors::max`].
    Max,
    /// [`Errors::p999`].
    P999,
}

impl Metric {
    /// Every metric with its name.
    pub const ALL: [(&str, Metric); 6] = [
        ("rmse", Metric::Rmse),
        ("covered", Metric::Covered),
        ("rgb", Metric::Rgb),
        ("opacity", Metric::Opacity),
        ("max", Metric::Max),
        ("p999", Metric::P999),
    ];
}

impl fmt::Display for Metric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Metric::ALL.iter().find(|(_, metric)| metric == self).map(|(name, _)| *name);
        f.write_str(name.unwrap_or_default())
    }
}

/// Count of the NaN or infinite pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{pixels} of {all} pixels are NaN or infinite, the first {} {}", .first[0], .first[1])]
pub struct NotFinite {
    /// Pixels with any such channel.
    pub pixels: usize,
    /// All pixels of the picture.
    pub all: usize,
    /// Coordinates of the first such pixel, from the top left.
    pub first: [usize; 2],
}

impl NotFinite {
    /// Counts the pixels of a picture, row by row from the top; `None` if all are finite.
    pub fn of(pixels: &[[f32; 4]], width: u32) -> Option<NotFinite> {
        let is_bad = |pixel: &&[f32; 4]| pixel.iter().any(|channel| !channel.is_finite());
        let first = pixels.iter().position(|pixel| is_bad(&pixel))?;
        let (count, width) = (pixels.iter().filter(is_bad).count(), width as usize);
        Some(NotFinite { pixels: count, all: pixels.len(), first: [first % width, first / width] })
    }
}

/// Errors of a picture against its reference; NaN or infinite if either is not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Root mean square over the four channels of all pixels.
    pub rmse: f64,
    /// Root mean square over the pixels in which the picture or its reference is not clear, undiluted by the background.
    pub covered_rmse: f64,
    /// Root mean square over R, G and B of all pixels.
    pub rgb_rmse: f64,
    /// Root mean square over the opacity of all pixels.
    pub opacity_rmse: f64,
    /// Largest difference of any channel.
    pub max: f64,
    /// 99.9th percentile over the pixels of the difference of their worst channel.
    pub p999: f64,
}

impl Errors {
    /// Errors of pixels, each a triple of the found value, the reference and a weight.
    pub fn of(pixels: impl Iterator<Item = ([f64; 4], [f64; 4], f64)>) -> Errors {
        let pixels: Vec<([f64; 4], bool, f64)> = pixels
            .map(|(found, truth, weight)| {
                let off = std::array::from_fn(|c| (found[c] - truth[c]).abs());
                let is_finite = found.iter().all(|channel| channel.is_finite());
                (off, found[3] > 0.0 || truth[3] > 0.0 || !is_finite, weight)
            })
            .collect();
        let rms = |channels: std::ops::Range<usize>, all: bool| {
            let counted = pixels.iter().filter(|(_, covered, _)| all || *covered);
            weighted_rms(counted.flat_map(|(off, _, weight)| off[channels.clone()].iter().map(|off| (*off, *weight))))
        };
        let worst: Vec<(f64, f64)> = pixels.iter().map(|(off, _, weight)| (largest(*off), *weight)).collect();
        Errors {
            rmse: rms(0..4, true),
            covered_rmse: rms(0..4, false),
            rgb_rmse: rms(0..3, true),
            opacity_rmse: rms(3..4, true),
            max: largest(worst.iter().map(|(off, _)| *off)),
            p999: weighted_quantile(worst, ABOVE),
        }
    }

    /// Errors of all pixels of a picture.
    pub fn between(found: &[[f32; 4]], truth: &[[f64; 4]]) -> Errors {
        Errors::of(found.iter().zip(truth).map(|(found, truth)| (found.map(f64::from), *truth, 1.0)))
    }

    /// All errors multiplied by a factor.
    pub fn scaled(&self, times: f64) -> Errors {
        let Errors { rmse, covered_rmse, rgb_rmse, opacity_rmse, max, p999 } = *self;
        let [rmse, covered_rmse, rgb_rmse] = [rmse, covered_rmse, rgb_rmse].map(|error| times * error);
        let [opacity_rmse, max, p999] = [opacity_rmse, max, p999].map(|error| times * error);
        Errors { rmse, covered_rmse, rgb_rmse, opacity_rmse, max, p999 }
    }

    /// The error of a metric.
    pub fn by(&self, metric: Metric) -> f64 {
        match metric {
            Metric::Rmse => self.rmse,
            Metric::Covered => self.covered_rmse,
            Metric::Rgb => self.rgb_rmse,
            Metric::Opacity => self.opacity_rmse,
            Metric::Max => self.max,
            Metric::P999 => self.p999,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_error_is_that_of_its_channels_and_pixels() {
        // One pixel of four is covered, and off by 0.1 in red, 0.2 in green and 0.3 in opacity.
        let pixel = ([0.1, 0.2, 0.0, 0.3], [0.0; 4], 1.0);
        let errors = Errors::of([pixel, ([0.0; 4], [0.0; 4], 3.0)].into_iter());
        let near =
            |metric, expected: f64| assert!((errors.by(metric) - expected).abs() < 1e-15, "{metric}: {errors:?}");
        near(Metric::Rmse, (0.14f64 / 16.0).sqrt());
        near(Metric::Covered, (0.14f64 / 4.0).sqrt());
        near(Metric::Rgb, (0.05f64 / 12.0).sqrt());
        near(Metric::Opacity, (0.09f64 / 4.0).sqrt());
        near(Metric::Max, 0.3);
        near(Metric::P999, 0.3);
    }

    #[test]
    fn one_bad_pixel_of_many_shows_in_the_largest_error_alone() {
        let mut found = vec![[0.5f32; 4]; 2000];
        found[7] = [1.0, 0.5, 0.5, 0.5];
        let errors = Errors::between(&found, &vec![[0.5; 4]; 2000]);
        assert_eq!((errors.max, errors.p999), (0.5, 0.0));
        assert!((errors.rmse - (0.25f64 / 8000.0).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn a_pixel_that_is_no_light_is_in_every_error_and_is_named() {
        for bad in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut found = vec![[0.5f32; 4]; 60];
            assert_eq!(NotFinite::of(&found, 10), None);
            (found[23], found[41]) = ([0.0, bad, 0.0, 0.0], [0.0, 0.0, 0.0, bad]);
            let mut truth = vec![[0.5; 4]; 60];
            (truth[23], truth[41]) = ([0.0; 4], [0.0; 4]);
            let errors = Errors::between(&found, &truth);
            assert!(Metric::ALL.iter().all(|(_, metric)| !errors.by(*metric).is_finite()), "{bad}: {errors:?}");
            let named = NotFinite::of(&found, 10).unwrap().to_string();
            assert_eq!(named, "2 of 60 pixels are NaN or infinite, the first 3 2");
        }
    }

    #[test]
    fn a_name_is_that_of_its_metric() {
        assert!(Metric::ALL.iter().all(|(name, metric)| *name == metric.to_string()));
    }
}
