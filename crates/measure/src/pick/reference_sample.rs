//! The reference of some pixels of a picture, and pictures held against it.

use super::bound::ErrorBound;
use super::candidates;
use super::sample::Sample;
use crate::compare::{CompareError, Session};
use crate::metric::{ABOVE, Errors, Metric};
use crate::reference::{ReferenceError, UNSEEN, computed_together, reference_pixels, truth_of};
use crate::statistics::largest;
use crate::worker::Painter;
use hypertexture::render::variant::VariantError;
use hypertexture::render::{Frame, Measurements, RenderError};
use hypertexture::scene::{Filter, Scene};
use std::ops::Range;

/// Lowest and highest tolerance of a pixel of the reference. Higher: with noise finer than the samples, one pixel in a thousand
/// is off by far more than its estimate.
const TOLERANCES: [f64; 2] = [1e-7, 1e-4];
/// Least score of a pixel, in parts of the mean or of the squared bound. Lower: pixels in which pictures agree are never compared.
/// Higher: differences between pictures count less.
const MIN_SCORE: f64 = 0.1;
/// Largest score for [`Metric::P999`], in squares of the bound: the distance beyond the bound does not count.
const MAX_SCORE: f64 = 4.0;
/// Least score of a pixel in parts of its squared difference from a neighbor: all drawings may miss the same edge. Lower overlooks
/// edges; higher makes an edge of all fur.
const MIN_EDGE_SCORE: f64 = 0.03;
/// Error of a finer picture in place of a reference, in parts of the bound.
const FINER: f64 = 0.25;
/// Least and most samples of the finer picture.
const FINEST: [u32; 2] = [256, 16_384];
/// Order of its error in the step: least and most that are believed.
const ORDERS: [f64; 2] = [0.8, 1.2];

/// Reference values of some pixels of a picture.
pub(super) struct ReferenceSample {
    size: [u32; 2],
    /// Side of the squares of pixels whose light is computed together.
    side: usize,
    sample: Sample,
    /// Scene of the reference, and the tolerance of a pixel.
    truth: Option<(Scene, f64)>,
    looked: Vec<Pixel>,
    /// Error of the finer picture in place of a reference.
    finer: Errors,
}

/// A compared pixel.
struct Pixel {
    /// Index in the picture, and index of its square.
    at: usize,
    square: usize,
    light: [f64; 4],
    /// Estimated error of `light`, and the one with all that bounds leave open.
    own: [f64; 2],
    is_proven: bool,
}

impl ReferenceSample {
    /// An empty sample of the f64 reference of a scene, with a tolerance of about `own`.
    pub(super) fn by_reference(
        session: Session<'_>,
        scene: &Scene,
        own: f64,
    ) -> Result<ReferenceSample, ReferenceError> {
        let truth = truth_of(scene, session.library).map_err(VariantError::from)?;
        let (size, side) = (scene.image.size, computed_together(scene));
        let squares = size.map(|pixels| (pixels as usize).div_ceil(side)).iter().product();
        let tolerance = own.clamp(TOLERANCES[0], TOLERANCES[1]);
        let (truth, finer) = (Some((truth, tolerance)), Errors::default());
        Ok(ReferenceSample { size, side, sample: Sample::new(squares, 1), truth, looked: Vec::new(), finer })
    }

    /// All pixels of a picture with these errors.
    fn whole(size: [u32; 2], light: Vec<[f64; 4]>, finer: Errors) -> ReferenceSample {
        let mut sample = Sample::new(light.len(), 1);
        sample.raise(&vec![1.0; light.len()], light.len());
        let pixel = |(at, light)| Pixel { at, square: at, light, own: [0.0; 2], is_proven: false };
        let looked = light.into_iter().enumerate().map(pixel).collect();
        ReferenceSample { size, side: 1, sample, truth: None, looked, finer }
    }

    /// Adds pixels by the scores of their squares, up to about `pixels`.
    pub(super) fn look(
        &mut self,
        session: Session<'_>,
        scores: &[f64],
        pixels: usize,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<(), ReferenceError> {
        let Some((truth, tolerance)) = &self.truth else { return Ok(()) };
        let new = self.sample.raise(scores, pixels.div_ceil(self.side * self.side));
        let ([width, height], side) = (self.size.map(|side| side as usize), self.side);
        let columns = width.div_ceil(side);
        let found: Vec<(usize, [u32; 2])> = new
            .into_iter()
            .flat_map(|square| {
                let [left, top] = [square % columns, square / columns].map(|at| at * side);
                let rows = top..(top + side).min(height);
                rows.flat_map(move |y| (left..(left + side).min(width)).map(move |x| [x, y]))
                    .map(move |at| (square, at.map(|at| at as u32)))
            })
            .collect();
        let places: Vec<[u32; 2]> = found.iter().map(|(_, place)| *place).collect();
        if places.is_empty() {
            return Ok(());
        }
        let light =
            reference_pixels(session.library, truth, session.subject, &places, *tolerance, progress, session.stop)?;
        let known = light.pixels.iter().zip(light.estimate.iter().zip(&light.open));
        for ((square, [x, y]), (light, (estimate, open))) in found.into_iter().zip(known) {
            self.looked.push(Pixel {
                at: y as usize * width + x as usize,
                square,
                light: *light,
                own: [*estimate, (estimate + open).min(1.0)],
                is_proven: *open <= UNSEEN,
            });
        }
        Ok(())
    }

    /// All pixels of the scene drawn with ever more samples, in place of a reference.
    pub(super) fn by_finer_picture(
        painter: &mut Painter<'_>,
        session: Session<'_>,
        scene: &Scene,
        ErrorBound { metric, error }: ErrorBound,
    ) -> Result<ReferenceSample, CompareError> {
        let filter = Filter::precise(session.gpu.info().filters_by_few_bits());
        let mut draw = |samples| -> Result<Frame, CompareError> {
            let mut drawn = Err(CompareError::Nothing);
            for finest in candidates::finest(scene, session.library, samples, filter)? {
                drawn = painter.render(&finest).map_err(CompareError::from);
                if drawn.is_ok() {
                    break;
                }
            }
            drawn
        };
        let [least, most] = FINEST;
        let mut samples = least / 2;
        let (mut before, mut gap) = (draw(samples / 2)?, 0.0);
        loop {
            let finer = draw(samples)?;
            let truth: Vec<[f64; 4]> = finer.pixels.iter().map(|pixel| pixel.map(f64::from)).collect();
            let difference = Errors::between(&before.pixels, &truth);
            let now = difference.by(metric);
            let own = difference.scaled(remaining(gap, now));
            log::debug!(
                "finer pictures: {samples} samples are off by {:.2e}, {now:.2e} from half as many",
                own.by(metric)
            );
            let is_enough = samples >= least && own.by(metric) <= FINER * error;
            if is_enough || 2 * samples > most {
                return Ok(ReferenceSample::whole(finer.size, truth, own));
            }
            (samples, before, gap) = (2 * samples, finer, now);
        }
    }

    /// Scores of all squares: squared differences from another picture of the scene, and from neighboring pixels.
    pub(super) fn scores(&self, frame: &Frame, other: &Frame, bound: ErrorBound) -> Vec<f64> {
        let channels = channels(bound.metric);
        let [width, height] = self.size.map(|side| side as usize);
        let allowed = bound.error.powi(2) * channels.len() as f64;
        let most = if bound.metric == Metric::P999 { MAX_SCORE * allowed } else { f64::MAX };
        let apart =
            |a: [f32; 4], b: [f32; 4]| -> f64 { channels.clone().map(|c| f64::from(a[c] - b[c]).powi(2)).sum() };
        let columns = width.div_ceil(self.side);
        let mut scores = vec![0.0; columns * height.div_ceil(self.side)];
        for (at, pixel) in frame.pixels.iter().enumerate() {
            let (x, y) = (at % width, at / width);
            let beside = [(x > 0).then(|| at - 1), (x + 1 < width).then(|| at + 1)];
            let above = [(y > 0).then(|| at - width), (y + 1 < height).then(|| at + width)];
            let edge =
                largest(beside.into_iter().chain(above).flatten().map(|other| apart(*pixel, frame.pixels[other])));
            let moved = apart(*pixel, other.pixels[at]);
            scores[y / self.side * columns + x / self.side] += moved.max(MIN_EDGE_SCORE * edge).min(most);
        }
        let mean = scores.iter().sum::<f64>() / scores.len() as f64;
        let least = MIN_SCORE * mean.max(allowed);
        scores.into_iter().map(|score| score.max(least)).collect()
    }

    /// Error of a picture, estimated from the compared pixels by their weights.
    pub(super) fn error(&self, frame: &Frame, metric: Metric) -> f64 {
        let pixels = self
            .looked
            .iter()
            .map(|pixel| (frame.pixels[pixel.at].map(f64::from), pixel.light, self.sample.weight(pixel.square)));
        Errors::of(pixels).by(metric)
    }

    /// Upper bound of the error of a whole picture with the confidence of [`Sample`]; infinite where none is known.
    pub(super) fn at_most(&self, frame: &Frame, scores: &[f64], metric: Metric) -> f64 {
        let off = |pixel: &Pixel, c: usize| (f64::from(frame.pixels[pixel.at][c]) - pixel.light[c]).abs();
        let sums = |value: &dyn Fn(&Pixel) -> f64| -> Vec<(usize, f64)> {
            let squares = self.looked.chunk_by(|a, b| a.square == b.square);
            squares.map(|pixels| (pixels[0].square, pixels.iter().map(value).sum())).collect()
        };
        let channels = channels(metric);
        let mean = |pixels: usize| {
            let squares = sums(&|pixel| channels.clone().map(|c| off(pixel, c).powi(2)).sum());
            (self.sample.at_most(&squares, scores, None) / (channels.len() * pixels.max(1)) as f64).sqrt()
        };
        match metric {
            Metric::Rmse | Metric::Rgb | Metric::Opacity => mean(frame.pixels.len()),
            Metric::Covered => mean(frame.pixels.iter().filter(|pixel| pixel[3] > 0.0).count()),
            Metric::Max if self.is_whole() => self.error(frame, metric),
            Metric::Max => f64::INFINITY,
            Metric::P999 => {
                let worst = |pixel: &Pixel| largest(channels.clone().map(|c| off(pixel, c)));
                let mut all: Vec<f64> = self.looked.iter().map(worst).collect();
                all.sort_by(f64::total_cmp);
                let in_square = Some((self.side * self.side) as f64);
                let is_exceeded = |most: &f64| {
                    let above = sums(&|pixel| f64::from(u8::from(worst(pixel) > *most)));
                    self.sample.at_most(&above, scores, in_square) > ABOVE * frame.pixels.len() as f64
                };
                all.get(all.partition_point(is_exceeded)).copied().unwrap_or(f64::INFINITY)
            }
        }
    }

    /// Error of the reference: estimated, and with all the opacity that bounds leave open.
    pub(super) fn own(&self, metric: Metric) -> [f64; 2] {
        let of = |which: usize| {
            let pixels = self.looked.iter();
            let pixels = pixels.map(|pixel| ([pixel.own[which]; 4], [0.0; 4], self.sample.weight(pixel.square)));
            Errors::of(pixels).by(metric) + self.finer.by(metric)
        };
        [of(0), of(1)]
    }

    /// Compared pixels, and those with a proof.
    pub(super) fn counts(&self) -> [usize; 2] {
        [self.looked.len(), self.looked.iter().filter(|pixel| pixel.is_proven).count()]
    }

    /// Whether all pixels are compared.
    pub(super) fn is_whole(&self) -> bool {
        self.looked.len() == self.size.iter().map(|side| *side as usize).product::<usize>()
    }
}

/// Channels of a metric.
fn channels(metric: Metric) -> Range<usize> {
    match metric {
        Metric::Rmse | Metric::Covered | Metric::Max | Metric::P999 => 0..4,
        Metric::Rgb => 0..3,
        Metric::Opacity => 3..4,
    }
}

/// Error of the finest of three pictures, each with twice the samples of the one before, in parts of its difference from the second:
/// Richardson's estimate with the observed order. Source: Roache 1994, with the order bounded.
fn remaining(before: f64, difference: f64) -> f64 {
    let order = (before / difference.max(f64::MIN_POSITIVE)).log2().clamp(ORDERS[0], ORDERS[1]);
    1.0 / (2f64.powf(order) - 1.0)
}

/// Draws a scene. Beside the picture, the expected milliseconds of one with `times` as many pixels and the same shadow volume.
pub(super) fn draw(painter: &mut Painter<'_>, scene: &Scene, times: f64) -> Result<(Frame, f64), RenderError> {
    let frame = painter.render(scene)?;
    let Measurements { gpu_ms, .. } = frame.measurements;
    let ms = times * gpu_ms + frame.measurements.alone_ms() - gpu_ms;
    Ok((frame, ms))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_remains_of_an_error_is_never_less_than_it_is() {
        for order in [0.8, 1.0, 1.4, 2.0] {
            let picture = |halvings: i32| 2f64.powf(-order * f64::from(halvings));
            let [before, difference] = [picture(0) - picture(1), picture(1) - picture(2)];
            let found = difference * remaining(before, difference);
            assert!((0.999..).contains(&(found / picture(2))), "{order}: {found} of {}", picture(2));
        }
        assert_eq!(remaining(0.0, 1e-3), 1.0 / (2f64.powf(ORDERS[0]) - 1.0), "nothing was seen before");
        assert!(remaining(0.0, 0.0).is_finite() && remaining(1e-3, 0.0) < 1.0);
    }
}
