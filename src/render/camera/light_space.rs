//! The space of the shadow volume: rays from the light.

use super::planes::SlicePlanes;
use super::view::View;
use crate::scene::{SHADOW_SAMPLES, Scene};
use glam::{Mat4, Quat, Vec3};

/// A light is taken to be at most this many radii of the scene away. Farther: f32 holds too few places on a ray. Nearer:
/// shadows of a distant light spread visibly; at this distance by a third of a percent.
const FARTHEST: f32 = 300.0;
/// Up to this angle from its axis, in degrees, a light is outside of the scene for sure, and the corners of the scene are
/// what is farthest from the axis. Beyond, rays leave the light in all directions.
const WIDEST: f32 = 80.0;
/// Samples of a ray in one texel, at most. Fewer: thin matter casts no shadow. More: they take as many times longer. Pixels
/// of the reference of `tank` at 64 x 64 differ with 16 from those with 64 by 8e-6 in the root mean square and 6e-4 at most; with 8
/// samples by 5e-4 and 0.04.
const MOST_STEPS: f32 = (SHADOW_SAMPLES / 4) as f32;
/// Steps of the picture's rays in one of the light's. What a shadow is wrong by is dimmed and blurred in the picture: with 2,
/// pictures of six scenes at 64 to 512 samples are off by at most 1.2 times as much as with 1, mostly by the same, and their
/// shadows take some 0.7 times as long (0.5 to 1.1). Less: slower. More: thin hair, off by 1.2 to 2 times as much with 4, casts too little.
const STRIDE: f32 = 2.0;

/// Where the shadow volume of a scene is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LightSpace {
    /// Eye space to that of the light: the light at the origin, the middle of the scene along +z.
    pub(crate) matrix: Mat4,
    /// Angle from the axis that is covered, radians.
    pub(crate) rim: f32,
    /// Distances from the light between which the scene is, object units.
    pub(crate) near: f32,
    pub(crate) far: f32,
    /// Texels along a side.
    pub(crate) side: u32,
    /// Samples along a ray in each.
    steps: f32,
    /// Distance between the slices, where the light goes from one to the next; otherwise 0.
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
        let steps = ((far - near) / (side as f32 * STRIDE * planes.step)).ceil().clamp(1.0, MOST_STEPS);
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

    /// Squares of rays in a row of the target that the segments are drawn into: one for each four distances.
    fn columns(&self) -> u32 {
        f64::from(self.side.div_ceil(4)).sqrt().ceil() as u32
    }

    /// Size of the target that the segments are drawn into.
    pub(crate) fn target(&self) -> [u32; 2] {
        let columns = self.columns();
        [columns * self.side, self.side.div_ceil(4).div_ceil(columns) * self.side]
    }

    /// Rays along a side of a square of the target, and where each square begins, from the light on.
    pub(crate) fn squares(&self) -> (u32, impl Iterator<Item = [u32; 2]> + Clone + use<>) {
        let (side, columns) = (self.side, self.columns());
        (side, (0..side.div_ceil(4)).map(move |square| [square % columns * side, square / columns * side]))
    }

    /// Texels of the volume on each axis.
    pub(crate) fn texels(&self) -> [u32; 3] {
        [self.side, self.side, self.side + 1]
    }

    /// The light before and behind each segment, ray by ray, from the transmittances of the segments in the target; each
    /// as this `code` of it.
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
