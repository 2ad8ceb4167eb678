//! What is known of some pixels of a picture, and pictures held against it.

use super::candidates;
use crate::measure::compare::{CompareError, Stage};
use crate::measure::metric::{Errors, Metric};
use crate::measure::reference::{ReferenceError, computed_together, reference_pixels, truth_of};
use crate::measure::worker::Painter;
use crate::render::variant::{Variant, VariantError};
use crate::render::{Frame, Measurements, RenderError};
use crate::scene::{Filter, Scene};
use crate::support::random::SplitMix;
use std::ops::Range;

/// The errors that a pixel of the reference may be asked for.
const TOLERANCES: [f64; 2] = [1e-7, 1e-3];
/// A pixel that differs from a neighbor by more than this is at an edge, where few pixels have most of the error: half of
/// those that are looked at are such. Less: all of a furry object is an edge. More: a dim outline is none.
const EDGE: f32 = 0.1;
/// So many times the pixels are looked at where all matter is hard, which costs little.
const HARD: usize = 2;
/// Where some is hard, so many times the pixels beside them, as far as the outline has them: a ray that grazes an edge meets it
/// or not in all drawings alike, and then its pixel is wrong by all that it has. As long as all of the outline is among them,
/// none of these is overlooked.
const OUTLINE: usize = 2;
/// A pixel whose opacity differs from a neighbor's by more than this is one of the outline. Less: hair is one. More: that of a
/// picture which is the mean of several has fewer.
const SHARP: f32 = 0.3;
/// A finer picture that stands for a reference should be wrong by less than this part of the bound.
const FINER: f64 = 0.25;
/// Samples of the finer picture, at least and at most.
const FINEST: [u32; 2] = [256, 16_384];
/// The order of its error in the step: the lowest that pictures show, and the highest that is believed where it is seen.
const ORDERS: [f64; 2] = [0.8, 1.2];

/// Pixels of pictures of one size, and what they are in truth.
pub(super) struct Known {
    sample: Sample,
    truth: Vec<[f64; 4]>,
    /// What the truth may be wrong by itself.
    pub(super) own: Errors,
    /// Pixels that bounds prove to be so.
    pub(super) proven: usize,
}

impl Known {
    /// By the f64 reference, in about `count` pixels of the picture of `scene`, of which there are two drawings, the same one or
    /// with other samples: where they differ is looked first. Twice as many where their light is computed by fours, which costs
    /// half; and more where matter is hard and bends no ray, see [`HARD`] and [`OUTLINE`]. Each is known with an error of about
    /// `own`.
    pub(super) fn by_reference(
        stage: Stage<'_>,
        scene: &Scene,
        [frame, other]: [&Frame; 2],
        count: usize,
        own: f64,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<Known, ReferenceError> {
        let side = computed_together(scene);
        let variant = Variant::of(scene, stage.library)?;
        let outline = if side == 1 && variant.has_hard() { OUTLINE * count } else { 0 };
        let times = if side == 1 && variant.is_hard() { HARD } else { 1 };
        let sample = Sample::of([frame, other], times * count / side, side, outline);
        let truth = truth_of(scene, stage.library).map_err(VariantError::from)?;
        let tolerance = own.clamp(TOLERANCES[0], TOLERANCES[1]);
        let found =
            reference_pixels(stage.library, &truth, stage.subject, &sample.pixels, tolerance, progress, stage.stop)?;
        let estimates = found.estimate.iter().zip(&sample.weights);
        let own = Errors::of(estimates.map(|(estimate, weight)| ([*estimate; 4], [0.0; 4], *weight)));
        Ok(Known { sample, own, proven: found.proven(), truth: found.pixels })
    }

    /// By the scene drawn with ever more samples, where it has no reference: in every pixel.
    pub(super) fn by_finer_picture(
        painter: &mut Painter<'_>,
        stage: Stage<'_>,
        scene: &Scene,
        (metric, error): (Metric, f64),
    ) -> Result<Known, CompareError> {
        let filter = Filter::precise(stage.gpu.info().filters_by_few_bits());
        let mut draw = |samples| -> Result<Frame, CompareError> {
            let mut drawn = Err(CompareError::Nothing);
            for finest in candidates::finest(scene, stage.library, samples, filter)? {
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
                return Ok(Known { sample: Sample::of([&finer; 2], usize::MAX, 1, 0), truth, own, proven: 0 });
            }
            (samples, before, gap) = (2 * samples, finer, now);
        }
    }

    /// How far a picture is from what is known of these pixels.
    pub(super) fn error(&self, frame: &Frame, metric: Metric) -> f64 {
        self.sample.errors(frame, |index, _| self.truth[index]).by(metric)
    }

    /// How far two pictures are apart in these pixels.
    pub(super) fn difference(&self, frame: &Frame, other: &Frame) -> Errors {
        self.sample.errors(frame, |_, at| other.pixels[at].map(f64::from))
    }

    /// Pixels that are looked at.
    pub(super) fn count(&self) -> usize {
        self.truth.len()
    }
}

/// The error of the finest of three pictures, each with twice the samples of the one before, in parts of its difference from the
/// second: Richardson's estimate by the order that the two differences show. Source: Roache 1994, with the order bounded.
fn remaining(before: f64, difference: f64) -> f64 {
    let order = (before / difference.max(f64::MIN_POSITIVE)).log2().clamp(ORDERS[0], ORDERS[1]);
    1.0 / (2f64.powf(order) - 1.0)
}

/// Draws a scene with a painter, and gives its time on the device; or that of a picture of `times` as many pixels, whose
/// shadow volume is the same one.
pub(super) fn draw(painter: &mut Painter<'_>, scene: &Scene, times: f64) -> Result<(Frame, f64), RenderError> {
    let frame = painter.render(scene)?;
    let Measurements { gpu_ms, .. } = frame.measurements;
    let ms = times * gpu_ms + frame.measurements.alone_ms() - gpu_ms;
    Ok((frame, ms))
}

/// Pixels that stand for a picture, each for as many as its weight says.
struct Sample {
    pixels: Vec<[u32; 2]>,
    weights: Vec<f64>,
}

impl Sample {
    /// Some squares of pixels where two drawings differ, some at edges, and some elsewhere, the same for the same pictures:
    /// `wanted` of them, and beside them up to so many of an outline; or all where the picture has no more. `side`: of a square,
    /// in pixels; at the right and the bottom, less.
    fn of([frame, other]: [&Frame; 2], wanted: usize, side: usize, outline_wanted: usize) -> Sample {
        let [width, height] = frame.size.map(|side| side as usize);
        let columns = width.div_ceil(side);
        let all = columns * height.div_ceil(side);
        let within = |square: usize| {
            let [left, top] = [square % columns * side, square / columns * side];
            let rows = top..(top + side).min(height);
            rows.flat_map(move |y| (left..(left + side).min(width)).map(move |x| y * width + x))
        };
        let differs_in = |channels: Range<usize>, least: f32, &square: &usize| {
            let differs =
                |a: usize, b: usize| channels.clone().any(|c| (frame.pixels[a][c] - frame.pixels[b][c]).abs() > least);
            within(square).any(|index| {
                let (x, y) = (index % width, index / width);
                (x > 0 && differs(index, index - 1))
                    || (x + 1 < width && differs(index, index + 1))
                    || (y > 0 && differs(index, index - width))
                    || (y + 1 < height && differs(index, index + width))
            })
        };
        let is_doubtful = |&square: &usize| {
            let moved = |index: usize, c: usize| (frame.pixels[index][c] - other.pixels[index][c]).abs();
            within(square).any(|index| (0..4).any(|c| moved(index, c) > EDGE))
        };
        let mut sample = Sample { pixels: Vec::new(), weights: Vec::new() };
        let mut take = |squares: &[usize], weight: f64| {
            for index in squares.iter().flat_map(|&square| within(square)) {
                sample.pixels.push([(index % width) as u32, (index / width) as u32]);
                sample.weights.push(weight);
            }
        };
        if wanted >= all {
            take(&(0..all).collect::<Vec<_>>(), 1.0);
            return sample;
        }
        let (mut outline, rest): (Vec<usize>, Vec<usize>) =
            (0..all).partition(|square| outline_wanted > 0 && differs_in(3..4, SHARP, square));
        let (mut doubtful, rest): (Vec<usize>, Vec<usize>) = rest.into_iter().partition(is_doubtful);
        let (mut edges, mut others): (Vec<usize>, Vec<usize>) =
            rest.into_iter().partition(|square| differs_in(0..4, EDGE, square));
        let of_outline = outline.len().min(outline_wanted);
        let of_doubtful = doubtful.len().min(wanted / 2);
        let wanted = wanted - of_doubtful;
        let of_edges = edges.len().min((wanted / 2).max(wanted.saturating_sub(others.len())));
        let of_others = others.len().min(wanted - of_edges);
        let mut random = SplitMix(1);
        let strata = [
            (&mut outline, of_outline),
            (&mut doubtful, of_doubtful),
            (&mut edges, of_edges),
            (&mut others, of_others),
        ];
        for (stratum, count) in strata {
            random.shuffle(stratum);
            take(&stratum[..count], stratum.len() as f64 / count.max(1) as f64);
        }
        sample
    }

    /// How far a picture is in these pixels from what they are said to be, by their index here and in the picture.
    fn errors(&self, frame: &Frame, truth: impl Fn(usize, usize) -> [f64; 4]) -> Errors {
        let width = frame.size[0] as usize;
        let pixels = self.pixels.iter().zip(&self.weights).enumerate().map(|(index, ([x, y], weight))| {
            let at = *y as usize * width + *x as usize;
            (frame.pixels[at].map(f64::from), truth(index, at), *weight)
        });
        Errors::of(pixels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn disk(side: u32) -> Frame {
        let half = f64::from(side) / 2.0;
        let lit = |index: u32| (f64::from(index % side) - half).hypot(f64::from(index / side) - half) < 0.7 * half;
        let pixels = (0..side * side).map(|index| [f32::from(u8::from(lit(index))); 4]).collect();
        Frame { size: [side, side], pixels, measurements: Measurements::default() }
    }

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

    #[test]
    fn a_sample_stands_for_all_pixels_and_looks_at_edges() {
        for (side, square) in [1, 4, 16, 97, 256, 512].into_iter().flat_map(|side| [(side, 1), (side, 2)]) {
            let frame = disk(side);
            let sample = Sample::of([&frame; 2], 1024 / (square * square), square, 0);
            let all = (side * side) as usize;
            let distinct: BTreeSet<_> = sample.pixels.iter().collect();
            assert_eq!(distinct.len(), sample.pixels.len(), "{side}");
            // Squares of 2 are cut by the border of a picture of 97.
            let cut = if side % square as u32 == 0 { 0 } else { 16 };
            assert!(
                (all.min(1024).saturating_sub(cut)..=all.min(1024)).contains(&sample.pixels.len()),
                "{side}, {square}"
            );
            let stands_for: f64 = sample.weights.iter().sum();
            let near = if cut == 0 { 1e-6 } else { 0.02 };
            assert!((stands_for - all as f64).abs() < near * all as f64, "{side}, {square}: {stands_for}");
        }
        // Inside and outside, pixels that meet along a circle: 4 sqrt(2) r each.
        let whole = 8.0 * 2f64.sqrt() * 0.7 * 128.0;
        for outline in [1, 100, 100_000] {
            let sample = Sample::of([&disk(256); 2], 1024, 1, outline);
            let beside = sample.pixels.len() - 1024;
            assert!(beside == outline || (beside as f64 / whole - 1.0).abs() < 0.02, "{beside} of {outline}");
            assert!((sample.weights.iter().sum::<f64>() / 65_536.0 - 1.0).abs() < 1e-9, "{outline}");
        }
        let sample = Sample::of([&disk(256); 2], 1024, 1, 0);
        let at_edges = sample.weights.iter().filter(|weight| **weight < 4.0).count();
        assert!(at_edges >= 512, "{at_edges} at edges, which have much of the error");
    }

    #[test]
    fn a_sample_looks_at_the_whole_outline_of_what_has_edges_everywhere() {
        let (mut frame, side) = (disk(64), 64);
        for (index, pixel) in frame.pixels.iter_mut().enumerate() {
            pixel[0] *= (index % 2) as f32; // as marble is
        }
        let alpha = |index: usize| frame.pixels[index][3];
        let is_outline = |index: &usize| [index + 1, index + side].iter().any(|next| alpha(*index) != alpha(*next));
        let sample = Sample::of([&frame; 2], 1024, 1, 1024);
        let looked_at = |index: &usize| sample.pixels.contains(&[(index % side) as u32, (index / side) as u32]);
        let outline: Vec<usize> = (0..side * (side - 1)).filter(is_outline).collect();
        assert!(outline.len() > 100 && outline.iter().all(looked_at), "{}", outline.len());
    }

    #[test]
    fn a_sample_finds_the_error_of_a_moved_edge() {
        let (a, mut b) = (disk(128), disk(128));
        b.pixels.rotate_left(1); // one pixel to the left
        let truth: Vec<[f64; 4]> = b.pixels.iter().map(|pixel| pixel.map(f64::from)).collect();
        let whole = Errors::between(&a.pixels, &truth).rmse;
        let found = Sample::of([&a; 2], 1024, 1, 0).errors(&a, |_, at| truth[at]).rmse;
        assert!((found / whole - 1.0).abs() < 0.15, "{found} of {whole}");
    }
}
