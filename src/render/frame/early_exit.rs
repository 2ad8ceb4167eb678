//! Early exit of slices: opaque pixels are masked and skipped by the slices behind.
//!
//! Role: between two batches of slices, a pass over the target masks the pixels whose opacity ends a ray. Invariant:
//! batches depend on the number of slices alone, so a scene always gives one picture. Source: PH 3.1; Krueger and
//! Westermann 2003, cited by GG 39.6 (reconstructed, since the chapter is cut).

use super::bind::{BoundInputs, PipelineShape};
use super::{bind, pass};
use crate::gpu::{self, Dimension, Format, Gpu, Image, ImageUse, Pipeline, Resource};
use crate::render::error::RenderError;
use crate::render::variant::{PassImage, Program, Variant};
use crate::scene::{Order, Pass, Scene};
use crate::shader::{Library, Linker};
use std::sync::Arc;

/// Fragment stage of the mask.
const ENTRY: &str = "mark.frag";
/// Batches of the slices of a picture. Lower: hidden matter is drawn longer. Higher: the masking passes cost more than
/// they save.
const BATCHES: u32 = 16;

/// Mask of the opaque pixels of a picture.
pub(crate) struct OpaqueMask {
    program: Program,
    pipeline: Pipeline,
    pub(crate) image: Image,
}

impl OpaqueMask {
    /// Whether the slices of a scene may exit early. Requires slices that hide each other in each pixel, unlike a stack
    /// that is viewed from the side.
    pub(crate) fn serve(scene: &Scene) -> bool {
        let quality = &scene.quality;
        let (pass, order) = (Pass::Slices, Order::FrontToBack);
        let ends = quality.early_termination > 0.0 && !scene.camera.slice_stack && !scene.is_half_angle();
        quality.pass == pass && quality.order == order && quality.msaa == 1 && ends
    }

    pub(crate) fn new(gpu: &Gpu, library: &Library, variant: &Variant) -> Result<OpaqueMask, RenderError> {
        let scene = &variant.scene;
        let shape = PipelineShape { marks: gpu::Marks::Write, ..PipelineShape::of(Format::Depth16) };
        let program = variant.table(ENTRY, library)?.program(library, Linker::new)?;
        let pipeline = bind::pipeline(gpu, &program, scene, shape)?;
        Ok(OpaqueMask { program, pipeline, image: image(gpu, scene)? })
    }

    /// Resizes the mask to the pictures of a scene.
    pub(crate) fn resize(&mut self, gpu: &Gpu, scene: &Scene) -> Result<(), RenderError> {
        self.image = image(gpu, scene)?;
        Ok(())
    }

    /// The masking pass between the slices of a picture.
    pub(crate) fn between<'a>(
        &'a self,
        gpu: &Gpu,
        bound: &BoundInputs,
        target: &Arc<Image>,
        slices: u32,
    ) -> Result<pass::BetweenSlices<'a>, RenderError> {
        let mut resources = bound.with(&bind::buffers(gpu, &bound.blocks_of(&self.program)?)?);
        resources
            .extend(self.program.image(PassImage::Target).map(|binding| (binding, Resource::Image(target.clone()))));
        let (pipeline, image, set) = (&self.pipeline, &self.image, self.pipeline.bind(&resources)?);
        Ok(pass::BetweenSlices::Marks { pipeline, set, image, every: slices.div_ceil(BATCHES).max(1) })
    }
}

fn image(gpu: &Gpu, scene: &Scene) -> Result<Image, gpu::GpuError> {
    let [width, height] = scene.image.size;
    Image::new(gpu, "marks", Dimension::Plane(width, height), Format::Depth16, ImageUse::Depth)
}
