//! Half-angle slicing: the light goes through the slices of the picture with the camera, slice by slice.
//!
//! Role: the slices face half way between the camera and the light, or the camera's other side where the light is behind the
//! object, so that both cross them in one order. Before a slice is blended into the picture, the light behind it is drawn
//! from the light before it; matter is lit from both buffers. Invariant: light and eye are fixed in eye space, so the
//! slices stay still while the trackball turns (MJ 3.3).
//! Source: GG 39.5.1; Kniss, Premoze, Hansen, Shirley and McPherson 2003. The chapter is cut: a reconstruction.

use super::bind::BoundInputs;
use super::submission_budget::SubmissionControl;
use super::{bind, pass};
use crate::gpu::{self, Blend, Buffer, BufferUse, Dimension, Format, Gpu, Image, ImageUse, Pipeline};
use crate::render::camera::{FLATTEST, FrameContext, View, axis, slant};
use crate::render::cells::Tiles;
use crate::render::error::RenderError;
use crate::render::inputs::{BEFORE, BEHIND};
use crate::render::variant::{Program, Variant};
use crate::scene::Scene;
use crate::shader::{Library, Linker};
use glam::Vec3;
use std::sync::Arc;

/// The light's buffer: scattered light in RGB, direct light in A. Fewer bits: thin matter does not darken it at all.
const BUFFER: Format = Format::Rgba32Float;

/// How the slices meet the target: the light comes first, and the camera may look from the other side.
pub(crate) fn blend(scene: &Scene) -> Blend {
    if axis(scene).z >= 0.0 { Blend::Under } else { Blend::Over }
}

/// Refuses an eye or a light that does not look through the slices in their order.
fn check(scene: &Scene, view: &View) -> Result<(), RenderError> {
    if slant(scene, view) >= 1.0 / FLATTEST {
        return Err(RenderError::HalfAngle("the view is too wide", "lower camera.field_of_view"));
    }
    let corner = |corner: u32| {
        let at = |axis: usize| [view.box_min, view.box_max][(corner >> axis & 1) as usize][axis];
        view.object_matrix.transform_point3(Vec3::new(at(0), at(1), at(2)))
    };
    let from_light = (0..8).map(|index| corner(index) - view.light_eye);
    match from_light.map(|ray| -ray.dot(view.axis) / ray.length()).fold(1.0, f32::min) > FLATTEST {
        true => Ok(()),
        false => {
            Err(RenderError::HalfAngle("the light is inside of the scene or beside it", "move light.position away"))
        }
    }
}

/// The slices of a picture, and what they are drawn with.
#[derive(Clone, Copy)]
pub(crate) struct Slices<'a> {
    pub(crate) pipeline: &'a Pipeline,
    pub(crate) program: &'a Program,
    pub(crate) bound: &'a BoundInputs,
    pub(crate) vertices: &'a Buffer,
    pub(crate) stack: &'a pass::Stack,
}

/// What hands the light from slice to slice, made once for the pictures of a scene.
#[derive(Clone)]
pub(crate) struct HalfAngle {
    program: Program,
    pipeline: Arc<Pipeline>,
    buffers: [Arc<Image>; 2],
}

impl HalfAngle {
    /// `made` may serve: one of a scene with as many octaves.
    pub(crate) fn new(
        gpu: &Gpu,
        library: &Library,
        scene: &Scene,
        variant: &Variant,
        made: Option<HalfAngle>,
    ) -> Result<HalfAngle, RenderError> {
        let program = variant.light(scene, library)?.program(library, Linker::new)?;
        let pipeline = match made.filter(|made| made.program == program) {
            Some(made) => made.pipeline,
            None => {
                let blend = (Blend::Replace, gpu::Marks::None);
                Arc::new(bind::pipeline(gpu, &program, scene, &[3], BUFFER, 1, blend)?)
            }
        };
        let buffers = buffers(gpu, scene.light.shadow_resolution)?;
        Ok(HalfAngle { program, pipeline, buffers })
    }

    /// Makes its buffers as large as those of a scene.
    pub(crate) fn resize(&mut self, gpu: &Gpu, scene: &Scene) -> Result<(), RenderError> {
        let side = scene.light.shadow_resolution;
        if self.buffers[0].size()[0] != side {
            self.buffers = buffers(gpu, side)?;
        }
        Ok(())
    }

    /// Draws a picture and its light, as [`pass::draw`] draws a picture.
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        shot: &FrameContext<'_>,
        slices: &Slices<'_>,
        areas: &[gpu::Area],
        target: gpu::Target<'_>,
        cut: &mut SubmissionControl<'_>,
    ) -> Result<pass::PassTiming, RenderError> {
        let Slices { pipeline, program, bound, vertices, stack } = *slices;
        let planes = &shot.planes;
        check(shot.scene, &shot.view)?;
        let corners = (0..planes.count).flat_map(|plane| {
            let depth = planes.depth(plane);
            [[-1.0, -1.0, depth], [3.0, -1.0, depth], [-1.0, 3.0, depth]]
        });
        let corners: Vec<[f32; 3]> = corners.collect();
        let corners = Buffer::new(gpu, "light slices", BufferUse::Vertices, bytemuck::cast_slice(&corners))?;
        let blocks = bind::buffers(gpu, &bound.blocks_of(&self.program)?)?;
        // The buffers take turns: that before a slice, and that behind it.
        let buffers = |program: &Program, before: usize| {
            let found = program.resources.iter().filter_map(|resource| match resource.name.as_str() {
                BEFORE => Some((resource.binding, gpu::Resource::Image(self.buffers[before].clone()))),
                BEHIND => Some((resource.binding, gpu::Resource::Image(self.buffers[1 - before].clone()))),
                _ => None,
            });
            found.collect::<Vec<_>>()
        };
        let of_light = |before| self.pipeline.bind(&[bound.with(&blocks), buffers(&self.program, before)].concat());
        let of_eye = |before| pipeline.bind(&[bound.resources(), buffers(program, before)].concat());
        let light = pass::Light {
            pipeline: &self.pipeline,
            sets: [of_light(0)?, of_light(1)?],
            vertices: &corners,
            buffers: &self.buffers,
        };
        let sets = [of_eye(0)?, of_eye(1)?];
        let between = pass::BetweenSlices::Light(&light);
        let places = (areas, &Tiles::everywhere(areas));
        pass::draw(gpu, pipeline, [&sets[0], &sets[1]], vertices, stack, places, target, &between, cut)
    }

    /// Bytes of the buffers on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.buffers.iter().map(|buffer| buffer.bytes()).sum()
    }
}

/// The buffers of the light, which take turns.
fn buffers(gpu: &Gpu, side: u32) -> Result<[Arc<Image>; 2], RenderError> {
    let plane = Dimension::Plane(side, side);
    let buffer = || Image::new(gpu, "light", plane, BUFFER, ImageUse::SampledTarget).map(Arc::new);
    Ok([buffer()?, buffer()?])
}
