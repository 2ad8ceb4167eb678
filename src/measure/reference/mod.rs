//! The truth that a picture is measured against.
//!
//! Role: the picture of a scene as the limit of ever finer samples, in f64: the scene's own program, evaluated by
//! [`exact`] and integrated along each ray to a stated error. Invariant: nothing of the formulas is
//! written here a second time; what the limit of a scene is, [`truth_of`] says. Rays that bend are in `bent`.

mod bent;
mod integral;
mod parts;
mod store;

use crate::exact::{self, ExactError};
use crate::measure::statistics::rms;
use crate::render::variant::{Variant, VariantError};
use crate::render::{Blocks, CpuInputs, OCTAVES_ID, RenderError, Subject};
use crate::scene::{
    BlockFormat, Effect, EmptySpace, Integration, Jitter, LightMethod, Order, Pass, Proxy, Quality, RayPath, Reject,
    Scene, Storage, TargetFormat,
};
use crate::shader::{Library, LibraryError, Linker};
use integral::{Limits, Matter, RayIntegral};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Error that a pixel is allowed, unless asked otherwise: a tenth of what pictures are told apart by. Ten times less takes
/// two to three times as long where noise has a kink at every octave's zeros.
pub const TOLERANCE: f64 = 1e-4;
/// Bounds that are computed of a ray before it is sampled, and after that, at most. Fewer: less is proven. More: rays of
/// which nothing can be proven take longer.
const BOUNDS: [usize; 2] = [64, 96];
/// A ray is not cut into more pieces than this; its error says so then.
const MOST_PIECES: usize = 8000;
/// The shortest piece, in depths of the scene: where the surface is, is known to this.
const SHORTEST: f64 = 1e-8;
/// The path of a sample, in depths of the scene: so short that only the hard region is opaque.
const PROBE: f64 = 1e-7;
/// Samples of the truth: they place no sample, but the cap of a clipping plane is 1.5 of their steps thick.
const SAMPLES: u32 = 16_384;
/// Rays that are integrated together. Fewer: the last few samples fill no vector. More: their pieces fill the memory.
const TOGETHER: usize = 128;

/// The truth of a picture, or of some of its pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Premultiplied linear RGBA, row by row from the top, or in the order of the pixels that were asked for.
    pub pixels: Vec<[f64; 4]>,
    /// For each, how far off its worst channel may be, as far as samples say.
    pub estimate: Vec<f64>,
    /// For each, the most opacity that samples may have overlooked: bounds of the extinction leave no more open.
    pub open: Vec<f64>,
}

/// Less opacity than this cannot be seen: a pixel that leaves no more open is proven.
pub const UNSEEN: f64 = 1e-3;

impl Reference {
    /// Root mean square of its own error, as far as samples say.
    pub fn error(&self) -> f64 {
        rms(self.estimate.iter().copied())
    }

    /// The same with all the opacity that bounds leave open.
    pub fn bound(&self) -> f64 {
        rms(self.estimate.iter().zip(&self.open).map(|(estimate, open)| (estimate + open).min(1.0)))
    }

    /// How many pixels bounds prove that samples have overlooked nothing in that can be seen.
    pub fn proven(&self) -> usize {
        self.open.iter().filter(|open| **open <= UNSEEN).count()
    }
}

/// Asked whether nobody waits any more.
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

fn go_on(stop: Stop<'_>) -> Result<(), ReferenceError> {
    if stop() { Err(ReferenceError::Stopped) } else { Ok(()) }
}

/// Why there is no truth.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// The scene has no program, or its object cannot be used.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The program cannot be evaluated.
    #[error("no reference for this scene: {0}")]
    Exact(#[from] ExactError),
    /// The picture has no limit.
    #[error("no reference for this scene: {0}")]
    NoLimit(&'static str),
    /// Nobody waits for it any more.
    #[error("stopped")]
    Stopped,
}

impl From<VariantError> for ReferenceError {
    fn from(error: VariantError) -> ReferenceError {
        ReferenceError::Render(error.into())
    }
}

/// The scene whose exact picture is the truth of this one: the same matter, light and camera, with everything that is
/// there for speed replaced by what it stands for.
///
/// Scenes with the same truth differ in accuracy alone. Sub-frames stay: they are a part of the camera.
///
/// # Errors
/// A module of noise or turbulence does not exist, or its header cannot be read.
pub fn truth_of(scene: &Scene, library: &Library) -> Result<Scene, LibraryError> {
    // A ray that bends reads what it reads: no sum of noise may be computed along it.
    let bends = scene.effect.ray_path == RayPath::Refracted;
    let mut truth = if bends { converged_settings(scene) } else { converged_settings(&scene.unbaked(library)?) };
    truth.quality.block_format = BlockFormat::Auto;
    // What is not read makes no difference.
    if let Ok(variant) = Variant::of(&truth, library) {
        let (effect, default) = (&mut truth.effect, Effect::default());
        if !variant.reads("noise") {
            (effect.noise, effect.noise_repeat) = (default.noise, default.noise_repeat);
        }
        if !variant.reads("turbulence") {
            (effect.turbulence, effect.turbulence_repeat) = (default.turbulence, default.turbulence_repeat);
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

/// The scene of which this one is the limit with ever more samples: as [`truth_of`], with its blocks of noise as they are.
pub fn converged_settings(scene: &Scene) -> Scene {
    let mut limit = scene.clone();
    let bends = limit.effect.ray_path == RayPath::Refracted;
    let quality = &mut limit.quality;
    quality.pass = if bends { Pass::March } else { Pass::Slices }; // which may have the more samples
    quality.samples = if bends { bent::FEWEST } else { SAMPLES };
    quality.integration = Integration::Point;
    quality.empty_space = EmptySpace::Skip;
    quality.early_termination = 0.0;
    quality.target = TargetFormat::Float32;
    quality.order = Order::FrontToBack;
    (quality.proxy, quality.reject) = (Proxy::Polygons, Reject::Discard);
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

/// The truth of a picture, from the cache or computed.
///
/// Each pixel has an error of about `tolerance`. `progress` is called with the part that is done, and `stop` is asked every
/// few milliseconds, from any thread.
///
/// # Errors
/// The scene has no program, one that [`exact`] does not cover, or no limit; or `stop` was true.
pub fn reference(
    library: &Library,
    scene: &Scene,
    subject: &Subject,
    tolerance: f64,
    progress: &(dyn Fn(f32) + Sync),
    stop: Stop<'_>,
) -> Result<Reference, ReferenceError> {
    let truth = truth_of(scene, library).map_err(VariantError::from)?;
    let key = store::key(&truth, library, subject, tolerance)?;
    if let Some(found) = store::load(key, truth.image.size) {
        return Ok(found);
    }
    let [width, height] = truth.image.size;
    let pixels: Vec<[u32; 2]> = (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).collect();
    let found = reference_pixels(library, &truth, subject, &pixels, tolerance, progress, stop)?;
    store::save(key, &found);
    Ok(found)
}

/// The light of some pixels of a scene that [`truth_of`] or [`converged_settings`] gave, each with an error of about `tolerance`.
///
/// # Errors
/// As [`reference()`].
pub fn reference_pixels(
    library: &Library,
    truth: &Scene,
    subject: &Subject,
    pixels: &[[u32; 2]],
    tolerance: f64,
    progress: &(dyn Fn(f32) + Sync),
    stop: Stop<'_>,
) -> Result<Reference, ReferenceError> {
    if truth.effect.ray_path == RayPath::Refracted {
        return bent::reference(library, truth, subject, pixels, tolerance, progress, stop);
    }
    let (probe, mut inputs) = Probe::new(library, truth, subject)?;
    let (count, done) = (probe.moments.len(), AtomicUsize::new(0));
    let mut sum = vec![([0.0; 4], 0.0, 0.0); pixels.len()];
    for moment in &probe.moments {
        probe.set(moment, &mut inputs)?;
        let (bound, bounds) = (probe.program.bind(&inputs)?, probe.opacity.bind(&inputs)?);
        let chunks = pixels.par_chunks(TOGETHER).map(|chunk| {
            let found = probe.integrate((&bound, &bounds), chunk, tolerance, stop)?;
            let all = (pixels.len() * count) as f32;
            progress((done.fetch_add(chunk.len(), Ordering::Relaxed) + chunk.len()) as f32 / all);
            Ok(found)
        });
        let found: Vec<Vec<Light>> = chunks.collect::<Result<_, ReferenceError>>()?;
        for (sum, (pixel, error, open)) in sum.iter_mut().zip(found.into_iter().flatten()) {
            sum.0 = std::array::from_fn(|c| sum.0[c] + pixel[c] / count as f64);
            sum.1 += error / count as f64;
            sum.2 += open / count as f64;
        }
    }
    let (pixels, (estimate, open)) = sum.into_iter().map(|(pixel, error, open)| (pixel, (error, open))).unzip();
    Ok(Reference { size: truth.image.size, pixels, estimate, open })
}

/// A pixel, how far off it may be, and the opacity that may be overlooked in it.
type Light = ([f64; 4], f64, f64);

/// The program of a scene that gives one sample of a ray, ready to be evaluated.
struct Probe {
    program: exact::Program,
    /// What its opacity depends on.
    opacity: exact::Program,
    cpu_inputs: CpuInputs,
    moments: Vec<Moment>,
    /// The binding of the shadow volume and the program that makes it, where one is read.
    caster: Option<(u32, exact::Program)>,
}

/// The blocks of one sub-frame, by binding.
struct Moment {
    blocks: Blocks,
    /// Those of the program that makes the shadow volume.
    caster: Blocks,
}

impl Probe {
    /// The probe of a scene, and its images and samplers.
    fn new(library: &Library, truth: &Scene, subject: &Subject) -> Result<(Probe, exact::Inputs), ReferenceError> {
        if truth.effect.classify == "stack" {
            return Err(ReferenceError::NoLimit("effect.classify = \"stack\" shows the slices themselves"));
        }
        if truth.is_half_angle() {
            return Err(ReferenceError::NoLimit("light.translucency is blurred from slice to slice"));
        }
        let own = Variant::of(truth, library)?;
        let variant = own.probe(truth, library)?;
        let program = variant.program(library, Linker::new)?;
        let cpu_inputs = CpuInputs::new(library, truth, subject, &variant, &program)?;
        let octaves = [(OCTAVES_ID, truth.effect.octaves)];
        let shadow = match CpuInputs::shadow_binding(&program) {
            None => None,
            Some(binding) => Some((binding, own.shadow(truth, library)?.program(library, Linker::new)?)),
        };
        let blocks = cpu_inputs.moments(&program)?.into_iter();
        let mut moments: Vec<Moment> = blocks.map(|blocks| Moment { blocks, caster: Blocks::new() }).collect();
        if let Some((_, caster)) = &shadow {
            for (moment, blocks) in moments.iter_mut().zip(cpu_inputs.moments(caster)?) {
                moment.caster = blocks;
            }
        }
        let inputs = cpu_inputs.exact();
        let caster = match shadow {
            None => None,
            Some((binding, caster)) => Some((binding, exact::Program::read(&caster.fragment, &octaves)?)),
        };
        let opacity = exact::Program::read_channel(&program.fragment, &octaves, (0, 3))?;
        let program = exact::Program::read(&program.fragment, &octaves)?;
        Ok((Probe { program, opacity, cpu_inputs, moments, caster }, inputs))
    }

    /// Makes the inputs those of a sub-frame.
    fn set(&self, moment: &Moment, inputs: &mut exact::Inputs) -> Result<(), ReferenceError> {
        if let Some((binding, caster)) = &self.caster {
            inputs.blocks.clone_from(&moment.caster);
            let [width, height] = self.cpu_inputs.shadow_target();
            let rows: Vec<Vec<[f32; 4]>> = (0..height)
                .into_par_iter()
                .map(|y| {
                    let at = |x| [f64::from(x) + 0.5, f64::from(y) + 0.5, 0.5, 1.0];
                    let fragment_coordinates = (0..width).map(at).collect();
                    let lanes = exact::Lanes { fragment_coordinates, varyings: BTreeMap::new() };
                    let segments = caster.bind(inputs)?.run::<f64>(&lanes)?.remove(&0).unwrap_or_default();
                    Ok(segments.into_iter().map(|four| four.map(|value| value as f32)).collect())
                })
                .collect::<Result<_, ExactError>>()?;
            let (size, values) = self.cpu_inputs.shadow_volume(&rows.concat());
            let texels = values.into_iter().map(|value| [value, 0.0, 0.0, 1.0]).collect();
            inputs.images.insert(*binding, exact::Texture { size, texels });
        }
        inputs.blocks.clone_from(&moment.blocks);
        Ok(())
    }

    /// Light and error of some pixels.
    fn integrate(
        &self,
        (bound, bounds): (&exact::BoundProgram<'_>, &exact::BoundProgram<'_>),
        pixels: &[[u32; 2]],
        tolerance: f64,
        stop: Stop<'_>,
    ) -> Result<Vec<Light>, ReferenceError> {
        let [near, far] = self.cpu_inputs.depths;
        let depth = far - near;
        let limits = Limits { error: tolerance / 16.0, shortest: depth * SHORTEST, pieces: MOST_PIECES };
        let sample = |wanted: &[(usize, f64)]| self.sample(bound, pixels, wanted);

        // Where each ray is inside the box: the depth of that sample does not matter.
        let spans: Vec<(usize, f64)> = (0..pixels.len()).map(|ray| (ray, near)).collect();
        let spans = sample(&spans)?.into_iter().map(|sample| [sample.span[0].max(near), sample.span[1].min(far)]);
        let parts = self.parts(bounds, pixels, spans.collect(), stop)?;

        let wanted: Vec<(usize, f64)> = (parts.iter().enumerate())
            .flat_map(|(index, ray)| ray.parts.iter().map(move |part| (index, part)))
            .flat_map(|(ray, part)| [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| (ray, part.from + share * part.length)))
            .collect();
        let samples = sample(&wanted)?;
        let mut samples = samples.as_chunks::<5>().0.iter();
        let mut rays: Vec<RayIntegral> = Vec::with_capacity(pixels.len());
        for parts::Ray { parts, is_vain, .. } in &parts {
            let mut ray = RayIntegral::new(if *is_vain { 0 } else { BOUNDS[1] });
            for (part, samples) in parts.iter().zip(&mut samples) {
                ray.push(part, samples.map(|sample| sample.matter));
            }
            rays.push(ray);
        }

        loop {
            go_on(stop)?;
            let coarse: Vec<Vec<usize>> = rays.iter_mut().map(|ray| ray.coarse(&limits)).collect();
            let wanted: Vec<(usize, f64)> = (rays.iter().zip(&coarse).enumerate())
                .flat_map(|(index, (ray, coarse))| ray.wanted(coarse).map(move |depth| (index, depth)))
                .collect();
            if wanted.is_empty() {
                break;
            }
            let samples: Vec<Matter> = sample(&wanted)?.iter().map(|sample| sample.matter).collect();
            let asking: Vec<(usize, [f64; 2])> = (rays.iter().zip(&coarse).enumerate())
                .flat_map(|(index, (ray, coarse))| ray.asking(coarse).map(move |part| (index, part)))
                .collect();
            let mut narrower = self.bounds(bounds, pixels, &asking)?.into_iter();
            let mut at = 0;
            for (ray, coarse) in rays.iter_mut().zip(&coarse) {
                ray.halve(coarse, &samples[at..at + 4 * coarse.len()], &mut narrower);
                at += 4 * coarse.len();
            }
        }
        let light = |ray: &RayIntegral| {
            let (light, error, open) = ray.light(&limits);
            let [r, g, b] = light.color;
            ([r, g, b, 1.0 - light.transmittance], error, open)
        };
        Ok(rays.iter().map(light).collect())
    }

    /// The path of a sample.
    fn path(&self) -> f64 {
        PROBE * (self.cpu_inputs.depths[1] - self.cpu_inputs.depths[0])
    }

    /// What the program reads at depths of rays.
    fn lanes<N>(
        &self,
        pixels: &[[u32; 2]],
        wanted: impl Iterator<Item = (usize, N)>,
        number: impl Fn(f64) -> N,
    ) -> exact::Lanes<N> {
        let (fragment_coordinates, places) = wanted
            .map(|(ray, depth)| {
                let [x, y] = pixels[ray].map(|at| number(f64::from(at) + 0.5));
                let zero = || number(0.0);
                ([x, y, number(0.5), number(1.0)], [depth, number(self.path()), zero(), zero()])
            })
            .unzip();
        exact::Lanes { fragment_coordinates, varyings: [(0, places)].into() }
    }

    /// Samples of rays at depths.
    fn sample(
        &self,
        bound: &exact::BoundProgram<'_>,
        pixels: &[[u32; 2]],
        wanted: &[(usize, f64)],
    ) -> Result<Vec<Sampled>, ReferenceError> {
        if wanted.is_empty() {
            return Ok(Vec::new());
        }
        let path = self.path();
        let lanes = self.lanes(pixels, wanted.iter().copied(), |number| number);
        let outputs = bound.run::<f64>(&lanes)?;
        let (fragments, spaces) = (&outputs[&0], &outputs[&1]);
        Ok(fragments.iter().zip(spaces).map(|(fragment, space)| Sampled::new(*fragment, *space, path)).collect())
    }
}

/// A sample and what it says about its ray.
#[derive(Clone, Copy)]
struct Sampled {
    matter: Matter,
    /// Depths at which the ray enters and leaves the box and the ball around the soft region.
    span: [f64; 2],
}

impl Sampled {
    fn new([r, g, b, alpha]: [f64; 4], [enters, leaves, ..]: [f64; 4], path: f64) -> Sampled {
        let color = if alpha > 0.0 { [r, g, b].map(|channel| channel / alpha.min(1.0)) } else { [0.0; 3] };
        Sampled { matter: Matter { color, extinction: extinction(alpha, path) }, span: [enters, leaves] }
    }
}

/// Extinction per depth by the opacity of a path.
fn extinction(alpha: f64, path: f64) -> f64 {
    match alpha {
        alpha if alpha >= 1.0 => f64::INFINITY,
        alpha if alpha > 0.0 => -(-alpha).ln_1p() / path,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests;
