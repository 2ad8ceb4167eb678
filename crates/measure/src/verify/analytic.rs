//! Pictures with a known answer in every pixel, and how their error falls as samples are added.

use super::rays::{Ray, rays};
use super::{Bench, Row};
use hypertexture::gpu::Gpu;
use hypertexture::render::{RenderError, Renderer, Subject};
use hypertexture::scene::{Pass, Projection, Scene};
use hypertexture::shader::Library;

/// Orders are told of mean errors above this; below it, they are those of the rounding of f32.
const ABOVE_ROUNDING: f64 = 2e-6;

/// A picture with a known answer in every pixel.
#[derive(Clone, Copy)]
pub struct AnalyticCase {
    /// What of the truth it shows, such as the integration of its samples; empty where it is the only one.
    pub variant: &'static str,
    /// How its rays leave the camera.
    pub projection: Projection,
    /// The scene, but for pass, projection and samples, and its subject.
    pub scene: fn() -> (Scene, Subject),
    /// Numbers of samples, growing.
    pub samples: &'static [u32],
    /// The channel of a pixel that is known.
    pub channel: usize,
    /// What it must be, where that is known.
    pub truth: fn(&Ray) -> Option<f64>,
    /// The largest error that a picture may have.
    pub bound: fn(&Level) -> f64,
    /// Between what the observed order must lie; nothing where the answer is exact at once.
    pub order: Option<[f64; 2]>,
}

/// The error of one picture.
#[derive(Clone, Copy, Debug)]
pub struct Level {
    /// Samples in depth.
    pub samples: u32,
    /// Distance between them, object units.
    pub step: f64,
    /// Largest absolute error.
    pub max: f64,
    /// Mean absolute error.
    pub mean: f64,
}

/// Renders with each number of samples and compares a channel with what `expected` says of a ray; rays of which it says
/// nothing do not count.
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
    let mut levels = Vec::new();
    for &samples in samples {
        let mut scene = scene.clone();
        scene.quality.samples = samples;
        let frame = renderer.render(&scene)?;
        let off = truth.iter().map(|(i, truth)| (f64::from(frame.pixels[*i][channel]) - truth).abs());
        levels.push(Level::of(samples, f64::from(frame.measurements.step), off));
    }
    Ok(levels)
}

impl Level {
    /// Of the errors of single values.
    pub fn of(samples: u32, step: f64, off: impl Iterator<Item = f64>) -> Level {
        let off = off.map(|off| if off.is_nan() { f64::INFINITY } else { off });
        let (max, sum, count) = off.fold((0.0f64, 0.0, 0u32), |(m, s, n), d| (m.max(d), s + d, n + 1));
        // What nothing is known of is as wrong as can be.
        let (max, mean) = if count == 0 { (f64::INFINITY, f64::INFINITY) } else { (max, sum / f64::from(count)) };
        Level { samples, step, max, mean }
    }

    /// The observed order of the mean error between this and one with more samples.
    pub fn order(&self, finer: &Level) -> f64 {
        (self.mean / finer.mean).ln() / (f64::from(finer.samples) / f64::from(self.samples)).ln()
    }
}

/// The observed order over all levels above the rounding of f32; nothing where fewer than two are.
pub fn order(levels: &[Level]) -> Option<f64> {
    let above: Vec<&Level> = levels.iter().filter(|level| level.mean > ABOVE_ROUNDING).collect();
    if above.len() < 2 { None } else { Some(above[0].order(above[above.len() - 1])) }
}

impl AnalyticCase {
    /// Scene and subject, in a pass.
    pub fn in_pass(&self, pass: Pass) -> (Scene, Subject) {
        let (mut scene, subject) = (self.scene)();
        (scene.quality.pass, scene.camera.projection) = (pass, self.projection);
        (scene, subject)
    }

    /// The error with each number of samples.
    ///
    /// # Errors
    /// As [`hypertexture::render::render`].
    pub fn levels(&self, bench: &Bench<'_>, pass: Pass) -> Result<Vec<Level>, RenderError> {
        let (scene, subject) = self.in_pass(pass);
        levels(bench.gpu, &bench.library, &scene, &subject, self.samples, self.channel, self.truth)
    }

    /// A row of the report: of the finest picture, or of the first one that misses its bound.
    pub(super) fn row(&self, bench: &Bench<'_>, pass: Pass) -> Result<Row, RenderError> {
        let levels = self.levels(bench, pass)?;
        let projection = match self.projection {
            Projection::Parallel => "parallel",
            Projection::Perspective => "perspective",
        };
        let what = if self.variant.is_empty() { projection.into() } else { format!("{}, {projection}", self.variant) };
        Ok(Row { what, ..Row::of(&levels, self.bound, self.order, super::name(pass)) })
    }
}
