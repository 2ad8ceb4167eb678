//! The early end of slices: pixels that no slice behind can change any more are marked, and drawn no more.
//!
//! Role: between two batches of slices, a pass over the picture so far marks the pixels that are as opaque as what ends a
//! ray. Invariant: where batches end depends on the number of slices alone, so the same scene gives the same picture.
//! Source: PH 3.1; Krueger and Westermann 2003, whom GG 39.6 names (the chapter is cut: a reconstruction).

use super::bind::BoundInputs;
use super::{bind, pass};
use crate::gpu::{self, Dimension, Format, Gpu, Image, ImageUse, Pipeline, Resource};
use crate::render::error::RenderError;
use crate::render::variant::{Program, Variant};
use crate::scene::{Order, Pass, Scene};
use crate::shader::{Library, Linker};
use std::sync::Arc;

/// The fragment stage that marks.
const ENTRY: &str = "mark.frag";
/// Name of the picture so far.
const TARGET: &str = "target_image";
/// Batches of the slices of a picture. Fewer: hidden matter is drawn longer. More: passes over the picture cost more than
/// that.
const BATCHES: u32 = 16;

/// What marks the pixels of a scene's pictures.
pub(crate) struct OpaqueMask {
    program: Program,
    pipeline: Pipeline,
    pub(crate) image: Image,
}

impl OpaqueMask {
    /// Whether the slices of a scene end early: what is opaque hides what is drawn behind it, in each pixel alike. Slices that
    /// are taken apart, to be looked at from the side, hide others in other pixels.
    pub(crate) fn serve(scene: &Scene) -> bool {
        let quality = &scene.quality;
        let (pass, order) = (Pass::Slices, Order::FrontToBack);
        let ends = quality.early_termination > 0.0 && !scene.camera.slice_stack && !scene.is_half_angle();
        quality.pass == pass && quality.order == order && quality.msaa == 1 && ends
    }

    pub(crate) fn new(
        gpu: &Gpu,
        library: &Library,
        scene: &Scene,
        variant: &Variant,
    ) -> Result<OpaqueMask, RenderError> {
        let program = variant.table(ENTRY, library)?.program(library, Linker::new)?;
        let pipeline =
            bind::pipeline(gpu, &program, scene, &[], Format::Depth16, 1, (gpu::Blend::Replace, gpu::Marks::Make))?;
        Ok(OpaqueMask { program, pipeline, image: image(gpu, scene)? })
    }

    /// Makes them as large as the pictures of a scene.
    pub(crate) fn resize(&mut self, gpu: &Gpu, scene: &Scene) -> Result<(), RenderError> {
        self.image = image(gpu, scene)?;
        Ok(())
    }

    /// What is done between the slices of a picture in that target.
    pub(crate) fn between<'a>(
        &'a self,
        gpu: &Gpu,
        bound: &BoundInputs,
        target: &Arc<Image>,
        slices: u32,
    ) -> Result<pass::BetweenSlices<'a>, RenderError> {
        let found = self.program.resources.iter().find(|resource| resource.name == TARGET);
        let mut resources = bound.with(&bind::buffers(gpu, &bound.blocks_of(&self.program)?)?);
        resources.extend(found.map(|resource| (resource.binding, Resource::Image(target.clone()))));
        let (pipeline, image, set) = (&self.pipeline, &self.image, self.pipeline.bind(&resources)?);
        Ok(pass::BetweenSlices::Marks { pipeline, set, image, every: slices.div_ceil(BATCHES).max(1) })
    }
}

fn image(gpu: &Gpu, scene: &Scene) -> Result<Image, gpu::GpuError> {
    let [width, height] = scene.image.size;
    Image::new(gpu, "marks", Dimension::Plane(width, height), Format::Depth16, ImageUse::Depth)
}
