//! Pictures with a closed form of every pixel, and how their error falls with the number of samples.

use super::lab::{Lab, Row};
use super::rays::{Ray, rays};
use hypertexture::gpu::Gpu;
use hypertexture::render::{RenderError, Renderer, Subject};
use hypertexture::scene::{Pass, Projection, Scene};
use hypertexture::shader::Library;

/// Orders are computed from mean errors above this; below it the rounding of f32 dominates.
const ABOVE_ROUNDING: f64 = 2e-6;

/// A picture with a closed form of every pixel.
#[derive(Clone, Copy)]
pub struct AnalyticCase {
    /// Variant within the case, such as the integration; empty if there is only one.
    pub variant: &'static str,
    /// Projection.
    pub projection: Projection,
    /// Scene, except for pass, projection and samples, and its subject.
    pub scene: fn() -> (Scene, Subject),
    /// Numbers of samples, increasing.
    pub samples: &'static [u32],
    /// Channel that is compared.
    pub channel: usize,
    /// Closed form for a ray; `None` where it is unknown.
    pub truth: fn(&Ray) -> Option<f64>,
    /// Largest error allowed.
    pub bound: fn(&Level) -> f64,
    /// Range of the observed order; `None` where the picture is exact.
    pub order: Option<[f64; 2]>,
}

/// Error of one picture.
#[derive(Clone, Copy, Debug)]
pub struct Level {
    /// Samples in depth, or cells along a side.
    pub samples: u32,
    /// Distance between them, object units.
    pub step: f64,
    /// Largest absolute error.
    pub max: f64,
    /// Mean absolute error.
    pub mean: f64,
}

/// Renders with each number of samples and compares a channel with the closed form; rays without one do not count.
///
/// # Errors
/// As [`hypertexture::render::render`].
pub fn levels(
    gpu: &Gpu,
    library: &Library,
    scene: &Scene,
    subject: &Subject,
    samples: &[u32],
    channel: usize,
    expected: impl Fn(&Ray) -> Option<f64>,
) -> Result<Vec<Level>, RenderError> {
    let rays = rays(scene, subject);
    let truth: Vec<(usize, f64)> = rays.iter().enumerate().filter_map(|(i, ray)| Some((i, expected(ray)?))).collect();
    let mut renderer = Renderer::new(gpu, library, subject);
    let level = |&samples: &u32| {
        let mut scene = scene.clone();
        scene.quality.samples = samples;
        let frame = renderer.render(&scene)?;
        let off = truth.iter().map(|(i, truth)| (f64::from(frame.pixels[*i][channel]) - truth).abs());
        Ok::<_, RenderError>(Level::of(samples, f64::from(frame.measurements.step), off))
    };
    samples.iter().map(level).collect()
}

impl Level {
    /// Summary of absolute errors.
    pub fn of(samples: u32, step: f64, off: impl Iterator<Item = f64>) -> Level {
        let off = off.map(|off| if off.is_nan() { f64::INFINITY } else { off });
        let (max, sum, count) = off.fold((0.0f64, 0.0, 0u32), |(m, s, n), d| (m.max(d), s + d, n + 1));
        // No known value at all is an infinite error.
        let (max, mean) = if count == 0 { (f64::INFINITY, f64::INFINITY) } else { (max, sum / f64::from(count)) };
        Level { samples, step, max, mean }
    }

    /// Observed order of the mean error between this level and a finer one.
    pub fn order(&self, finer: &Level) -> f64 {
        (self.mean / finer.mean).ln() / (f64::from(finer.samples) / f64::from(self.samples)).ln()
    }
}

/// Observed order over all levels above the rounding of f32; `None` if there are fewer than two.
pub fn order(levels: &[Level]) -> Option<f64> {
    let above: Vec<&Level> = levels.iter().filter(|level| level.mean > ABOVE_ROUNDING).collect();
    if above.len() < 2 { None } else { Some(above[0].order(above[above.len() - 1])) }
}

impl Row {
    /// Row of the finest level, or of the first one beyond its bound.
    pub(super) fn converging(
        what: impl Into<String>,
        levels: &[Level],
        bound: impl Fn(&Level) -> f64,
        expected: Option<[f64; 2]>,
    ) -> Row {
        let missed = levels.iter().find(|level| level.max > bound(level));
        let shown = missed.or(levels.last()).copied().unwrap_or(Level::of(0, 0.0, std::iter::empty()));
        let order = expected.and_then(|_| order(levels));
        let in_order = expected.is_none_or(|[low, high]| order.is_some_and(|order| (low..=high).contains(&order)));
        let lowest = expected.map_or(f64::NEG_INFINITY, |[low, _]| 0.5 * low);
        let stalled = levels.windows(2).find(|pair| pair[0].order(&pair[1]) < lowest);
        let mut found = format!("mean {:.1e}", shown.mean);
        found += &order.map_or(String::new(), |order| format!(", order {order:.2}"));
        found += &stalled.map_or(String::new(), |pair| format!(", floor {:.1e}", pair[1].mean));
        let row = Row::new(what, format!("{} samples", shown.samples), [shown.max, bound(&shown)]);
        Row {
            expected: expected.map_or("exact".into(), |[low, high]| format!("order {low} to {high}")),
            found,
            mean: Some(shown.mean),
            order,
            ok: missed.is_none() && in_order,
            ..row
        }
    }
}

impl AnalyticCase {
    /// Scene and subject in a pass.
    pub fn in_pass(&self, pass: Pass) -> (Scene, Subject) {
        let (mut scene, subject) = (self.scene)();
        (scene.quality.pass, scene.camera.projection) = (pass, self.projection);
        (scene, subject)
    }

    /// Error with each number of samples.
    ///
    /// # Errors
    /// As [`hypertexture::render::render`].
    pub fn levels(&self, lab: &Lab<'_>, pass: Pass) -> Result<Vec<Level>, RenderError> {
        let (scene, subject) = self.in_pass(pass);
        levels(lab.gpu, &lab.library, &scene, &subject, self.samples, self.channel, self.truth)
    }

    pub(super) fn row(&self, lab: &Lab<'_>, (pass, how): (Pass, &str)) -> Result<Row, RenderError> {
        let projection = match self.projection {
            Projection::Parallel => "parallel",
            Projection::Perspective => "perspective",
        };
        let parts = [self.variant, projection, how];
        let what = parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(", ");
        Ok(Row::converging(what, &self.levels(lab, pass)?, self.bound, self.order))
    }
}
