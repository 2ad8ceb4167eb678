//! Volumes: samples on a regular grid.
//!
//! Invariant: values exist only between the samples.

use super::Bounds;
use super::axes::{Axes, lengths};
use glam::{DVec3, Mat3, Vec3};

/// Most voxels of a volume: 8 GiB of f32.
pub const MAX_VOXELS: u64 = 1 << 31;
/// Distance outside the outermost samples that still counts as inside, in voxels.
///
/// Lower: the corners of [`Volume::bounds`], rounded to f32, fall outside of a volume far from the origin (1/128 voxel at the
/// allowed 131072 voxels). Higher: values outside are extrapolated.
const EDGE_TOLERANCE: f64 = 0.01;

/// Samples on a regular grid, x fastest, then y, then z.
#[derive(Clone, Debug)]
pub struct Volume {
    /// Samples per axis, each at least 1.
    pub size: [u32; 3],
    /// World position of sample (0, 0, 0).
    pub origin: Vec3,
    /// World step to the next sample, one column per grid axis; not singular. Diagonal and positive for an aligned grid.
    pub steps: Mat3,
    /// `size[0] * size[1] * size[2]` finite values.
    pub values: Vec<f32>,
    /// Meaning of the values.
    pub content: Content,
}

/// Meaning of the values of a [`Volume`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Content {
    /// A measured or computed scalar: the object is where `value >= iso`.
    Scalar,
    /// A signed distance in world units, positive outside.
    SignedDistance,
    /// Negative inside and zero on the surface; far from the surface only the sign is meaningful.
    LevelSet,
}

impl Volume {
    /// Box around all sample positions, in world units.
    pub fn bounds(&self) -> Bounds {
        let [x, y, z] = self.size.map(|n| n.saturating_sub(1));
        let corner = |i: u32| self.position([x * (i & 1), y * (i >> 1 & 1), z * (i >> 2)]);
        let start = Bounds { min: self.origin, max: self.origin };
        (1..8).map(corner).fold(start, |b, p| Bounds { min: b.min.min(p), max: b.max.max(p) })
    }

    /// World distances between neighboring samples along the grid axes.
    pub fn spacing(&self) -> Vec3 {
        lengths(&self.steps.as_dmat3()).as_vec3()
    }

    /// Whether the grid axes are the world axes, all forwards.
    pub fn is_aligned(&self) -> bool {
        let along = Vec3::new(self.steps.x_axis.x, self.steps.y_axis.y, self.steps.z_axis.z);
        self.steps == Mat3::from_diagonal(along) && along.cmpgt(Vec3::ZERO).all()
    }

    /// Transform between grid indices and the world.
    pub fn axes(&self) -> Axes {
        Axes::new(self.origin.as_dvec3(), self.steps.as_dmat3())
    }

    /// World position of the sample with index `[x, y, z]`.
    pub fn position(&self, index: [u32; 3]) -> Vec3 {
        let index = DVec3::from(index.map(f64::from));
        (self.origin.as_dvec3() + self.steps.as_dmat3() * index).as_vec3()
    }

    /// Smallest and largest value; (inf, -inf) for an empty volume.
    pub fn range(&self) -> (f32, f32) {
        self.values.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)))
    }

    /// Median gradient length where the sign changes, per world unit: 1 for a signed distance, `None` without a sign change.
    pub fn slope_at_zero(&self) -> Option<f32> {
        let [nx, ny, nz] = self.size.map(|n| n as usize);
        let at = |x: usize, y: usize, z: usize| self.values[(z * ny + y) * nx + x];
        // In f64: products of tiny steps and differences of large values leave the range of f32.
        let to_world = self.steps.as_dmat3().inverse().transpose();
        let mut slopes = Vec::new();
        for z in 0..nz.saturating_sub(1) {
            for y in 0..ny.saturating_sub(1) {
                for x in 0..nx.saturating_sub(1) {
                    let value = at(x, y, z);
                    let next = Vec3::new(at(x + 1, y, z), at(x, y + 1, z), at(x, y, z + 1));
                    if next.to_array().iter().any(|next| (*next <= 0.0) != (value <= 0.0)) {
                        slopes.push((to_world * (next.as_dvec3() - f64::from(value))).length() as f32);
                    }
                }
            }
        }
        let middle = slopes.len() / 2;
        (!slopes.is_empty()).then(|| *slopes.select_nth_unstable_by(middle, f32::total_cmp).1)
    }

    /// Trilinear value at world position `p`; `None` outside the grid, from its first to its last samples, and for NaN.
    ///
    /// Exact at the samples of an aligned grid, up to the rounding of positions on others. Points up to 1/100 voxel outside get
    /// the value of the nearest point on the grid.
    pub fn sample(&self, p: Vec3) -> Option<f32> {
        let local = self.axes().index(p.as_dvec3());
        let mut cell = [(0_usize, 0_usize, 0.0_f64); 3];
        for (axis, (cell, x)) in cell.iter_mut().zip(local.to_array()).enumerate() {
            let last = self.size[axis].checked_sub(1)? as f64;
            if !(-EDGE_TOLERANCE..=last + EDGE_TOLERANCE).contains(&x) {
                return None;
            }
            let x = x.clamp(0.0, last);
            let low = x.floor();
            *cell = (low as usize, x.ceil() as usize, x - low);
        }
        let [x, y, z] = cell;
        let [nx, ny, _] = self.size.map(|n| n as usize);
        let row = |y: usize, z: usize| {
            let start = (z * ny + y) * nx;
            Some(lerp(*self.values.get(start + x.0)?, *self.values.get(start + x.1)?, x.2))
        };
        let near = row(y.0, z.0)? * (1.0 - y.2) + row(y.1, z.0)? * y.2;
        let far = row(y.0, z.1)? * (1.0 - y.2) + row(y.1, z.1)? * y.2;
        Some((near * (1.0 - z.2) + far * z.2) as f32)
    }
}

fn lerp(a: f32, b: f32, t: f64) -> f64 {
    f64::from(a) * (1.0 - t) + f64::from(b) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the trilinear function f, on a grid with different sizes and spacings per axis.
    fn trilinear() -> (Volume, impl Fn(Vec3) -> f32) {
        let f = |p: Vec3| 1.0 + 2.0 * p.x - 3.0 * p.y + p.z * p.x * p.y;
        let mut volume = Volume {
            size: [3, 4, 5],
            origin: Vec3::new(-1.0, 2.0, 0.5),
            steps: Mat3::from_diagonal(Vec3::new(0.5, 0.25, 2.0)),
            values: Vec::new(),
            content: Content::Scalar,
        };
        for z in 0..5 {
            for y in 0..4 {
                for x in 0..3 {
                    volume.values.push(f(volume.position([x, y, z])));
                }
            }
        }
        (volume, f)
    }

    #[test]
    fn sampling_a_trilinear_function_is_exact_between_the_samples() {
        let (volume, f) = trilinear();
        for p in [[-1.0, 2.0, 0.5], [0.0, 2.75, 8.5], [-0.3, 2.6, 3.1], [-0.01, 2.01, 8.4]].map(Vec3::from) {
            assert!((volume.sample(p).unwrap() - f(p)).abs() < 1e-5, "{p}");
        }
    }

    #[test]
    fn turned_and_sheared_grids_keep_their_values_in_the_world() {
        // A linear function is linear along every axis.
        let f = |p: Vec3| 1.0 + 2.0 * p.x - 3.0 * p.y + 0.5 * p.z;
        for turn in [
            Mat3::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 1.1),
            Mat3::from_cols(Vec3::X, Vec3::new(0.4, 1.0, 0.0), Vec3::new(0.0, 0.3, -1.0)),
        ] {
            let (mut volume, _) = trilinear();
            volume.steps = turn * volume.steps;
            let indices = (0..60).map(|i| [i % 3, i / 3 % 4, i / 12]);
            volume.values = indices.clone().map(|index| f(volume.position(index))).collect();
            let spacing = Vec3::new(turn.x_axis.length(), turn.y_axis.length(), turn.z_axis.length());
            assert!((volume.spacing() - spacing * Vec3::new(0.5, 0.25, 2.0)).abs().max_element() < 1e-6);
            assert!(!volume.is_aligned());
            let bounds = volume.bounds();
            for index in indices {
                let p = volume.position(index);
                let expected = volume.origin + volume.steps * Vec3::from(index.map(|i| i as f32));
                assert!(p.distance(expected) < 1e-5 && p.cmpge(bounds.min).all() && p.cmple(bounds.max).all());
                let inner = 0.5 * (p + volume.position([1, 2, 2]));
                assert!((volume.sample(inner).unwrap() - f(inner)).abs() < 1e-4, "{inner}");
            }
            // Corners of the box around it are outside of it.
            assert_eq!((volume.sample(bounds.min), volume.sample(bounds.max)), (None, None));
        }
    }

    #[test]
    fn a_grid_is_aligned_with_forward_world_axes() {
        let of = |steps| Volume { steps, ..trilinear().0 }.is_aligned();
        assert!(of(Mat3::IDENTITY) && of(Mat3::from_diagonal(Vec3::new(1e-30, 2.0, 1e18))));
        assert!(!of(Mat3::from_diagonal(Vec3::new(1.0, -1.0, 1.0))) && !of(Mat3::from_rotation_z(1e-6)));
        assert!(!of(Mat3::from_cols(Vec3::Y, Vec3::X, Vec3::Z)));
        // Lengths whose squares f32 does not hold.
        for spacing in [Vec3::new(1e-30, 1.0, 1e18), Vec3::new(0.1, 0.7, 1.0 / 3.0)] {
            assert_eq!(Volume { steps: Mat3::from_diagonal(spacing), ..trilinear().0 }.spacing(), spacing);
        }
    }

    #[test]
    fn there_is_no_value_outside_the_samples() {
        let (volume, _) = trilinear();
        let Bounds { min, max } = volume.bounds();
        assert!(volume.sample(min).is_some() && volume.sample(max).is_some());
        assert_eq!(volume.sample(min - Vec3::X * 0.1), None);
        assert_eq!(volume.sample(max + Vec3::Z * 0.1), None);
        assert_eq!(volume.sample(Vec3::new(f32::NAN, 2.5, 1.0)), None);
    }

    /// A ball whose values change by `rate` per world unit, 13 voxels of different lengths wide.
    fn ball(rate: f32) -> Volume {
        let (size, spacing) = ([13, 15, 17], Vec3::new(0.2, 0.17, 0.15));
        let origin = -0.5 * spacing * Vec3::new(12.0, 14.0, 16.0);
        let mut volume = Volume {
            size,
            origin,
            steps: Mat3::from_diagonal(spacing),
            values: Vec::new(),
            content: Content::SignedDistance,
        };
        for index in 0..13 * 15 * 17 {
            let place = volume.position([index % 13, index / 13 % 15, index / 195]);
            volume.values.push(rate * (place.length() - 0.9));
        }
        volume
    }

    #[test]
    fn a_distance_rises_by_1_and_what_claims_to_be_one_does_not() {
        for rate in [1.0, 0.25, 40.0] {
            let slope = ball(rate).slope_at_zero().unwrap() / rate;
            assert!((slope - 1.0).abs() < 0.05, "{rate}: {slope}");
        }
        assert_eq!(Volume { values: vec![1.0; 13 * 15 * 17], ..ball(1.0) }.slope_at_zero(), None);
        for scale in [1e-15, 1e15] {
            let mut scaled = ball(scale);
            (scaled.origin, scaled.steps) = (scale * scaled.origin, scale * scaled.steps);
            assert!((scaled.slope_at_zero().unwrap() - 1.0).abs() < 0.05, "{scale}");
        }
    }
}
