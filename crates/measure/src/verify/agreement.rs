//! What is said of a picture that was held against its scene.

use super::redrawn::{CODES, FLOATS};
use crate::metric::{Errors, Metric};
use hypertexture::output::Encoding;

/// The part of the pixels that another device may put to the other side of a hard edge.
const AT_EDGES: f64 = 0.005;

/// How a picture agrees with its scene.
#[derive(Clone, Debug)]
pub struct Agreement {
    /// What the numbers of the file mean.
    pub encoding: Encoding,
    /// Samples in depth of the scene.
    pub samples: u32,
    /// Pixels that differ where the scene is drawn again, by a code or a bit on the same device, by more than rounding on
    /// another; of how many.
    pub redrawn: [usize; 2],
    /// Those of them that no pixel around them explains.
    pub foreign: usize,
    /// Where the picture is furthest from what is rendered again, and by how much.
    pub redrawn_worst: ([u32; 2], f64),
    /// Whether it was rendered by this program on this device, so that none may be off.
    pub same_device: bool,
    /// What knows the truth.
    pub source: &'static str,
    /// Pixels held against the truth.
    pub pixels: usize,
    /// Their error, of what the file shows: of a PNG its decoded codes, light above white cut off in both.
    pub errors: Errors,
    /// The one that counts: of a picture over a background, whose alpha is 1 everywhere, that of RGB.
    pub metric: Metric,
    /// Where the largest error is.
    pub worst: [u32; 2],
    /// What of it the rounding to codes explains.
    pub codes: f64,
    /// What of it the step explains, as measured against other numbers of samples.
    pub step: f64,
    /// Root mean square error of the truth itself, as far as samples say, and with all that they may have overlooked.
    pub own: [f64; 2],
    /// Pixels in which bounds prove that the truth has overlooked nothing.
    pub proven: usize,
    /// Pixels whose error neither codes nor the step explain.
    pub beyond: usize,
    /// The error that is allowed.
    pub bound: f64,
    /// Whether that was asked for.
    pub asked: bool,
}

impl Agreement {
    /// Whether the picture is what its scene gives on this device.
    pub fn is_of_scene(&self) -> bool {
        let [off, all] = self.redrawn;
        match self.same_device {
            true => off == 0,
            false => self.foreign == 0 && off as f64 <= AT_EDGES * all as f64,
        }
    }

    /// Whether it is as accurate as was asked, or as its settings can be.
    pub fn is_accurate(&self) -> bool {
        self.error() <= self.bound
    }

    /// The error that counts.
    pub fn error(&self) -> f64 {
        self.errors.by(self.metric)
    }

    /// The agreement in words, line by line.
    pub fn text(&self) -> String {
        let Agreement { redrawn: [off, all], redrawn_worst: (place, most), pixels, .. } = self;
        let Agreement { errors, metric, own: [by_samples, in_all], proven, worst: [x, y], .. } = self;
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
             its own    the truth is known to {by_samples:.0e} as samples say, to {in_all:.0e} by proof, which is whole in \
             {proven} of {pixels} pixels\n\
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
