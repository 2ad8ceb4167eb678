//! From a scene to a picture: the frame pipeline, read top to bottom.
//!
//! Role: [`Subject::load`] turns the object of a scene into a distance field; [`render`] turns scene and subject into a
//! [`Frame`]. Invariant: every picture that a person sees comes through [`render`].

mod bind;
mod cpu_inputs;
mod half_angle;
mod ignored;
mod inputs;
mod noise_blocks;
pub mod pass;
mod pixels;
mod shadow;
mod sparse;
mod sub_frame;
mod subject;
pub mod texture;
mod values;
pub mod variant;
mod view;

pub(crate) use cpu_inputs::{Blocks, CpuInputs};
pub use ignored::ignored;
pub(crate) use inputs::Encoded;
pub use shadow::{Transmittance, transmittance};
pub use sparse::Sparse;
pub use subject::{Subject, field_margin, open, request};
pub use view::half_height;

use crate::field::{FieldError, Progress};
use crate::gpu::{self, Gpu, GpuError};
use crate::render::variant::{Program, Variant, VariantError};
use crate::scene::{Order, Pass, Scene, TargetFormat};
use crate::shader::{Library, Linker};
use crate::shape::ShapeError;
use pixels::{add, check_finite, mean};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::time::Instant;
use sub_frame::SubFrame;

/// A picture and what it took.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Premultiplied linear RGBA, row by row from the top.
    pub pixels: Vec<[f32; 4]>,
    /// What it took.
    pub measurements: Measurements,
}

/// What a frame took.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Measurements {
    /// Slots and modules of the program.
    pub modules: String,
    /// Whether the program was linked when the crate was built.
    pub shipped: bool,
    /// What the scene did not need.
    #[serde(deserialize_with = "crate::render::variant::parts")]
    pub left_out: Vec<&'static str>,
    /// Octaves that the turbulence of the scene has, and those that were asked for; `None` where none is read.
    pub octaves: Option<[u32; 2]>,
    /// Slices drawn.
    pub slices: u32,
    /// Distance between slices, object units.
    pub step: f32,
    /// Fragments shaded, where the device counts them.
    pub fragments: Option<u64>,
    /// Milliseconds until the program was ready: linked, made a pipeline of, and used once.
    pub compile_ms: f64,
    /// Milliseconds of the slices or rays on the device.
    pub gpu_ms: f64,
    /// Milliseconds of the shadow volume on the device; `None` without shadows.
    pub shadow_ms: Option<f64>,
    /// Longest submission, milliseconds.
    pub longest_ms: f64,
    /// Milliseconds of everything, wall clock.
    pub total_ms: f64,
    /// Bytes of images on the device.
    pub device_bytes: u64,
    /// What the bricks of a volume save; `None` where the volume is stored as a whole.
    pub sparse: Option<Sparse>,
    /// Largest error of a stored distance, object units; 0 for a formula.
    pub quantization: f32,
    /// Radius beyond which warps along the radius hold their step, where their formula has matter there; object units.
    pub held_beyond: Option<f32>,
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The input cannot be read.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The distance field cannot be computed.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The scene has no valid program.
    #[error(transparent)]
    Variant(#[from] VariantError),
    /// The device refuses.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A scene asks for what pre-classification cannot do.
    #[error("effect.classify = {0}: needs {1}; use classify = \"post\"")]
    Classification(String, &'static str),
    /// Eye and light do not look through the slices in one order.
    #[error("light.method = \"half_angle\": {0}; {1}, or use light.method = \"volume\"")]
    HalfAngle(&'static str, &'static str),
    /// A program reads what the subject was loaded without.
    #[error("the subject has no {0}, which the program reads; load it with the scene that is rendered")]
    Missing(&'static str),
    /// The program has a block member that the renderer does not know.
    #[error("`{0}` is in no block of interface.glsl; declare it with `// @param` in a module")]
    Unfilled(String),
    /// What a worker says.
    #[error("{0}")]
    Worker(String),
    /// A worker has ended by the scene.
    #[error("{0}; what else there is to draw goes on")]
    Ended(String),
    /// A target that the device has, and that was read back wrong.
    #[error(
        "the picture holds {count} values that are not finite, the first at pixel {x}, {y}; please report the scene"
    )]
    NotFinite {
        /// How many.
        count: usize,
        /// Column of the first.
        x: usize,
        /// Row of the first.
        y: usize,
    },
}

/// Renders a scene.
///
/// The pixels are premultiplied linear RGBA without the background. A hard surface is located within the step
/// (`measurements.step`); a ray that grazes an edge for less than a step may miss it.
/// The error in soft matter is of the order of the step, and with `quality.integration = "segment"` of its square.
///
/// # Errors
/// The scene has no valid program, or the device refuses.
pub fn render(gpu: &Gpu, library: &Library, scene: &Scene, subject: &Subject) -> Result<Frame, RenderError> {
    Renderer::new(gpu, library, subject).render(scene)
}

/// Renders scenes of one subject: what was made for one picture and fits the next is not made again.
pub struct Renderer<'a> {
    gpu: &'a Gpu,
    library: &'a Library,
    subject: &'a Subject,
    progress: Progress<'a>,
    prepared: Option<Prepared<'a>>,
}

impl<'a> Renderer<'a> {
    /// A renderer that has made nothing yet.
    pub fn new(gpu: &'a Gpu, library: &'a Library, subject: &'a Subject) -> Renderer<'a> {
        Renderer { gpu, library, subject, progress: &|_| (), prepared: None }
    }

    /// Calls `progress` with the part of a block of noise that is done, from any thread, while one is made: the largest take
    /// seconds.
    #[must_use]
    pub fn with_progress(self, progress: Progress<'a>) -> Renderer<'a> {
        Renderer { progress, ..self }
    }

    /// Renders a scene, as [`render`] does, bit for bit.
    ///
    /// # Errors
    /// As [`render`].
    pub fn render(&mut self, scene: &Scene) -> Result<Frame, RenderError> {
        let all = 0..scene.image.size[1];
        self.render_bands(scene, std::slice::from_ref(&all))
    }

    /// Renders some of the pictures of which a picture with `quality.supersampling` is the mean, by their numbers from 0
    /// on: their mean, in bands as [`Renderer::render_bands`] has them. The mean over all numbers is the whole picture.
    ///
    /// # Errors
    /// As [`render`].
    ///
    /// # Panics
    /// Without a number, or with one that is not below `quality.supersampling`.
    pub fn render_part(&mut self, scene: &Scene, bands: &[Range<u32>], numbers: &[u32]) -> Result<Frame, RenderError> {
        let count = scene.quality.supersampling;
        assert!(!numbers.is_empty() && numbers.iter().all(|&number| number < count), "{numbers:?} of {count}");
        self.render_sub_frames(scene, bands, |number| numbers.contains(&number))
    }

    /// Renders some bands of a picture, ranges of rows in it that neither overlap nor touch. Their pixels are those of
    /// the whole picture, bit for bit; the others are undefined.
    ///
    /// # Errors
    /// As [`render`].
    pub fn render_bands(&mut self, scene: &Scene, bands: &[Range<u32>]) -> Result<Frame, RenderError> {
        self.render_sub_frames(scene, bands, |_| true)
    }

    fn render_sub_frames(
        &mut self,
        scene: &Scene,
        bands: &[Range<u32>],
        wanted: impl Fn(u32) -> bool,
    ) -> Result<Frame, RenderError> {
        let start = Instant::now();
        let variant = Variant::of(scene, self.library)?;
        let mut prepared = match self.prepared.take() {
            Some(prepared) if prepared.fits(scene, &variant) => prepared,
            other => {
                let made = match other {
                    Some(other) if other.reads_the_same(scene, &variant) => (Some(other.program), Some(other.bound)),
                    Some(other) if other.runs(&variant) => (Some(other.program), None),
                    _ => (None, None),
                };
                Prepared::new((self.gpu, self.library, self.subject), scene, &variant, made, self.progress)?
            }
        };
        let mut frame = prepared.frame(scene, &variant, bands, wanted)?;
        self.prepared = Some(prepared);
        frame.measurements.total_ms = start.elapsed().as_secs_f64() * 1e3;
        Ok(frame)
    }
}

/// A scene with all that its pictures share, made once: program, pipeline, images and targets.
struct Prepared<'a> {
    gpu: &'a Gpu,
    subject: &'a Subject,
    scene: Scene,
    variant: Variant,
    program: Program,
    bound: bind::BoundInputs,
    pipeline: gpu::Pipeline,
    /// What casts the shadows of a scene that has them.
    caster: Option<shadow::Caster>,
    /// What hands the light from slice to slice, in a scene that has it do so.
    half_angle: Option<half_angle::HalfAngle>,
    color: gpu::Image,
    resolved: Option<gpu::Image>,
    compile_ms: f64,
}

impl<'a> Prepared<'a> {
    /// Makes what the pictures of a scene share; its program and what that reads may be `made` already.
    fn new(
        (gpu, library, subject): (&'a Gpu, &'a Library, &'a Subject),
        scene: &Scene,
        variant: &Variant,
        (linked, bound): (Option<Program>, Option<bind::BoundInputs>),
        progress: Progress<'_>,
    ) -> Result<Prepared<'a>, RenderError> {
        let start = Instant::now();
        let program = linked.map_or_else(|| variant.program(library, Linker::new), Ok)?;
        let mut compile_ms = start.elapsed().as_secs_f64() * 1e3;
        let quality = &scene.quality;
        let bound = bound.map_or_else(
            || {
                let view = view::View::of(scene, subject, variant);
                let planes = view.planes(quality.samples);
                let inputs = inputs::Inputs::new(scene, subject, variant, &program, (&view, &planes), progress)?;
                bind::BoundInputs::new(gpu, &program, &inputs)
            },
            Ok,
        )?;
        let format = match quality.target {
            TargetFormat::Unorm8 => gpu::Format::Rgba8Unorm,
            TargetFormat::Float16 => gpu::Format::Rgba16Float,
            TargetFormat::Float32 => gpu::Format::Rgba32Float,
        };
        let blend = match (quality.pass, quality.order) {
            (Pass::March, _) => gpu::Blend::Replace,
            _ if scene.is_half_angle() => half_angle::blend(scene),
            (Pass::Slices, Order::FrontToBack) => gpu::Blend::Under,
            (Pass::Slices, Order::BackToFront) => gpu::Blend::Over,
        };
        let bindings: Vec<gpu::Binding> = program.resources.iter().map(bind::binding).collect();
        let pipeline_start = Instant::now();
        let pipeline = gpu::Pipeline::new(
            gpu,
            &gpu::PipelineDescription {
                vertex: &program.vertex,
                fragment: &program.fragment,
                constants: &[(OCTAVES_ID, scene.effect.octaves)],
                bindings: &bindings,
                attributes: if quality.pass == Pass::Slices { pass::attributes(quality.proxy) } else { &[] },
                format,
                samples: quality.msaa,
                blend,
            },
        )?;
        let casts = program.reads(inputs::SHADOW);
        let caster = casts.then(|| shadow::Caster::new(gpu, library, scene, variant)).transpose()?;
        let half_angle = scene.is_half_angle().then(|| half_angle::HalfAngle::new(gpu, library, scene, variant));
        let half_angle = half_angle.transpose()?;
        compile_ms += pipeline_start.elapsed().as_secs_f64() * 1e3;
        let [width, height] = scene.image.size;
        let plane = gpu::Dimension::Plane(width, height);
        let color = gpu::Image::new(gpu, "target", plane, format, gpu::ImageUse::Target(quality.msaa))?;
        let resolved = match quality.msaa {
            1 => None,
            _ => Some(gpu::Image::new(gpu, "resolved target", plane, format, gpu::ImageUse::Target(1))?),
        };
        let (scene, variant) = (scene.clone(), variant.clone());
        Ok(Prepared {
            gpu,
            subject,
            scene,
            variant,
            program,
            bound,
            pipeline,
            caster,
            half_angle,
            color,
            resolved,
            compile_ms,
        })
    }

    /// Whether all of this serves another scene as well: it differs in what a picture is drawn with alone.
    fn fits(&self, scene: &Scene, variant: &Variant) -> bool {
        let [own, other] =
            [&self.scene, scene].map(|scene| (scene.image.size, scene.quality.target, scene.quality.msaa));
        let blends = |scene: &Scene| (scene.quality.order, scene.quality.proxy);
        own == other && blends(&self.scene) == blends(scene) && self.reads_the_same(scene, variant)
    }

    /// Whether another scene has the same program and images: it differs in camera, time, parameters, samples and targets
    /// alone, and its matter reaches as far.
    fn reads_the_same(&self, scene: &Scene, variant: &Variant) -> bool {
        let mut same = self.scene.clone();
        same.camera.clone_from(&scene.camera);
        same.image.clone_from(&scene.image);
        same.parameters.clone_from(&scene.parameters);
        for (part, other) in same.parts.values_mut().zip(scene.parts.values()) {
            part.parameters.clone_from(&other.parameters);
        }
        let (quality, other) = (&mut same.quality, &scene.quality);
        (quality.target, quality.msaa) = (other.target, other.msaa);
        (quality.order, quality.proxy) = (other.order, other.proxy);
        (quality.early_termination, quality.seed, quality.supersampling) =
            (other.early_termination, other.seed, other.supersampling);
        // These depend on the length of a step.
        if !["segment_image", "brick_image"].iter().any(|name| self.program.reads(name)) {
            quality.samples = other.samples;
        }
        let reach = |variant: &Variant| {
            let all = [&variant.parameters].into_iter().chain(variant.parts.values());
            all.map(|parameters| (parameters.outer_iso(), parameters.spread(1.0))).collect::<Vec<_>>()
        };
        same == *scene && self.runs(variant) && reach(variant) == reach(&self.variant)
    }

    /// Whether its program is that of a variant.
    fn runs(&self, variant: &Variant) -> bool {
        (variant.entries, &variant.slots) == (self.variant.entries, &self.variant.slots)
    }

    /// Some bands of a picture of a scene that fits, the mean of the sub-frames that are wanted: the frame pipeline.
    fn frame(
        &mut self,
        scene: &Scene,
        variant: &Variant,
        bands: &[Range<u32>],
        wanted: impl Fn(u32) -> bool,
    ) -> Result<Frame, RenderError> {
        let view = view::View::of(scene, self.subject, variant);
        let quality = &scene.quality;
        let planes = view.planes(quality.samples);
        // Rays to the rim of the sphere are slanted: at the nearest plane they may be a little beyond it.
        let slices =
            || pass::stack(&planes, view.extent.radius + planes.step, quality.proxy, quality.order, view.tint());
        let stack = (quality.pass == Pass::Slices).then(slices);
        let vertices = stack.as_ref().map(|stack| {
            let none = [0; 4]; // a buffer cannot be empty, a stack can
            let bytes = if stack.vertices.is_empty() { &none } else { bytemuck::cast_slice(&stack.vertices) };
            gpu::Buffer::new(self.gpu, "proxy slices", gpu::BufferUse::Vertices, bytes)
        });
        let vertices = vertices.transpose()?;
        let target = gpu::Target { color: &self.color, resolved: self.resolved.as_ref() };
        let [width, height] = scene.image.size;
        let mut sum = vec![[0.0; 4]; width as usize * height as usize];
        let mut drawn = pass::Drawn { fragments: Some(0), ..Default::default() };
        let space = shadow::LightSpace::of(scene, &view, &planes);
        let mut shadow_ms = None;
        let mut count = 0;
        for (_, sub_frame) in (0..).zip(SubFrame::all(scene)).filter(|(number, _)| wanted(*number)) {
            count += 1;
            self.bound.fill(scene, self.subject, variant, &view, (&planes, &space), &sub_frame)?;
            // The shadow of matter that moves while the shutter is open moves with it.
            let due = shadow_ms.is_none() || scene.camera.shutter > 0.0;
            if let Some(caster) = self.caster.as_ref().filter(|_| due) {
                let light = caster.cast(self.gpu, &view, &self.bound, space)?;
                self.bound.replace_shadow(&self.program, light.image(self.gpu)?);
                shadow_ms = Some(shadow_ms.unwrap_or(0.0) + light.gpu_ms);
            }
            drawn.append(&match (&stack, &vertices, &self.half_angle) {
                (Some(stack), Some(vertices), Some(light)) => {
                    let (own, slices) = ((&self.pipeline, &self.program, &self.bound), (vertices, stack));
                    light.draw(self.gpu, (scene, &view, &planes), own, slices, bands, target)?
                }
                (stack, vertices, _) => {
                    let set = self.pipeline.bind(&self.bound.resources())?;
                    match (stack, vertices) {
                        (Some(stack), Some(vertices)) => {
                            pass::draw(self.gpu, &self.pipeline, [&set; 2], vertices, stack, bands, target, None)?
                        }
                        _ => pass::march(self.gpu, &self.pipeline, &set, bands, target)?,
                    }
                }
            });
            let texels = self.resolved.as_ref().unwrap_or(&self.color).read()?;
            add(&mut sum, &texels);
        }
        let pixels = mean(&sum, count);
        check_finite(&pixels, width as usize)?;
        let targets = self.color.bytes() + self.resolved.as_ref().map_or(0, gpu::Image::bytes);
        let measurements = Measurements {
            modules: variant.key(),
            shipped: self.program.shipped,
            left_out: self.program.left_out(),
            octaves: variant.reads("turbulence").then(|| [scene.octaves_held(), scene.effect.octaves]),
            slices: planes.count,
            step: planes.step,
            fragments: drawn.fragments,
            compile_ms: std::mem::take(&mut self.compile_ms) + drawn.first_use_ms,
            gpu_ms: drawn.gpu_ms,
            shadow_ms,
            longest_ms: drawn.longest_ms,
            total_ms: 0.0,
            device_bytes: self.bound.bytes()
                + targets
                + self.half_angle.as_ref().map_or(0, half_angle::HalfAngle::bytes),
            sparse: self.bound.sparse(),
            quantization: self.bound.quantization(),
            held_beyond: view
                .objects
                .iter()
                .filter(|own| own.spread.held)
                .map(|own| own.spread.hold_radius)
                .reduce(f32::min),
        };
        Ok(Frame { size: scene.image.size, pixels, measurements })
    }
}

/// `constant_id` of the octaves in `glsl/octave_constants.glsl`.
pub(crate) const OCTAVES_ID: u32 = 0;
