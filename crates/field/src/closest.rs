//! Closest surface points of the samples of a grid.
//!
//! Role: the O(n^3) preprocessing for `project()` of empirical shapes (PH 4). For meshes and scalar volumes the distance
//! search finds the points too (`distance.rs`); here they are derived from a field alone. Invariant: every point is finite.

use super::grid::{DistanceField, Grid, is_identity, turned};
use super::request::Progress;
use glam::Vec3;
use rayon::prelude::*;

/// Newton steps onto the zero level. Lower leaves points of coarse fields off the surface; higher gains nothing.
const STEPS: usize = 4;
/// Largest field value of an accepted point, in voxels. Higher spreads points off the surface to neighbors; lower leaves none
/// in fields of few bits.
const ON_SURFACE: f32 = 0.05;
/// Rounds of taking over nearer points of neighbors. Lower leaves wrong points at a medial axis, where gradients mix its two
/// sides; higher gains nothing.
const EXCHANGES: usize = 3;

/// The closest surface point of every sample of a grid, in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosestPoints {
    /// The samples' grid.
    pub grid: Grid,
    /// Finite point of each sample.
    pub points: Vec<Vec3>,
}

impl ClosestPoints {
    /// The closest points of the zero level of a distance field, from its values and gradients.
    ///
    /// Each sample steps along the gradient onto the zero level, then takes a neighbor's point if that is nearer. Accurate to a
    /// tenth of a voxel on smooth surfaces and to a voxel at edges. Where the field is not a distance, as beyond a clamped
    /// band, the point is as far along the gradient as the value says.
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

    /// The points with permuted axes: see [`DistanceField::turned`].
    pub fn turned(self, axes: [(usize, bool); 3]) -> ClosestPoints {
        if is_identity(axes) {
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

/// Newton step from `p` onto the zero level; `p` itself where the gradient vanishes.
fn stepped(p: Vec3, value: f32, gradient: Vec3) -> Vec3 {
    let squared = gradient.length_squared();
    if squared > 0.1 { p - gradient * (value / squared) } else { p }
}

/// Gradient at any point by differences over a voxel.
fn slope(field: &DistanceField, p: Vec3) -> Vec3 {
    Vec3::from(Vec3::AXES.map(|axis| {
        let step = 0.5 * axis * field.grid.spacing;
        (field.sample(p + step) - field.sample(p - step)) / (2.0 * step.length())
    }))
}
