//! Depth of a picture, for compositing with other content.
//!
//! Role: for each pixel, the depth along the axis of view at which the opacity along the ray reaches 1/2. Invariant:
//! rays take the samples of the picture, rays or slices, and no program of a picture depends on it.

use super::bind::{BoundInputs, PipelineShape};
use super::submission_budget::{SubmissionBudget, SubmissionControl};
use super::{bind, pass};
use crate::gpu::{Area, BindSet, Dimension, Format, Gpu, Image, ImageUse, Pipeline, Target};
use crate::render::camera::FrameContext;
use crate::render::error::RenderError;
use crate::render::variant::{Program, Purpose, Variant};
use crate::scene::{Pass, RayPath, Scene};
use crate::shader::{Library, Linker};
use std::sync::Arc;

/// Program and pipeline of a scene's depth.
#[derive(Clone)]
pub(crate) struct Depth {
    program: Program,
    pub(crate) pipeline: Arc<Pipeline>,
    budget: SubmissionBudget,
}

/// Checks cheaply that the pictures of a scene have a depth.
///
/// # Errors
/// [`RenderError::Depth`]; or the scene has more samples than rays may take.
pub fn check_depth(scene: &Scene, library: &Library) -> Result<(), RenderError> {
    Ok(Variant::of(&by_rays(scene)?, library).map(drop)?)
}

/// The scene with one straight ray for each pixel, unchecked.
///
/// # Errors
/// [`RenderError::Depth`].
pub(crate) fn by_rays(scene: &Scene) -> Result<Scene, RenderError> {
    if scene.effect.ray_path == RayPath::Refracted {
        return Err(RenderError::Depth("effect.ray_path = \"straight\""));
    }
    if scene.camera.slice_stack {
        return Err(RenderError::Depth("camera.slice_stack = false"));
    }
    if scene.projection() != scene.camera.projection {
        return Err(RenderError::Depth("an eye that is nearer: f32 holds no depths from there"));
    }
    let mut scene = scene.clone();
    (scene.quality.pass, scene.quality.msaa, scene.quality.supersampling) = (Pass::March, 1, 1);
    scene.light.shadows = false;
    Ok(scene)
}

/// A variant whose scene has one straight ray for each pixel.
///
/// # Errors
/// As [`check_depth`].
pub(crate) fn variant_by_rays(variant: &Variant, library: &Library) -> Result<Variant, RenderError> {
    let scene = Variant::of(&by_rays(&variant.scene)?, library)?.scene;
    Ok(Variant { scene, ..variant.clone() })
}

impl Depth {
    /// Links and compiles the program of a variant [by rays](variant_by_rays), unless `made` serves, which belongs to a scene
    /// with as many octaves.
    pub(crate) fn new(
        gpu: &Gpu,
        library: &Library,
        variant: &Variant,
        made: Option<Depth>,
    ) -> Result<Depth, RenderError> {
        let program = variant.for_purpose(Purpose::Depth, library)?.program(library, Linker::new)?;
        if let Some(made) = made.filter(|made| made.program == program) {
            return Ok(made);
        }
        let pipeline = bind::pipeline(gpu, &program, &variant.scene, PipelineShape::of(Format::R32Float))?;
        Ok(Depth { program, pipeline: Arc::new(pipeline), budget: SubmissionBudget::default() })
    }

    /// Binds the images and latest values of the picture, and the target of a compute shader.
    pub(crate) fn bind(
        &self,
        gpu: &Gpu,
        bound: &BoundInputs,
        target: Option<&Arc<Image>>,
    ) -> Result<BindSet, RenderError> {
        let blocks = bind::buffers(gpu, &bound.blocks_of(&self.program)?)?;
        Ok(bind::bind_rays(&self.program, &self.pipeline, bound.with(&blocks), target)?)
    }

    /// Draws the depth, object units, row by row from the top. `stop` receives the milliseconds on the device.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        frame: &FrameContext,
        bound: &BoundInputs,
        stop: &dyn Fn(f64) -> bool,
    ) -> Result<Vec<f32>, RenderError> {
        let [width, height] = frame.variant.scene.image.size;
        let plane = Dimension::Plane(width, height);
        let image = Arc::new(Image::new(gpu, "depth", plane, Format::R32Float, ImageUse::Target(1))?);
        let (set, all) = (self.bind(gpu, bound, Some(&image))?, [Area::whole([width, height])]);
        let mut control = SubmissionControl { budget: &mut self.budget, stop: &|ms, _| stop(ms) };
        pass::march(gpu, &self.pipeline, &set, (&all[..], frame.planes.count), Target::of(&image), &mut control)?;
        Ok(image.read()?.into_iter().map(|[depth, ..]| depth).collect())
    }
}
