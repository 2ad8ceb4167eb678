//! A candidate held against the f64 reference.

use super::ErrorBound;
use crate::measure::compare::Stage;
use crate::measure::reference::{ReferenceError, TOLERANCE, reference_pixels, truth_of};
use crate::measure::statistics::weighted_rms;
use crate::render::Frame;
use crate::render::variant::VariantError;
use crate::scene::Scene;
use crate::support::random::SplitMix;
use serde::{Deserialize, Serialize};

/// Part of the pixels that are looked at.
const PART: f64 = 0.05;
/// The fewest and the most of them.
const PIXELS: [usize; 2] = [1024, 2048];
/// The reference may be wrong by this part of the bound.
const OWN: f64 = 0.02;
/// A pixel that differs from a neighbor by more than this is at an edge, where few pixels have most of the error: half of
/// those that are looked at are such. Less: all of a furry object is an edge. More: a dim outline is none.
const EDGE: f32 = 0.1;

/// What the reference says of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verified {
    /// Error over the pixels that were looked at, or the difference from twice the samples over all pixels, if that is
    /// larger.
    pub error: f64,
    /// Root mean square of what the reference says of its own error.
    pub estimate: f64,
    /// Pixels that were looked at.
    pub pixels: usize,
    /// Milliseconds of the whole picture on the device.
    pub ms: f64,
}

pub(super) fn verify(
    stage: Stage<'_>,
    scene: &Scene,
    bound: ErrorBound,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Verified, ReferenceError> {
    let Stage { library, subject, .. } = stage;
    let mut painter = stage.painter();
    let frame = painter.render(scene)?;
    let tolerance = (OWN * bound.error).clamp(1e-7, TOLERANCE);
    let looked_at = Sample::of(&frame);
    let truth = truth_of(scene, library).map_err(VariantError::from)?;
    let reference = reference_pixels(library, &truth, subject, &looked_at.pixels, tolerance, progress)?;
    let width = scene.image.size[0] as usize;
    let drawn = looked_at.pixels.iter().map(|[x, y]| frame.pixels[*y as usize * width + *x as usize].map(f64::from));
    let pairs = drawn.zip(reference.pixels.iter().copied()).zip(&looked_at.weights);
    let error = bound.metric.of(pairs.map(|((drawn, truth), weight)| (drawn, truth, *weight)));
    // A few pixels with most of the error may not be among them: twice the samples show those too.
    let mut finer = scene.clone();
    finer.quality.samples *= 2;
    let error = match finer.check(library) {
        Ok(_) => error.max(super::metric(bound.metric, &frame.pixels, &painter.render(&finer)?.pixels)),
        Err(_) => error,
    };
    let estimate = weighted_rms(reference.estimate.into_iter().zip(looked_at.weights));
    let ms = frame.measurements.gpu_ms + frame.measurements.shadow_ms.unwrap_or(0.0);
    Ok(Verified { error, estimate, pixels: looked_at.pixels.len(), ms })
}

/// Pixels that stand for a picture, each for as many as its weight says.
struct Sample {
    pixels: Vec<[u32; 2]>,
    weights: Vec<f64>,
}

impl Sample {
    /// Some pixels at edges and some elsewhere, the same for the same picture.
    fn of(frame: &Frame) -> Sample {
        let [width, height] = frame.size.map(|side| side as usize);
        let all = width * height;
        let differs = |a: usize, b: usize| (0..4).any(|c| (frame.pixels[a][c] - frame.pixels[b][c]).abs() > EDGE);
        let at_edge = |&index: &usize| {
            let (x, y) = (index % width, index / width);
            (x > 0 && differs(index, index - 1))
                || (x + 1 < width && differs(index, index + 1))
                || (y > 0 && differs(index, index - width))
                || (y + 1 < height && differs(index, index + width))
        };
        let (mut edges, mut others): (Vec<usize>, Vec<usize>) = (0..all).partition(at_edge);
        let wanted = ((all as f64 * PART) as usize).clamp(PIXELS[0], PIXELS[1]).min(all);
        let of_edges = edges.len().min((wanted / 2).max(wanted.saturating_sub(others.len())));
        let of_others = others.len().min(wanted - of_edges);
        let mut sample = Sample { pixels: Vec::new(), weights: Vec::new() };
        let mut random = SplitMix(1);
        for (stratum, count) in [(&mut edges, of_edges), (&mut others, of_others)] {
            random.shuffle(stratum);
            let weight = stratum.len() as f64 / count.max(1) as f64;
            let pixels = stratum.iter().take(count).map(|index| [(index % width) as u32, (index / width) as u32]);
            sample.pixels.extend(pixels);
            sample.weights.extend(std::iter::repeat_n(weight, count));
        }
        sample
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Measurements;
    use std::collections::BTreeSet;

    fn disk(side: u32) -> Frame {
        let half = f64::from(side) / 2.0;
        let lit = |index: u32| (f64::from(index % side) - half).hypot(f64::from(index / side) - half) < 0.7 * half;
        let pixels = (0..side * side).map(|index| [f32::from(u8::from(lit(index))); 4]).collect();
        Frame { size: [side, side], pixels, measurements: Measurements::default() }
    }

    #[test]
    fn a_sample_stands_for_all_pixels_and_looks_at_edges() {
        for side in [1, 4, 16, 97, 256, 512] {
            let frame = disk(side);
            let sample = Sample::of(&frame);
            let all = (side * side) as usize;
            let distinct: BTreeSet<_> = sample.pixels.iter().collect();
            assert_eq!(distinct.len(), sample.pixels.len(), "{side}");
            let wanted = (all / 20).clamp(1024, 2048).min(all);
            assert!(sample.pixels.len() == wanted, "{side}: {} of {wanted}", sample.pixels.len());
            let stands_for: f64 = sample.weights.iter().sum();
            assert!((stands_for - all as f64).abs() < 1e-6 * all as f64, "{side}: {stands_for}");
        }
        let sample = Sample::of(&disk(256));
        let at_edges = sample.weights.iter().filter(|weight| **weight < 4.0).count();
        assert!(at_edges >= 512, "{at_edges} at edges, which have much of the error");
    }
}
