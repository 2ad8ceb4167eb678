//! Exact pictures of scenes, the ground truth of error measurements.
//!
//! Role: the picture of a scene as the limit of ever finer samples, in f64: the scene's own program, evaluated by
//! [`hypertexture::eval`] and integrated along each ray to a stated error. Invariant: nothing of the formulas is
//! written here a second time; what the limit of a scene is, [`truth_of`] says. Rays that bend are in `bent`.

mod bent;
mod integral;
mod light;
mod parts;
mod probe;
mod proof;
mod store;
mod transport;

use crate::statistics::rms;
use hypertexture::eval::ExactError;
use hypertexture::render::variant::{Checkable, Variant, VariantError};
use hypertexture::render::{RenderError, Subject};
use hypertexture::scene::{
    BlockFormat, Effect, EmptySpace, Filter, Integration, Jitter, LightMethod, Order, Pass, Proxy, Quality, RayPath,
    Scene, Storage, TargetFormat,
};
use hypertexture::shader::{Library, LibraryError};
use light::Light;
use probe::Probe;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Default error of a pixel: a tenth of the visible difference of two pictures. A tenth of it takes two to three times as
/// long where noise has a kink at the zeros of every octave.
pub const TOLERANCE: f64 = 1e-4;
/// Most bounds of a ray before it is sampled, and after. Lower: less is proven. Higher: rays whose bounds prove nothing
/// take longer.
const BOUNDS: [usize; 2] = [64, 64];
/// Samples of the exact scene. The quadrature ignores them, but the cap of a clipping plane is 1.5 of their steps thick.
const SAMPLES: u32 = 16_384;
/// Largest tile of pixels whose rays are integrated together. Higher: the pieces fill the memory.
const TILE: [u32; 2] = [16, 8];
/// Least number of rays that are integrated together. Lower: the last few samples fill no vector.
const LEAST: usize = 32;
/// Groups of rays, if each has [`LEAST`]. Lower: threads wait for the last group.
const GROUPS: usize = 16;

/// Exact picture, or some of its pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Premultiplied linear RGBA, row by row from the top, or in the order of the pixels that were asked for.
    pub pixels: Vec<[f64; 4]>,
    /// Estimated error of each pixel's worst channel, from samples.
    pub estimate: Vec<f64>,
    /// Upper bound of the opacity that samples overlooked in each pixel, from bounds of the extinction.
    pub open: Vec<f64>,
}

/// Least visible opacity: a pixel with no more open opacity is proven.
pub const UNSEEN: f64 = 1e-3;

impl Reference {
    /// Root mean square of the estimated errors.
    pub fn error(&self) -> f64 {
        rms(self.estimate.iter().copied())
    }

    /// Root mean square of the errors with all the opacity that bounds leave open.
    pub fn bound(&self) -> f64 {
        rms(self.estimate.iter().zip(&self.open).map(|(estimate, open)| (estimate + open).min(1.0)))
    }

    /// Number of pixels in which bounds prove that samples overlooked nothing visible.
    pub fn proven(&self) -> usize {
        self.open.iter().filter(|open| **open <= UNSEEN).count()
    }
}

/// Whether the caller cancels.
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

fn go_on(stop: Stop<'_>) -> Result<(), ReferenceError> {
    if stop() { Err(ReferenceError::Stopped) } else { Ok(()) }
}

/// Error of a reference.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// The scene has no program, or its object is unusable.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The program cannot be evaluated.
    #[error("no reference for this scene: {0}")]
    Exact(#[from] ExactError),
    /// The picture has no limit.
    #[error("no reference for this scene: {0}")]
    NoLimit(&'static str),
    /// The caller cancelled.
    #[error("stopped")]
    Stopped,
}

impl From<VariantError> for ReferenceError {
    fn from(error: VariantError) -> ReferenceError {
        ReferenceError::Render(error.into())
    }
}

/// The scene whose exact picture is the ground truth of `scene`: its matter, light and camera, with every approximation for
/// speed replaced by the exact form.
///
/// Scenes with equal ground truth differ in accuracy alone. Sub-frames stay: they are a part of the camera.
///
/// # Errors
/// A module of noise or turbulence does not exist, or its header cannot be read.
pub fn truth_of(scene: &Scene, library: &Library) -> Result<Scene, LibraryError> {
    // A bent ray keeps its textures: no sum of noise may be computed along it.
    let bends = scene.effect.ray_path == RayPath::Refracted;
    let mut truth = if bends { converged_settings(scene) } else { converged_settings(&scene.unbaked(library)?) };
    truth.quality.block_format = BlockFormat::Auto;
    // Settings that the program does not read are reset.
    if let Ok(variant) = Variant::of(&truth, library) {
        let (unread, default) = (|slot| !variant.reads(slot), Effect::default());
        // All objects share them.
        let parts = truth.parts.values_mut().map(|part| &mut part.effect);
        for effect in parts.chain([&mut truth.effect]) {
            if unread("noise") {
                (effect.noise, effect.noise_repeat) = (default.noise.clone(), default.noise_repeat);
            }
            if unread("turbulence") {
                (effect.turbulence, effect.turbulence_repeat) = (default.turbulence.clone(), default.turbulence_repeat);
            }
        }
    }
    // Where nothing repeats as a block does, its size makes no difference.
    let default = Quality::default();
    let sizes: [fn(&mut Quality) -> &mut u32; 2] = [|q| &mut q.block_size, |q| &mut q.turbulence_cells];
    for size in sizes {
        let (mut other, mut default) = (truth.clone(), default.clone());
        *size(&mut other.quality) = *size(&mut default);
        if other.periods(library) == truth.periods(library) {
            truth = other;
        }
    }
    Ok(truth)
}

/// The limit of `scene` for ever more samples: like [`truth_of`], but with its blocks of noise.
pub fn converged_settings(scene: &Scene) -> Scene {
    let mut limit = scene.clone();
    let bends = limit.effect.ray_path == RayPath::Refracted;
    let quality = &mut limit.quality;
    quality.pass = if bends { Pass::March } else { Pass::Slices }; // which may have the more samples
    quality.samples = if bends { bent::FEWEST } else { SAMPLES };
    quality.integration = Integration::Point;
    (quality.empty_space, quality.fold_zero_terms) = (EmptySpace::Skip, true);
    quality.early_termination = 0.0;
    quality.target = TargetFormat::Float32;
    quality.order = Order::FrontToBack;
    (quality.proxy, quality.discard_empty_fragments) = (Proxy::Polygons, true);
    quality.filter = Filter::Device; // the same in f64
    quality.msaa = 1;
    (quality.jitter, quality.seed) = (Jitter::None, 0);
    quality.anisotropy = 1.0;
    limit.object.storage = Storage::Dense;
    if limit.light.translucency <= 0.0 {
        limit.light.method = LightMethod::Volume;
        limit.light.shadow_resolution = limit.light.shadow_resolution.min(256);
    }
    let effect = &mut limit.effect;
    if effect.gradient == "three" {
        effect.gradient = "central".into();
    }
    if effect.classify == "preintegrated" {
        effect.classify = "post".into();
    }
    limit
}

/// The exact picture of a scene, from the cache or computed.
///
/// Each pixel has an error of about `tolerance`. `progress` is called with the part that is done, and `stop` is asked every
/// few milliseconds, from any thread.
///
/// # Errors
/// The scene has no program, one that [`hypertexture::eval`] does not cover, or no limit; or `stop` was true.
pub fn reference(
    library: &Library,
    scene: &Scene,
    subject: &Subject,
    tolerance: f64,
    progress: &(dyn Fn(f32) + Sync),
    stop: Stop<'_>,
) -> Result<Reference, ReferenceError> {
    let truth = Variant::of(&truth_of(scene, library).map_err(VariantError::from)?, library)?;
    let key = store::key(&truth, library, subject, tolerance)?;
    if let Some(found) = store::load(key, truth.scene.image.size) {
        return Ok(found);
    }
    let [width, height] = truth.scene.image.size;
    let pixels: Vec<[u32; 2]> = (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).collect();
    let found = reference_pixels(library, &truth, subject, &pixels, tolerance, progress, stop)?;
    store::save(key, &found);
    Ok(found)
}

/// Side of the squares of pixels that cost as much as a single pixel: bent rays are traced in quads.
pub(crate) fn computed_together(scene: &Scene) -> usize {
    if scene.effect.ray_path == RayPath::Refracted { 2 } else { 1 }
}

/// Exact values of some pixels of a [`truth_of`] or [`converged_settings`] scene, each with an error of about `tolerance`.
///
/// # Errors
/// As [`reference()`].
pub fn reference_pixels(
    library: &Library,
    truth: &impl Checkable,
    subject: &Subject,
    pixels: &[[u32; 2]],
    tolerance: f64,
    progress: &(dyn Fn(f32) + Sync),
    stop: Stop<'_>,
) -> Result<Reference, ReferenceError> {
    let truth = truth.checked(library)?;
    if truth.scene.effect.ray_path == RayPath::Refracted {
        return bent::reference(library, &truth, subject, pixels, tolerance, progress, stop);
    }
    let (probe, mut inputs) = Probe::new(library, &truth, subject)?;
    let (count, done) = (probe.moments.len(), AtomicUsize::new(0));
    let mut sum = vec![([0.0; 4], 0.0, 0.0); pixels.len()];
    // Neighboring rays are integrated together.
    let mut order: Vec<usize> = (0..pixels.len()).collect();
    order.sort_by_key(|&at| [pixels[at][1] / TILE[1], pixels[at][0] / TILE[0]]);
    for moment in &probe.moments {
        probe.set(moment, &mut inputs, stop)?;
        let (bound, bounds) = (probe.program.bind(&inputs)?, probe.opacity.bind_with(&inputs, &moment.opacity)?);
        let together = (pixels.len() / GROUPS).clamp(LEAST, (TILE[0] * TILE[1]) as usize);
        let chunks = order.par_chunks(together).with_max_len(1).map(|chunk| {
            let here: Vec<[u32; 2]> = chunk.iter().map(|&at| pixels[at]).collect();
            let found = probe.integrate((&bound, &bounds), &here, tolerance, stop)?;
            let all = (pixels.len() * count) as f32;
            progress((done.fetch_add(chunk.len(), Ordering::Relaxed) + chunk.len()) as f32 / all);
            Ok(found)
        });
        let found: Vec<Vec<Light>> = chunks.collect::<Result<_, ReferenceError>>()?;
        for (&at, (pixel, error, open)) in order.iter().zip(found.into_iter().flatten()) {
            let sum = &mut sum[at];
            sum.0 = std::array::from_fn(|c| sum.0[c] + pixel[c] / count as f64);
            sum.1 += error / count as f64;
            sum.2 += open / count as f64;
        }
    }
    let (pixels, (estimate, open)) = sum.into_iter().map(|(pixel, error, open)| (pixel, (error, open))).unzip();
    Ok(Reference { size: truth.scene.image.size, pixels, estimate, open })
}

#[cfg(test)]
mod shell_tests;
#[cfg(test)]
mod tests;
