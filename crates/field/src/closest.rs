//! Closest points: for every sample of a grid, where on the surface its distance is measured to.
//!
//! Role: PH 4 asks for `project()` of empirical shapes by O(n^3) preprocessing; this is it. For meshes and scalar volumes
//! the search for the distance finds the point too (`distance.rs`); a volume of distances brings no surface, and there
//! the points are made here. Invariant: every point is finite, and next to the surface to the bound stated.

use super::grid::{is_as_it_was, turned};
use super::{DistanceField, Grid, Progress};
use glam::Vec3;
use rayon::prelude::*;

/// Steps of Newton's method onto the zero level. Fewer: points of a coarse field stay off the surface. More: nothing, a
/// distance field is nearly linear across a voxel.
const STEPS: usize = 4;
/// A point counts where the field there is at most this many voxels. Larger: points beside the surface spread to their
/// neighbors. Smaller: fields of few bits have none.
const ON_SURFACE: f32 = 0.05;
/// Times that samples take over a neighbor's point which is nearer than their own. Fewer: gradients that mix the two
/// sides of a medial axis, two samples wide, are not mended. More: nothing.
const EXCHANGES: usize = 3;

/// For every sample of a grid the closest point of a surface, world space.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosestPoints {
    /// Where the samples are.
    pub grid: Grid,
    /// One finite point for each sample of `grid`, x fastest.
    pub points: Vec<Vec3>,
}

impl ClosestPoints {
    /// The closest points of the zero level of a distance field, by its values and gradients alone.
    ///
    /// Each sample steps along the gradient onto the zero level, and then takes the point of a neighbor if that is
    /// nearer. Accuracy, where the field is a distance: a tenth of a voxel on smooth surfaces; up to a voxel at edges,
    /// which the samples do not know. Where it is no distance, as beyond a band that is cut off, the point is as far as the value says, along the gradient.
    pub fn of_field(field: &DistanceField, progress: Progress) -> ClosestPoints {
        let grid = field.grid;
        let [nx, ny, _] = grid.size;
        let voxel = grid.spacing.min_element();
        let each = |take: &(dyn Fn([u32; 3], Vec3) -> Vec3 + Sync)| {
            let point = |index: u32| {
                let at = [index % nx, index / nx % ny, index / (nx * ny)];
                take(at, grid.position(at[0], at[1], at[2]))
            };
            (0..field.values.len() as u32).into_par_iter().map(point).collect::<Vec<Vec3>>()
        };
        let mut points = each(&|[i, j, k], p| {
            let mut closest = stepped(p, field.value(i, j, k), field.gradient(i, j, k));
            for _ in 0..STEPS {
                let value = field.sample(closest);
                if value.abs() <= 1e-3 * voxel {
                    break;
                }
                closest = stepped(closest, value, slope(field, closest));
            }
            if field.sample(closest).abs() <= ON_SURFACE * voxel { closest } else { Vec3::INFINITY }
        });
        progress(0.5);
        for round in 0..EXCHANGES {
            let index = |[i, j, k]: [u32; 3]| ((k * ny + j) * nx + i) as usize;
            points = each(&|at, p| {
                let mut best = points[index(at)];
                for axis in 0..3 {
                    for next in [at[axis].wrapping_sub(1), at[axis] + 1] {
                        if next < grid.size[axis] {
                            let mut neighbor = at;
                            neighbor[axis] = next;
                            let other = points[index(neighbor)];
                            if p.distance_squared(other) < p.distance_squared(best) {
                                best = other;
                            }
                        }
                    }
                }
                best
            });
            progress(0.5 + 0.5 * (round + 1) as f32 / EXCHANGES as f32);
        }
        let points = each(&|[i, j, k], p| {
            let known = points[((k * ny + j) * nx + i) as usize];
            if known.is_finite() { known } else { stepped(p, field.value(i, j, k), field.gradient(i, j, k)) }
        });
        ClosestPoints { grid, points }
    }

    /// The same points in a space with other axes: see [`DistanceField::turned`].
    pub fn turned(self, axes: [(usize, bool); 3]) -> ClosestPoints {
        if is_as_it_was(axes) {
            return self;
        }
        let (grid, mut points) = turned(&self.grid, &self.points, axes);
        points.iter_mut().for_each(|point| {
            let old = *point;
            *point = Vec3::from(axes.map(|(axis, reversed)| if reversed { -old[axis] } else { old[axis] }));
        });
        ClosestPoints { grid, points }
    }
}

/// The step from `p` onto the zero level of a linear function with this value and gradient there; `p` without a gradient.
fn stepped(p: Vec3, value: f32, gradient: Vec3) -> Vec3 {
    let squared = gradient.length_squared();
    if squared > 0.1 { p - gradient * (value / squared) } else { p }
}

/// Gradient at any point, by differences over a voxel.
fn slope(field: &DistanceField, p: Vec3) -> Vec3 {
    Vec3::from(Vec3::AXES.map(|axis| {
        let step = 0.5 * axis * field.grid.spacing;
        (field.sample(p + step) - field.sample(p - step)) / (2.0 * step.length())
    }))
}
