//! The verdict on a picture, in numbers and in text.

use super::rerender::{CODES, FLOATS};
use crate::metric::{Errors, Metric};
use hypertexture::output::Encoding;

/// Share of the pixels that another device may place on the other side of a hard edge.
const AT_EDGES: f64 = 0.005;

/// Comparison of a picture with its scene.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// Encoding of the file.
    pub encoding: Encoding,
    /// Samples in depth.
    pub samples: u32,
    /// Pixels that differ from a new rendering, at all on the same device and by more than rounding on another; and all.
    pub rerendered: [usize; 2],
    /// Differing pixels whose value lies outside of the range of their neighbors.
    pub foreign: usize,
    /// Place and size of the largest difference from the new rendering.
    pub rerendered_worst: ([u32; 2], f64),
    /// Whether this version of the program rendered the picture on this device.
    pub same_device: bool,
    /// Source of the ground truth.
    pub source: &'static str,
    /// Pixels compared with the ground truth.
    pub pixels: usize,
    /// Errors of the values in the file: of a PNG the decoded codes, with light above white clipped in both.
    pub errors: Errors,
    /// Metric of the verdict: RGB over a background, where alpha is 1 everywhere.
    pub metric: Metric,
    /// Pixel with the largest error.
    pub worst: [u32; 2],
    /// Error from rounding to codes.
    pub codes: f64,
    /// Error from the step, measured with another number of samples.
    pub step: f64,
    /// Root mean square error of the ground truth: estimated from samples, and proven.
    pub truth_error: [f64; 2],
    /// Pixels whose ground truth is proven.
    pub proven: usize,
    /// Pixels whose error exceeds that of codes and step.
    pub beyond: usize,
    /// Largest error allowed.
    pub bound: f64,
    /// Whether the bound was given by the user.
    pub asked: bool,
}

impl Verdict {
    /// Whether the scene gives this picture on this device.
    pub fn is_of_scene(&self) -> bool {
        let [off, all] = self.rerendered;
        if self.same_device { off == 0 } else { self.foreign == 0 && off as f64 <= AT_EDGES * all as f64 }
    }

    /// Whether the error is within its bound.
    pub fn is_accurate(&self) -> bool {
        self.error() <= self.bound
    }

    /// Error by the metric of the verdict.
    pub fn error(&self) -> f64 {
        self.errors.by(self.metric)
    }

    /// The verdict as lines of text.
    pub fn text(&self) -> String {
        let Verdict { rerendered: [off, all], rerendered_worst: (place, most), pixels, .. } = self;
        let Verdict { errors, metric, truth_error: [estimated, proven_error], proven, worst: [x, y], .. } = self;
        let codes = match self.encoding {
            Encoding::Codes(most) => format!("{}-bit codes explain {:.1e}", most.count_ones(), self.codes),
            Encoding::Linear => "floats explain nothing".into(),
        };
        let unit = match (self.same_device, self.encoding) {
            (true, _) => "differ".into(),
            (_, Encoding::Codes(_)) => format!("differ by more than {CODES} codes"),
            (_, Encoding::Linear) => format!("differ by more than {FLOATS:.0e}"),
        };
        let here = if self.same_device { "the same device and driver" } else { "another device, driver or version" };
        let redrawn = match off {
            0 => format!("none of {all} pixels {unit}: {here}"),
            _ => format!(
                "{off} of {all} pixels {unit}, {} of them from all around them, the worst, {} {}, by {most:.2e}: {here}",
                self.foreign, place[0], place[1]
            ),
        };
        let decided = if self.asked { "as asked" } else { "no setting explains more" };
        format!(
            "redrawn    {redrawn}\n\
             truth      {pixels} pixels by {}: {metric} {:.1e}, covered {:.1e}, 99.9 % within {:.1e}, max {:.1e} at {x} {y}\n\
             explained  {codes}; the step ({} samples) {:.1e}, as measured\n\
             its own    estimated error of the truth {estimated:.0e}; proven bound {proven_error:.0e} ({proven} of {pixels} pixels \
             fully proven)\n\
             beyond     {} of {pixels} pixels are off by more than codes and 4 times the step around them\n\
             bound      {metric} {:.1e} ({decided})\n",
            self.source,
            self.error(),
            errors.covered_rmse,
            errors.p999,
            errors.max,
            self.samples,
            self.step,
            self.beyond,
            self.bound,
        )
    }
}
