//! Space of the shadow volume, spanned by rays from the light.

use super::planes::SlicePlanes;
use super::view::View;
use crate::scene::{SHADOW_SAMPLES, Scene};
use glam::{Mat4, Quat, Vec3};
use std::f32::consts::{PI, SQRT_2};

/// Largest distance of a light, radii of the scene. Higher: f32 loses places along a ray. Lower: shadows of a distant
/// light spread visibly; at this distance by a third of a percent.
const MAX_LIGHT_DISTANCE: f32 = 300.0;
/// Largest angle of a scene's corner from the axis of the light, degrees, at which the light is surely outside the
/// scene. Beyond it, rays leave the light in all directions.
const MAX_LIGHT_ANGLE: f32 = 80.0;
/// Largest number of samples of a light ray in a texel. Lower: thin matter casts no shadow. Higher: slower in
/// proportion. Pixels of the reference of `tank` at 64 x 64 differ between 16 and 64 samples by 8e-6 (root mean square)
/// and 6e-4 at most; between 8 and 64 by 5e-4 and 0.04.
const MOST_STEPS: f32 = (SHADOW_SAMPLES / 4) as f32;
/// Steps of the picture's rays in one step of a light ray. The picture dims and blurs errors of a shadow: with 2,
/// pictures of six scenes at 64 to 512 samples have at most 1.2 times the error of 1, most of them an equal one, and
/// shadows take 0.7 times as long (0.5 to 1.1). Lower: slower. Higher: with 4, thin hair casts too little (1.2 to 2
/// times the error).
const STRIDE: f32 = 2.0;

/// Position and resolution of a shadow volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LightSpace {
    /// From eye space to light space: the light at the origin, the middle of the scene along +z.
    pub(crate) matrix: Mat4,
    /// Radius of the map that is covered: see [`LightSpace::radius`].
    pub(crate) rim: f32,
    /// Distances from the light that bound the scene, object units.
    pub(crate) near: f32,
    pub(crate) far: f32,
    /// Texels along a side.
    pub(crate) side: u32,
    /// Samples along a ray in a texel.
    steps: f32,
    /// Distance between slices with half-angle slicing, otherwise 0.
    slice: f32,
}

impl LightSpace {
    pub(crate) fn of(scene: &Scene, view: &View, planes: &SlicePlanes) -> LightSpace {
        let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|corner: u32| {
            let at = |bit: u32, axis: usize| [view.box_min, view.box_max][(corner >> bit & 1) as usize][axis];
            view.object_matrix.transform_point3(Vec3::new(at(0, 0), at(1, 1), at(2, 2)))
        });
        let center = view.object_matrix.transform_point3(0.5 * (view.box_min + view.box_max));
        let radius = corners.iter().map(|corner| corner.distance(center)).fold(0.0, f32::max);
        let away = view.light_eye - center;
        let light = center + away * (MAX_LIGHT_DISTANCE * radius / away.length()).min(1.0);
        let axis = (center - light).normalize_or(Vec3::NEG_Z);
        let turn = Mat4::from_quat(Quat::from_rotation_arc(axis, Vec3::Z));
        let matrix = turn * Mat4::from_translation(-light);
        let seen = corners.map(|corner| matrix.transform_point3(corner));
        let angle = seen.iter().map(|p| p.truncate().length().atan2(p.z)).fold(0.0, f32::max);
        let outside = angle < MAX_LIGHT_ANGLE.to_radians();
        // The nearest corner of a box along the axis is at most as far as its nearest point.
        let near = if outside { seen.iter().map(|p| p.z).fold(f32::INFINITY, f32::min).max(0.0) } else { 0.0 };
        let far = seen.iter().map(|p| p.length()).fold(0.0, f32::max).max(near + 1e-3);
        let side = scene.light.shadow_resolution;
        let steps = ((far - near) / (side as f32 * STRIDE * planes.step)).ceil().clamp(1.0, MOST_STEPS);
        let angle = if outside { angle } else { PI };
        let rim = LightSpace::radius(angle) * if outside { 1.0 + 1.0 / side as f32 } else { 1.0 };
        let slice = if scene.is_half_angle() { planes.step } else { 0.0 };
        LightSpace { matrix, rim, near, far, side, steps, slice }
    }

    /// Distance of a ray from the middle of the map, by its angle from the axis in radians: `light_space.glsl`.
    pub(crate) fn radius(angle: f32) -> f32 {
        4.0 * (angle / 4.0).sin()
    }

    /// Longest side or diagonal of a texel in the middle of the scene, object units. At an angle
    /// a, the sides of a texel are 1 / cos(a / 4) and cos(a / 2) cos(a / 4) times those in the middle of the map: no diagonal
    /// is longer than there.
    fn bias(&self) -> f32 {
        let across = SQRT_2 * self.rim * (self.near + self.far) / self.side as f32;
        if self.slice > 0.0 {
            return across + 2.0 * self.slice;
        }
        across.max((self.far - self.near) / self.side as f32)
    }

    /// Values of the block that locates the volume.
    pub(crate) fn values(&self) -> [(&'static str, Vec<f32>); 7] {
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

    /// Squares of rays in a row of the segment target; a square holds four distances.
    fn columns(&self) -> u32 {
        f64::from(self.side.div_ceil(4)).sqrt().ceil() as u32
    }

    /// Size of the target of the segments.
    pub(crate) fn target(&self) -> [u32; 2] {
        let columns = self.columns();
        [columns * self.side, self.side.div_ceil(4).div_ceil(columns) * self.side]
    }

    /// Rays along a side of a square of the target, and the corner of each square in order from the light.
    pub(crate) fn squares(&self) -> (u32, impl Iterator<Item = [u32; 2]> + Clone + use<>) {
        let (side, columns) = (self.side, self.columns());
        (side, (0..side.div_ceil(4)).map(move |square| [square % columns * side, square / columns * side]))
    }

    /// Texels of the volume on each axis.
    pub(crate) fn texels(&self) -> [u32; 3] {
        [self.side, self.side, self.side + 1]
    }

    /// Light before and behind each segment, ray by ray, encoded by `code`: products of the segments' transmittances.
    pub(crate) fn products<T: Clone>(&self, segments: &[[f32; 4]], code: impl Fn(f32) -> T) -> Vec<T> {
        let (side, columns) = (self.side as usize, self.columns() as usize);
        let rays = side * side;
        let mut left = vec![code(1.0); rays * (side + 1)];
        let mut light = vec![1.0; rays];
        for square in 0..side.div_ceil(4) {
            let first = (square / columns * side * columns + square % columns) * side;
            let behind = &mut left[(4 * square + 1) * rays..];
            let count = (side - 4 * square).min(4);
            for (row, light) in light.chunks_exact_mut(side).enumerate() {
                let own = &segments[first + row * side * columns..][..side];
                for (column, (light, segment)) in light.iter_mut().zip(own).enumerate() {
                    for (layer, part) in segment[..count].iter().enumerate() {
                        *light *= part;
                        behind[layer * rays + row * side + column] = code(*light);
                    }
                }
            }
        }
        left
    }
}
