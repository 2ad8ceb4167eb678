//! From a scene to a picture: the story of a frame, read top to bottom.
//!
//! Role: [`Subject::load`] turns the object of a scene into a distance field; [`render`] turns scene and subject into a
//! [`Frame`]. Invariant: every picture that a person sees comes through [`render`].

mod bind;
mod shadow;
mod view;

pub use shadow::{Transmittance, transmittance};

use crate::field::{self, ClosestPoints, DistanceField, FieldError, Progress};
use crate::glsl::{Library, Linker};
use crate::gpu::{self, Gpu, GpuError};
use crate::pass;
use crate::scene::{Axis, Object, Order, Pass, Scene, TargetFormat};
use crate::shape::{self, Shape, ShapeError};
use crate::variant::{Variant, VariantError};
use glam::Vec3;
use std::time::Instant;

/// The object of a scene, ready to be drawn in any effect.
///
/// Object space is centered on the object, and the longest side of its bounding box spans [-1, 1] there.
#[derive(Clone, Debug)]
pub struct Subject {
    /// What the scene calls it.
    pub input: String,
    /// The distance field; `None` for a formula, which needs none.
    pub field: Option<DistanceField>,
    /// The closest points of the surface, on the grid of the field; `None` where no scene reads them.
    pub closest: Option<ClosestPoints>,
    /// World position of the origin of object space.
    pub center: Vec3,
    /// Object units in one world unit.
    pub scale: f32,
    /// Half the size of the bounding box, object units.
    pub half_size: Vec3,
    /// Radius of the sphere around the object at the origin, object units.
    pub radius: f32,
    /// How the field was made.
    pub report: Option<field::Report>,
}

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
#[derive(Clone, Debug, Default)]
pub struct Measurements {
    /// Slots and modules of the program.
    pub modules: String,
    /// Whether the program was linked when the crate was built.
    pub shipped: bool,
    /// What the scene did not need.
    pub left_out: Vec<&'static str>,
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
    /// Largest error of a stored distance, object units; 0 for a formula.
    pub quantization: f32,
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
    /// A program reads what the subject was loaded without.
    #[error("the subject has no {0}, which the program reads; load it with the scene that is rendered")]
    Missing(&'static str),
    /// The program has a block member that the renderer does not know.
    #[error("`{0}` is in no block of interface.glsl; declare it with `// @knob` in a module")]
    Unfilled(String),
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

/// The field covers at least this much around the object, object units; more in steps of it. A finer step would compute
/// the field anew for every length of hair; a coarser one would waste voxels.
const MARGIN_STEP: f32 = 0.25;

impl Subject {
    /// Loads the object of a scene and computes or finds its distance field.
    ///
    /// # Errors
    /// The input cannot be read, or has no surface.
    pub fn load(scene: &Scene, library: &Library, progress: Progress<'_>) -> Result<Subject, RenderError> {
        let variant = Variant::of(scene, library)?;
        let outer = variant.knobs.outer_iso().unwrap_or(scene.object.outer_iso);
        Subject::load_with_margin(&scene.object, outer, variant.reads_closest(), progress)
    }

    /// Loads an object with a field that reaches `margin` (object units) beyond it, so that several scenes may share it;
    /// with its closest points where one of them reads them.
    ///
    /// # Errors
    /// As [`Subject::load`].
    pub fn load_with_margin(
        object: &Object,
        margin: f32,
        closest: bool,
        progress: Progress<'_>,
    ) -> Result<Subject, RenderError> {
        if object.is_formula() {
            return Ok(formula(&object.input));
        }
        let shape = open(object)?;
        let request = request(&shape, object, margin);
        let (mut field, mut points, report) = if closest {
            let (field, points, report) = field::load_or_compute_closest(&shape, &request, progress)?;
            (field, Some(points), report)
        } else {
            let (field, report) = field::load_or_compute(&shape, &request, progress)?;
            (field, None, report)
        };
        if object.up != Axis::Y {
            field = field.turned(object.up.turn());
            points = points.map(|points| points.turned(object.up.turn()));
        }
        let (low, high) = inside_bounds(&field);
        let center = 0.5 * (low + high);
        let scale = 2.0 / (high - low).max_element();
        let radius = inside_points(&field).map(|p| p.distance(center)).fold(0.0, f32::max) * scale;
        let half_size = 0.5 * scale * (high - low);
        let input = object.input.clone();
        let (field, report) = (Some(field), Some(report));
        Ok(Subject { input, field, closest: points, center, scale, half_size, radius, report })
    }
}

/// The shape of an object.
///
/// # Errors
/// The input cannot be read.
pub fn open(object: &Object) -> Result<Shape, ShapeError> {
    let mut shape = shape::open(&object.input)?;
    if let (Shape::Volume(volume), true) = (&mut shape, object.distance) {
        volume.content = shape::Content::SignedDistance;
    }
    Ok(shape)
}

/// The request for a shape's field, in world units.
pub fn request(shape: &Shape, object: &Object, margin: f32) -> field::Request {
    let bounds = shape.bounds();
    let half = 0.5 * (bounds.max - bounds.min).max_element();
    let iso = object.iso.unwrap_or(match shape {
        Shape::Volume(volume) if volume.content == shape::Content::Scalar => {
            let (low, high) = volume.range();
            0.5 * (low + high)
        }
        _ => 0.0,
    });
    let margin = (margin.max(0.0) / MARGIN_STEP + 1e-3).ceil().max(1.0) * MARGIN_STEP * half;
    field::Request { resolution: object.resolution, margin, band: margin, iso }
}

/// A built-in object that is a formula in `glsl/object`.
fn formula(name: &str) -> Subject {
    let (half_size, radius) = match name {
        "cube" => (Vec3::ONE, 3f32.sqrt()),
        "torus" => (Vec3::new(1.0, 0.3, 1.0), 1.0),
        _ => (Vec3::ONE, 1.0),
    };
    let (center, scale) = (Vec3::ZERO, 1.0);
    Subject { input: name.into(), field: None, closest: None, center, scale, half_size, radius, report: None }
}

/// World positions of the samples inside, or of the nearest to the surface where none is.
fn inside_points(field: &DistanceField) -> impl Iterator<Item = Vec3> + '_ {
    let threshold = field.range().0.max(0.0);
    let [nx, ny, _] = field.grid.size;
    let inside = field.values.iter().enumerate().filter(move |(_, distance)| **distance <= threshold);
    inside.map(move |(index, _)| {
        let index = index as u32;
        field.grid.position(index % nx, index / nx % ny, index / (nx * ny))
    })
}

/// The box around the inside, half a voxel wider on each side.
fn inside_bounds(field: &DistanceField) -> (Vec3, Vec3) {
    let (low, high) =
        inside_points(field).fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    (low - 0.5 * field.grid.spacing, high + 0.5 * field.grid.spacing)
}

/// Renders a scene.
///
/// The pixels are premultiplied linear RGBA without the background; the error of the quadrature is of the order of
/// `measurements.step` at hard edges (an RMS of at most twice the step over the six effects, as measured) and of its
/// square in soft matter.
///
/// # Errors
/// The scene has no valid program, or the device refuses.
pub fn render(gpu: &Gpu, library: &Library, scene: &Scene, subject: &Subject) -> Result<Frame, RenderError> {
    let start = Instant::now();
    let variant = Variant::of(scene, library)?;
    let program = variant.program(library, Linker::new)?;
    let mut compile_ms = start.elapsed().as_secs_f64() * 1e3;
    let view = view::View::of(scene, subject, &variant);
    let quality = &scene.quality;
    let planes = pass::Planes::new(view.extent, quality.samples);
    let space = shadow::LightSpace::of(scene, &view, &planes);
    let mut bound = bind::Bound::new(gpu, scene, subject, &variant, &program, &view, &planes, &space)?;
    let mut shadow_ms = None;
    if program.reads("shadow_image") {
        let light = shadow::cast(gpu, library, scene, &variant, &view, &bound, space)?;
        bound.add(&program, "shadow_image", light.image(gpu)?);
        shadow_ms = Some(light.gpu_ms);
    }
    let format = match quality.target {
        TargetFormat::Unorm8 => gpu::Format::Rgba8Unorm,
        TargetFormat::Float16 => gpu::Format::Rgba16Float,
        TargetFormat::Float32 => gpu::Format::Rgba32Float,
    };
    let blend = match (quality.pass, quality.order) {
        (Pass::March, _) => gpu::Blend::Replace,
        (Pass::Slices, Order::FrontToBack) => gpu::Blend::Under,
        (Pass::Slices, Order::BackToFront) => gpu::Blend::Over,
    };
    let slices = || pass::stack(&planes, view.extent.radius, quality.proxy, quality.order, view.tint());
    let stack = (quality.pass == Pass::Slices).then(slices);
    let bindings: Vec<gpu::Binding> = program.resources.iter().map(bind::binding).collect();
    let pipeline_start = Instant::now();
    let pipeline = gpu::Pipeline::new(
        gpu,
        &gpu::PipelineDescription {
            vertex: &program.vertex,
            fragment: &program.fragment,
            bindings: &bindings,
            attributes: stack.as_ref().map_or(&[], |stack| stack.attributes),
            format,
            samples: quality.msaa,
            blend,
        },
    )?;
    compile_ms += pipeline_start.elapsed().as_secs_f64() * 1e3;
    let [width, height] = scene.image.size;
    let plane = gpu::Dimension::Plane(width, height);
    let color = gpu::Image::new(gpu, "target", plane, format, gpu::ImageUse::Target(quality.msaa))?;
    let resolved = match quality.msaa {
        1 => None,
        _ => Some(gpu::Image::new(gpu, "resolved target", plane, format, gpu::ImageUse::Target(1))?),
    };
    let set = pipeline.bind(&bound.resources())?;
    let target = gpu::Target { color: &color, resolved: resolved.as_ref() };
    let drawn = match &stack {
        None => pass::march(gpu, &pipeline, &set, height, target)?,
        Some(stack) => {
            let none = [0; 4]; // a buffer cannot be empty, a stack can
            let bytes = if stack.vertices.is_empty() { &none } else { bytemuck::cast_slice(&stack.vertices) };
            let vertices = gpu::Buffer::new(gpu, "proxy slices", gpu::BufferUse::Vertices, bytes)?;
            pass::draw(gpu, &pipeline, &set, &vertices, stack, target)?
        }
    };
    let pixels = decode(&resolved.as_ref().unwrap_or(&color).read()?, quality.target);
    check_finite(&pixels, width as usize)?;
    let device_bytes = bound.bytes() + color.bytes() + resolved.as_ref().map_or(0, gpu::Image::bytes);
    let measurements = Measurements {
        modules: variant.key(),
        shipped: program.shipped,
        left_out: program.left_out(),
        slices: planes.count,
        step: planes.step,
        fragments: drawn.fragments,
        compile_ms: compile_ms + drawn.first_use_ms,
        gpu_ms: drawn.gpu_ms,
        shadow_ms,
        longest_ms: drawn.longest_ms,
        total_ms: start.elapsed().as_secs_f64() * 1e3,
        device_bytes,
        quantization: bound.quantization,
    };
    Ok(Frame { size: scene.image.size, pixels, measurements })
}

/// The texels of a target of 32-bit floats.
fn floats(bytes: &[u8]) -> Vec<[f32; 4]> {
    let texels = bytes.as_chunks::<16>().0.iter();
    texels.map(|texel| std::array::from_fn(|c| f32::from_ne_bytes([0, 1, 2, 3].map(|b| texel[4 * c + b])))).collect()
}

/// The texels of a target as floats.
fn decode(bytes: &[u8], format: TargetFormat) -> Vec<[f32; 4]> {
    match format {
        TargetFormat::Float32 => floats(bytes),
        TargetFormat::Float16 => bytes
            .chunks_exact(8)
            .map(|texel| std::array::from_fn(|c| half::f16::from_ne_bytes([texel[2 * c], texel[2 * c + 1]]).to_f32()))
            .collect(),
        TargetFormat::Unorm8 => {
            bytes.chunks_exact(4).map(|texel| std::array::from_fn(|c| f32::from(texel[c]) / 255.0)).collect()
        }
    }
}

fn check_finite(pixels: &[[f32; 4]], width: usize) -> Result<(), RenderError> {
    let bad = |pixel: &&[f32; 4]| pixel.iter().any(|value| !value.is_finite());
    match pixels.iter().position(|pixel| bad(&pixel)) {
        None => Ok(()),
        Some(first) => {
            Err(RenderError::NotFinite { count: pixels.iter().filter(bad).count(), x: first % width, y: first / width })
        }
    }
}
