//! The shadow volume: how much of the light reaches each place of the scene.
//!
//! Role: [`transmittance`] evaluates the matter of a scene along rays from the light, on the device and with the modules
//! of the picture, and takes the products along the rays. Invariant: the rays are straight lines from the light, so that
//! no shadow is blurred by being handed from texel to texel; see `light_space.glsl` for the space.
//!
//! n rays by n rays of n segments need as many samples as a picture of n x n pixels, where a march from each of the n^3
//! texels to the light would take n / 2 times as many. Handing the light from layer to layer of a grid that does not
//! follow the rays needs no more either, but mixes neighbors in each layer, and knows no light inside of the scene.

use super::bind::{self, BoundInputs};
use super::inputs::Inputs;
use super::sub_frame::SubFrame;
use super::view::View;
use super::{RenderError, Subject};
use crate::gpu::{self, Dimension, Format, Gpu, Image, ImageUse, Pipeline};
use crate::render::pass::{self, Planes};
use crate::render::variant::{Program, Variant};
use crate::scene::Scene;
use crate::shader::{Library, Linker};
use glam::{Mat4, Quat, Vec3};

/// A light is taken to be at most this many radii of the scene away. Farther: f32 holds too few places on a ray. Nearer:
/// shadows of a distant light spread visibly; at this distance by a third of a percent.
const FARTHEST: f32 = 300.0;
/// Up to this angle from its axis, in degrees, a light is outside of the scene for sure, and the corners of the scene are
/// what is farthest from the axis. Beyond, rays leave the light in all directions.
const WIDEST: f32 = 80.0;
/// Samples of a ray in one texel, at most: finer ones than this change nothing that a texel can hold.
const MOST_STEPS: f32 = 64.0;

/// Format of the target that holds the transmittances of four segments in a texel.
const SEGMENTS: Format = Format::Rgba32Float;

/// Where the shadow volume of a scene is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightSpace {
    /// Eye space to that of the light: the light at the origin, the middle of the scene along +z.
    matrix: Mat4,
    /// Angle from the axis that is covered, radians.
    rim: f32,
    /// Distances from the light between which the scene is, object units.
    near: f32,
    far: f32,
    /// Texels along a side.
    side: u32,
    /// Samples along a ray in each.
    steps: f32,
    /// Distance between the slices, where the light goes from one to the next; otherwise 0.
    slice: f32,
}

impl LightSpace {
    pub(super) fn of(scene: &Scene, view: &View, planes: &Planes) -> LightSpace {
        let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|corner: u32| {
            let at = |bit: u32, axis: usize| [view.box_min, view.box_max][(corner >> bit & 1) as usize][axis];
            view.object_matrix.transform_point3(Vec3::new(at(0, 0), at(1, 1), at(2, 2)))
        });
        let center = view.object_matrix.transform_point3(0.5 * (view.box_min + view.box_max));
        let radius = corners.iter().map(|corner| corner.distance(center)).fold(0.0, f32::max);
        let away = view.light_eye - center;
        let light = center + away * (FARTHEST * radius / away.length()).min(1.0);
        let axis = (center - light).normalize_or(Vec3::NEG_Z);
        let turn = Mat4::from_quat(Quat::from_rotation_arc(axis, Vec3::Z));
        let matrix = turn * Mat4::from_translation(-light);
        let seen = corners.map(|corner| matrix.transform_point3(corner));
        let angle = seen.iter().map(|p| p.truncate().length().atan2(p.z)).fold(0.0, f32::max);
        let outside = angle < WIDEST.to_radians();
        // Of a box the nearest corner along the axis is no farther than its nearest point.
        let near = if outside { seen.iter().map(|p| p.z).fold(f32::INFINITY, f32::min).max(0.0) } else { 0.0 };
        let far = seen.iter().map(|p| p.length()).fold(0.0, f32::max).max(near + 1e-3);
        let side = scene.light.shadow_resolution;
        let steps = ((far - near) / (side as f32 * planes.step)).ceil().clamp(1.0, MOST_STEPS);
        let rim = if outside { angle * (1.0 + 1.0 / side as f32) } else { std::f32::consts::PI };
        let slice = if scene.is_half_angle() { planes.step } else { 0.0 };
        LightSpace { matrix, rim, near, far, side, steps, slice }
    }

    /// The longest side of a texel in the middle of the scene, to its corner across the rays; object units.
    fn bias(&self) -> f32 {
        let across = std::f32::consts::SQRT_2 * self.rim * (self.near + self.far) / self.side as f32;
        if self.slice > 0.0 {
            return across + 2.0 * self.slice;
        }
        across.max((self.far - self.near) / self.side as f32)
    }

    /// The members of the block that say where the volume is.
    pub(super) fn values(&self) -> [(&'static str, Vec<f32>); 7] {
        [
            ("shadow_matrix", self.matrix.to_cols_array().to_vec()),
            ("shadow_rim", vec![self.rim]),
            ("shadow_near", vec![self.near]),
            ("shadow_far", vec![self.far]),
            ("shadow_side", vec![self.side as f32]),
            ("shadow_steps", vec![self.steps]),
            ("shadow_bias", vec![self.bias()]),
        ]
    }

    /// Squares of rays in a row of the target that the segments are drawn into: one for each four distances.
    fn columns(&self) -> u32 {
        f64::from(self.side.div_ceil(4)).sqrt().ceil() as u32
    }

    /// Size of the target that the segments are drawn into.
    pub(super) fn target(&self) -> [u32; 2] {
        let columns = self.columns();
        [columns * self.side, self.side.div_ceil(4).div_ceil(columns) * self.side]
    }

    /// Texels of the volume on each axis.
    pub(super) fn texels(&self) -> [u32; 3] {
        [self.side, self.side, self.side + 1]
    }

    /// The light before and behind each segment, ray by ray, from the transmittances of the segments in the target.
    pub(super) fn products(&self, segments: &[[f32; 4]]) -> Vec<f32> {
        let (side, columns) = (self.side as usize, self.columns() as usize);
        let mut left = vec![1.0; side * side * (side + 1)];
        for layer in 0..side {
            let (square, of_four) = (layer / 4, layer % 4);
            let first = (square / columns * side * columns + square % columns) * side;
            let (before, behind) = left.split_at_mut((layer + 1) * side * side);
            let before = &before[layer * side * side..];
            for ray in 0..side * side {
                behind[ray] = before[ray] * segments[first + ray / side * side * columns + ray % side][of_four];
            }
        }
        left
    }
}

/// How much of the light reaches each place of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Transmittance {
    space: LightSpace,
    object_matrix: Mat4,
    /// For each of the distances, which are one more than rays along a side, the rays; in [0, 1].
    values: Vec<f32>,
    /// Milliseconds on the device.
    pub gpu_ms: f64,
}

impl Transmittance {
    /// The light that reaches a place in object space, in [0, 1]: interpolated between rays and along them.
    pub fn at(&self, x: Vec3) -> f32 {
        let space = &self.space;
        let p = space.matrix.transform_point3(self.object_matrix.transform_point3(x));
        let across = p.truncate().normalize_or_zero() * p.truncate().length().atan2(p.z) / space.rim;
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

    /// The volume as it is sampled by the device.
    pub(super) fn image(&self, gpu: &Gpu) -> Result<Image, RenderError> {
        let texels: Vec<u16> = self.values.iter().map(|value| (value * 65535.0).round() as u16).collect();
        let [x, y, z] = self.space.texels();
        let size = Dimension::Volume(x, y, z);
        Ok(Image::sampled(gpu, "shadow volume", size, Format::R16Unorm, bytemuck::cast_slice(&texels))?)
    }
}

/// The shadow volume of a scene, as [`render`](super::render) uses it for a scene with `light.shadows`.
///
/// A ray is sampled as finely as the picture: the error is of first order in that step at hard edges and of second in
/// soft matter, and between the texels of second order in their size.
///
/// # Errors
/// The scene has no valid program, or the device refuses.
pub fn transmittance(
    gpu: &Gpu,
    library: &Library,
    scene: &Scene,
    subject: &Subject,
) -> Result<Transmittance, RenderError> {
    let variant = Variant::of(scene, library)?;
    let program = variant.program(library, Linker::new)?;
    let view = View::of(scene, subject, &variant);
    let planes = view.planes(scene.quality.samples);
    let space = LightSpace::of(scene, &view, &planes);
    let inputs = Inputs::new(scene, subject, &variant, &program, (&view, &planes), &|_| ())?;
    let mut bound = BoundInputs::new(gpu, &program, &inputs)?;
    for sub_frame in SubFrame::all(scene).take(1) {
        bound.fill(scene, subject, &variant, &view, (&planes, &space), &sub_frame)?;
    }
    Caster::new(gpu, library, scene, &variant)?.cast(gpu, &view, &bound, space)
}

/// The program of the shadow volumes of a scene, made once.
pub(super) struct Caster {
    program: Program,
    pipeline: Pipeline,
}

impl Caster {
    pub(super) fn new(gpu: &Gpu, library: &Library, scene: &Scene, variant: &Variant) -> Result<Caster, RenderError> {
        let program = variant.shadow(scene, library)?.program(library, Linker::new)?;
        let bindings: Vec<gpu::Binding> = program.resources.iter().map(bind::binding).collect();
        let pipeline = Pipeline::new(
            gpu,
            &gpu::PipelineDescription {
                vertex: &program.vertex,
                fragment: &program.fragment,
                constants: &[(super::OCTAVES_ID, scene.effect.octaves)],
                bindings: &bindings,
                attributes: &[],
                format: SEGMENTS,
                samples: 1,
                blend: gpu::Blend::Replace,
            },
        )?;
        Ok(Caster { program, pipeline })
    }

    /// Draws the segments with the images of the picture's own program, and takes their products.
    pub(super) fn cast(
        &self,
        gpu: &Gpu,
        view: &View,
        bound: &BoundInputs,
        space: LightSpace,
    ) -> Result<Transmittance, RenderError> {
        let [width, height] = space.target();
        let blocks = bound.blocks_of(gpu, &self.program)?;
        let own = blocks.iter().map(|(binding, block)| (*binding, gpu::Resource::Uniform(block)));
        let set = self.pipeline.bind(&own.chain(bound.images_and_samplers()).collect::<Vec<_>>())?;
        let plane = Dimension::Plane(width, height);
        let color = Image::new(gpu, "shadow segments", plane, SEGMENTS, ImageUse::Target(1))?;
        let target = gpu::Target { color: &color, resolved: None };
        let drawn = pass::march(gpu, &self.pipeline, &set, std::slice::from_ref(&(0..height)), target)?;
        let values = space.products(&color.read()?);
        Ok(Transmittance { space, object_matrix: view.object_matrix, values, gpu_ms: drawn.gpu_ms })
    }
}
