//! Shadow volume: transmittance of the light at each place of the scene.
//!
//! Role: [`transmittance`] evaluates the matter of a scene along rays from the light, on the device and with the
//! modules of the picture, and multiplies along the rays. Invariant: the rays are straight lines from the light, so
//! shadows are not blurred by resampling; see `light_space.glsl` for the space.
//!
//! n by n rays of n segments need as many samples as a picture of n x n pixels; a march from each of the n^3 texels to
//! the light would need n / 2 times as many. Propagation through the layers of an axis-aligned grid needs no more
//! samples either, but blurs in each layer, and does not work for a light inside the scene.

use super::bind::{BoundInputs, PipelineShape};
use super::filters::suited;
use super::submission_budget::{SubmissionBudget, SubmissionControl};
use super::{bind, pass};
use crate::gpu::{self, Dimension, Format, Gpu, Image, ImageUse, Pipeline};
use crate::render::camera::{FrameContext, LightSpace, SubFrame};
use crate::render::error::RenderError;
use crate::render::inputs::Inputs;
use crate::render::subject::Subject;
use crate::render::variant::{Checkable, PassImage, Program, Purpose, Variant};
use crate::shader::{Library, Linker};
use glam::{Mat4, Vec3};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Target format: a texel holds the transmittances of four segments.
const SEGMENTS: Format = Format::Rgba32Float;
const SEGMENTS_OF_A_TEXEL: u32 = 4;

/// Transmittance of the light at each place of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Transmittance {
    space: LightSpace,
    object_matrix: Mat4,
    /// Transmittances in [0, 1], one layer of rays for each distance; distances are one more than rays along a side.
    values: Vec<f32>,
    /// Time on the device, milliseconds.
    pub gpu_ms: f64,
}

impl Transmittance {
    /// Interpolated transmittance at a place in object space, in [0, 1].
    pub fn at(&self, x: Vec3) -> f32 {
        let space = &self.space;
        let p = space.matrix.transform_point3(self.object_matrix.transform_point3(x));
        let angle = p.truncate().length().atan2(p.z);
        let across = p.truncate().normalize_or_zero() * LightSpace::radius(angle) / space.rim;
        let along = (p.length() - space.near) / (space.far - space.near);
        let side = space.side as usize;
        let at = (0.5 + 0.5 * across).extend(along) * side as f32 - Vec3::new(0.5, 0.5, 0.0);
        let at = at.clamp(Vec3::ZERO, Vec3::new((side - 1) as f32, (side - 1) as f32, side as f32));
        let low = at.floor();
        let [i, j, k] = low.to_array().map(|c| c as usize);
        let t = at - low;
        let value =
            |i: usize, j: usize, k: usize| self.values[(k.min(side) * side + j.min(side - 1)) * side + i.min(side - 1)];
        let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
        let row = |j, k| mix(value(i, j, k), value(i + 1, j, k), t.x);
        let layer = |k| mix(row(j, k), row(j + 1, k), t.y);
        mix(layer(k), layer(k + 1), t.z)
    }
}

/// Renders the shadow volume of a scene, as [`render`](crate::render::render) does with `light.shadows`.
///
/// A step of a light ray is two of the picture's, and at most a texel. The error is of first order in that step at hard
/// edges and of second order in soft matter; between the texels it is of second order in their size.
///
/// # Errors
/// The scene has no valid program, or a Vulkan call fails.
pub fn transmittance(
    gpu: &Gpu,
    library: &Library,
    scene: &impl Checkable,
    subject: &Subject,
) -> Result<Transmittance, RenderError> {
    let frame = FrameContext::of(suited(gpu.info(), scene.checked(library)?).into_owned(), subject);
    let program = frame.variant.program(library, Linker::new)?;
    let inputs = Inputs::new(library, &frame, &program, &|_| ())?;
    let mut bound = BoundInputs::new(gpu, library, &program, &inputs, false, false, &|_| ())?;
    for sub_frame in SubFrame::all(&frame.variant.scene).take(1) {
        bound.fill(gpu, &program, &frame, &sub_frame, &|| false)?;
    }
    let mut caster = ShadowCaster::new(gpu, library, &frame.variant, None)?;
    let (values, gpu_ms) = caster.cast(gpu, &frame, &bound, |light| light, &|_| false)?;
    Ok(Transmittance { space: frame.space, object_matrix: frame.view.object_matrix, values, gpu_ms })
}

/// Program of the shadow volumes of a scene, and the latest volume.
#[derive(Clone)]
pub(crate) struct ShadowCaster {
    program: Program,
    /// Block members that the program reads.
    read: BTreeSet<(u32, u32)>,
    pipeline: Arc<Pipeline>,
    budget: SubmissionBudget,
    last: Option<ShadowVolume>,
}

/// A shadow volume with its inputs.
#[derive(Clone)]
pub(crate) struct ShadowVolume {
    space: LightSpace,
    /// Values and images read by the program, which determine the volume.
    blocks: Vec<u8>,
    images: Vec<Arc<Image>>,
    pub(crate) image: Arc<Image>,
    /// Time on the device, milliseconds.
    pub(crate) gpu_ms: f64,
    /// Whether the volume is that of an earlier picture.
    pub(crate) is_kept: bool,
}

impl ShadowCaster {
    /// Links and compiles the program, unless `made` serves, which belongs to a scene with as many octaves.
    pub(crate) fn new(
        gpu: &Gpu,
        library: &Library,
        variant: &Variant,
        made: Option<ShadowCaster>,
    ) -> Result<ShadowCaster, RenderError> {
        let program = variant.for_purpose(Purpose::Shadow, library)?.program(library, Linker::new)?;
        if let Some(made) = made.filter(|made| made.program == program) {
            return Ok(made);
        }
        let pipeline = bind::pipeline(gpu, &program, &variant.scene, PipelineShape::of(SEGMENTS))?;
        let (read, pipeline) = (program.members_read(), Arc::new(pipeline));
        Ok(ShadowCaster { program, read, pipeline, budget: SubmissionBudget::default(), last: None })
    }

    /// Discards the latest volume.
    pub(crate) fn forget(&mut self) {
        self.last = None;
    }

    /// Shadow volume of a picture: the latest one if its inputs are unchanged.
    pub(crate) fn volume(
        &mut self,
        gpu: &Gpu,
        frame: &FrameContext,
        bound: &BoundInputs,
        stop: &dyn Fn(f64) -> bool,
    ) -> Result<ShadowVolume, RenderError> {
        let blocks = self.program.parts_read(&self.read, &bound.blocks_of(&self.program)?);
        let images = bound.images_of(&self.program);
        let serves = |last: &&ShadowVolume| {
            let same_images =
                images.len() == last.images.len() && images.iter().zip(&last.images).all(|(a, b)| Arc::ptr_eq(a, b));
            last.space == frame.space && last.blocks == blocks && same_images
        };
        if let Some(last) = self.last.as_ref().filter(serves) {
            return Ok(ShadowVolume { is_kept: true, ..last.clone() });
        }
        self.last = None;
        let code = |light: f32| (light * 65535.0 + 0.5) as u16;
        let (texels, gpu_ms) = self.cast(gpu, frame, bound, code, stop)?;
        let [x, y, z] = frame.space.texels();
        let size = Dimension::Volume(x, y, z);
        let texels = bytemuck::cast_slice(&texels);
        let image = Arc::new(Image::sampled(gpu, PassImage::Shadow.label(), size, Format::R16Unorm, texels)?);
        let cast = ShadowVolume { space: frame.space, blocks, images, image, gpu_ms, is_kept: false };
        self.last = Some(cast.clone());
        Ok(cast)
    }

    /// Draws the segments with the images of the picture's program, and multiplies along the rays. `stop` receives the
    /// milliseconds on the device. Returns the texels, each the `code` of a transmittance in [0, 1], and the
    /// milliseconds on the device.
    fn cast<T: Clone>(
        &mut self,
        gpu: &Gpu,
        frame: &FrameContext,
        bound: &BoundInputs,
        code: impl Fn(f32) -> T,
        stop: &dyn Fn(f64) -> bool,
    ) -> Result<(Vec<T>, f64), RenderError> {
        let space = frame.space;
        let [width, height] = space.target();
        let plane = Dimension::Plane(width, height);
        let color = Arc::new(Image::new(gpu, "shadow segments", plane, SEGMENTS, ImageUse::Target(1))?);
        let blocks = bind::buffers(gpu, &bound.blocks_of(&self.program)?)?;
        let set = bind::bind_rays(&self.program, &self.pipeline, bound.with(&blocks), Some(&color))?;
        let target = gpu::Target::of(&color);
        let all = [gpu::Area::whole([width, height])];
        let mut control = SubmissionControl { budget: &mut self.budget, stop: &|ms, _| stop(ms) };
        let drawn = pass::march(gpu, &self.pipeline, &set, (&all[..], SEGMENTS_OF_A_TEXEL), target, &mut control)?;
        Ok((color.read_with(|segments| space.products(segments, code))?, drawn.gpu_ms))
    }
}
