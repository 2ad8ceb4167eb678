//! Half-angle slicing: light and camera traverse the slices together.
//!
//! Role: the slices face halfway between the camera and the light, or halfway to the opposite of the camera for a light
//! behind the object, so that both cross them in one order. Before a slice is blended into the picture, the light
//! behind it is drawn from the light before it; matter is lit from both buffers. Invariant: light and eye are fixed in
//! eye space, so the trackball does not move the slices (MJ 3.3). Source: GG 39.5.1; Kniss, Premoze, Hansen, Shirley
//! and McPherson 2003 (reconstructed, since the chapter is cut).

use super::bind::{BoundInputs, PipelineShape};
use super::submission_budget::SubmissionControl;
use super::{bind, pass};
use crate::gpu::{self, Blend, Buffer, BufferUse, Dimension, Format, Gpu, Image, ImageUse, Pipeline};
use crate::render::camera::{FLATTEST, FrameContext, View, axis, slant};
use crate::render::cells::Tiles;
use crate::render::error::RenderError;
use crate::render::variant::{PassImage, Program, Purpose, Variant};
use crate::scene::Scene;
use crate::shader::{Library, Linker};
use glam::Vec3;
use std::sync::Arc;

/// Light buffer: scattered light in RGB, direct light in A. Fewer bits: thin matter does not darken it at all.
const BUFFER: Format = Format::Rgba32Float;

/// Blending of the slices, which are ordered from the light and may be seen from the other side.
pub(crate) fn blend(scene: &Scene) -> Blend {
    if axis(scene).z >= 0.0 { Blend::Under } else { Blend::Over }
}

/// Returns an error if a ray of the eye or of the light crosses the slices too flat or in reverse.
fn check(scene: &Scene, view: &View) -> Result<(), RenderError> {
    if slant(scene, view) >= 1.0 / FLATTEST {
        return Err(RenderError::HalfAngle("the view is too wide", "lower camera.field_of_view"));
    }
    let corner = |corner: u32| {
        let at = |axis: usize| [view.box_min, view.box_max][(corner >> axis & 1) as usize][axis];
        view.object_matrix.transform_point3(Vec3::new(at(0), at(1), at(2)))
    };
    let from_light = (0..8).map(|index| corner(index) - view.light_eye);
    if from_light.map(|ray| -ray.dot(view.axis) / ray.length()).fold(1.0, f32::min) > FLATTEST {
        Ok(())
    } else {
        Err(RenderError::HalfAngle("the light is inside of the scene or beside it", "move light.position away"))
    }
}

/// Slices of a picture with their pipeline and inputs.
#[derive(Clone, Copy)]
pub(crate) struct Slices<'a> {
    pub(crate) pipeline: &'a Pipeline,
    pub(crate) program: &'a Program,
    pub(crate) bound: &'a BoundInputs,
    pub(crate) vertices: &'a Buffer,
    pub(crate) stack: &'a pass::Stack,
}

/// Light buffers of a scene and the program that advances them.
#[derive(Clone)]
pub(crate) struct HalfAngle {
    program: Program,
    pipeline: Arc<Pipeline>,
    buffers: [Arc<Image>; 2],
}

impl HalfAngle {
    /// Links and compiles the program, unless `made` serves, which belongs to a scene with as many octaves.
    pub(crate) fn new(
        gpu: &Gpu,
        library: &Library,
        variant: &Variant,
        made: Option<HalfAngle>,
    ) -> Result<HalfAngle, RenderError> {
        let scene = &variant.scene;
        let program = variant.for_purpose(Purpose::Light, library)?.program(library, Linker::new)?;
        let pipeline = match made.filter(|made| made.program == program) {
            Some(made) => made.pipeline,
            None => {
                let shape = PipelineShape { attributes: &[3], ..PipelineShape::of(BUFFER) };
                Arc::new(bind::pipeline(gpu, &program, scene, shape)?)
            }
        };
        let buffers = buffers(gpu, scene.light.shadow_resolution)?;
        Ok(HalfAngle { program, pipeline, buffers })
    }

    /// Resizes the buffers to those of a scene.
    pub(crate) fn resize(&mut self, gpu: &Gpu, scene: &Scene) -> Result<(), RenderError> {
        let side = scene.light.shadow_resolution;
        if self.buffers[0].size()[0] != side {
            self.buffers = buffers(gpu, side)?;
        }
        Ok(())
    }

    /// Draws a picture and its light, with the parameters of [`pass::draw`].
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        frame: &FrameContext,
        slices: &Slices<'_>,
        areas: &[gpu::Area],
        target: gpu::Target<'_>,
        control: &mut SubmissionControl<'_>,
    ) -> Result<pass::PassTiming, RenderError> {
        let Slices { pipeline, program, bound, vertices, stack } = *slices;
        let planes = &frame.planes;
        check(&frame.variant.scene, &frame.view)?;
        let corners = (0..planes.count).flat_map(|plane| {
            let depth = planes.depth(plane);
            [[-1.0, -1.0, depth], [3.0, -1.0, depth], [-1.0, 3.0, depth]]
        });
        let corners: Vec<[f32; 3]> = corners.collect();
        let corners = Buffer::new(gpu, "light slices", BufferUse::Vertices, bytemuck::cast_slice(&corners))?;
        let blocks = bind::buffers(gpu, &bound.blocks_of(&self.program)?)?;
        // The buffers alternate: one before a slice, one behind it.
        let buffers = |program: &Program, before: usize| {
            let both = [(PassImage::LightBefore, before), (PassImage::LightBehind, 1 - before)];
            let image = |index: usize| gpu::Resource::Image(self.buffers[index].clone());
            both.into_iter()
                .filter_map(|(input, index)| Some((program.image(input)?, image(index))))
                .collect::<Vec<_>>()
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
        pass::draw(gpu, pipeline, [&sets[0], &sets[1]], vertices, stack, places, target, &between, control)
    }

    /// Bytes of the buffers on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.buffers.iter().map(|buffer| buffer.bytes()).sum()
    }
}

/// Allocates the alternating light buffers.
fn buffers(gpu: &Gpu, side: u32) -> Result<[Arc<Image>; 2], RenderError> {
    let plane = Dimension::Plane(side, side);
    let buffer =
        || Image::new(gpu, PassImage::LightBefore.label(), plane, BUFFER, ImageUse::SampledTarget).map(Arc::new);
    Ok([buffer()?, buffer()?])
}
