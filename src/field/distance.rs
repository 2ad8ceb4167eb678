//! Unsigned distances on a grid of cubic voxels: exact near the surface, safe lower bounds far from it.
//!
//! Invariant: voxel units; a value is the distance to f32 rounding, or less than it by at most [`GAP`].
//! Exact distances are first found at the corners of blocks of 4 x 4 x 4 voxels. Between them, `d(x)^2 - |x|^2` is a
//! minimum of linear functions of `x`, one for each surface point, hence concave: trilinear interpolation of its corner
//! values never exceeds it. Adding `|x|^2` back gives a lower bound, exact at the corners and wherever they share a
//! nearest point. The corners' nearest points give an upper bound, and where the two differ too much, or the band may
//! be reached, the voxel is searched for exactly.

use super::bvh::{Bvh, Hit};
use super::stage::Stage;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Voxels along a side of a block. Smaller: the corners cost more than they save. Larger: blocks reach the medial
/// axis or the surface more often and are searched voxel by voxel.
pub(super) const BLOCK: usize = 4;
/// Largest loss of a lower bound, in voxels. Smaller: more exact searches far away, for rays that skip there anyway.
/// Larger: gradients outside the band go wrong by half of it where exact values and lower bounds meet.
const GAP: f32 = 0.25;
/// Subtracted from lower bounds: the rounding of coordinates up to 1024 voxels, with room to spare.
const ROUNDING: f32 = 1.0e-3;

/// Distances of every voxel of a grid and of every corner of its blocks.
pub(super) struct Distances {
    size: [usize; 3],
    corners: Vec<Hit>,
    values: Vec<f32>,
    exact: Vec<bool>,
    /// Nearest points, one for each value, where they were asked for; else empty.
    points: Vec<Vec3>,
}

/// Block corners per axis of a grid of `size`.
pub(super) fn corner_size(size: [usize; 3]) -> [usize; 3] {
    size.map(|n| n.div_ceil(BLOCK) + 1)
}

impl Distances {
    /// Distances to nothing: infinite. With `points`, the nearest points are kept too.
    pub(super) fn new(size: [usize; 3], points: bool) -> Distances {
        let voxels = size.iter().product();
        let corners = corner_size(size).iter().product();
        Distances {
            size,
            corners: vec![Hit::NONE; corners],
            values: vec![f32::INFINITY; voxels],
            exact: vec![false; voxels],
            points: vec![Vec3::INFINITY; if points { voxels } else { 0 }],
        }
    }

    /// Adds the last of `surfaces`; the others have been added before. `band` is in voxels.
    pub(super) fn add(&mut self, surfaces: &[&Bvh], band: f32, stage: &Stage) {
        let Some(added) = surfaces.last() else { return };
        let corners = corner_size(self.size);
        self.corners.par_chunks_mut(corners[0]).enumerate().for_each(|(row, hits)| {
            let (y, z) = (row % corners[1], row / corners[1]);
            let mut warm = Hit::NONE;
            for (x, hit) in hits.iter_mut().enumerate() {
                let p = Vec3::new(x as f32, y as f32, z as f32) * BLOCK as f32;
                let start = if warm.d2.is_finite() { hit.or_point(p, warm.point) } else { *hit };
                *hit = added.closest(p, start);
                warm = *hit;
            }
        });
        let (size, known) = (self.size, &self.corners);
        let slab = size[0] * size[1] * BLOCK;
        let mut points: Vec<&mut [Vec3]> = self.points.chunks_mut(slab).collect();
        points.resize_with(size[2].div_ceil(BLOCK), Default::default);
        let slabs = self.values.par_chunks_mut(slab).zip(self.exact.par_chunks_mut(slab)).zip(points);
        slabs.enumerate().for_each(|(bz, ((values, exact), points))| {
            for by in 0..corners[1] - 1 {
                for bx in 0..corners[0] - 1 {
                    let cell = Cell::new([bx, by, bz], corners, known);
                    cell.fill(size, (&mut *values, &mut *exact, &mut *points), surfaces, band);
                }
            }
            stage.advance(values.len() / (size[0] * size[1]));
        });
    }

    /// One value for each voxel, x fastest.
    pub(super) fn values(&self) -> &[f32] {
        &self.values
    }

    /// Distance of every block corner.
    pub(super) fn corner(&self, index: usize) -> f32 {
        self.corners[index].d2.sqrt()
    }

    /// Voxels with exact distances.
    pub(super) fn exact(&self) -> usize {
        self.exact.par_iter().filter(|&&exact| exact).count()
    }

    /// The values, and the nearest points if they were asked for: where a value is a lower bound, a point of the surface
    /// that is farther by at most [`GAP`] than it.
    pub(super) fn into_values(self) -> (Vec<f32>, Vec<Vec3>) {
        (self.values, self.points)
    }
}

/// What is known of one layer of blocks: values, whether they are exact, and nearest points where they are kept.
type Slab<'a> = (&'a mut [f32], &'a mut [bool], &'a mut [Vec3]);

/// The eight corners around a block.
struct Cell {
    block: [usize; 3],
    squares: [f32; 8],
    points: [[Vec4; 3]; 2],
}

impl Cell {
    fn new(block: [usize; 3], corners: [usize; 3], known: &[Hit]) -> Cell {
        let hit = |i: usize| {
            let [x, y, z] = [block[0] + (i & 1), block[1] + (i >> 1 & 1), block[2] + (i >> 2)];
            known[(z * corners[1] + y) * corners[0] + x]
        };
        let hits: [Hit; 8] = std::array::from_fn(hit);
        let lanes = |first: usize| {
            [0, 1, 2].map(|axis| Vec4::from_array(std::array::from_fn(|lane| hits[first + lane].point[axis])))
        };
        Cell { block, squares: hits.map(|hit| hit.d2), points: [lanes(0), lanes(4)] }
    }

    /// Adds the last of `surfaces` to the voxels of the block, in its slab of the grid. Whole blocks, not rows: their
    /// searches meet the same few boxes, which a cache can hold where it cannot hold those of a row.
    fn fill(&self, size: [usize; 3], (values, exact, points): Slab<'_>, surfaces: &[&Bvh], band: f32) {
        let [x0, y0, z0] = self.block.map(|b| b * BLOCK);
        let mut warm: Option<Vec3> = None;
        for z in z0..size[2].min(z0 + BLOCK) {
            for y in y0..size[1].min(y0 + BLOCK) {
                for x in x0..size[0].min(x0 + BLOCK) {
                    let i = ((z - z0) * size[1] + y) * size[0] + x;
                    let p = Vec3::new(x as f32, y as f32, z as f32);
                    let mut hit = self.nearest(p);
                    if !exact[i] {
                        // Within a voxel of the surface the sign needs the exact distance whatever the band.
                        let lower = self.lower_bound(p);
                        if lower > band.max(1.0) && hit.d2.sqrt() - lower <= GAP {
                            values[i] = lower;
                            if let Some(point) = points.get_mut(i) {
                                *point = hit.point;
                            }
                            continue;
                        }
                    }
                    if let Some(point) = warm {
                        hit = hit.or_point(p, point);
                    }
                    // What was exact before can only be shortened by the surface that has just been added.
                    let searched = if exact[i] { &surfaces[surfaces.len() - 1..] } else { surfaces };
                    for surface in searched {
                        hit = surface.closest(p, hit);
                    }
                    warm = Some(hit.point);
                    if !exact[i] || hit.d2.sqrt() < values[i] {
                        values[i] = hit.d2.sqrt();
                        if let Some(point) = points.get_mut(i) {
                            *point = hit.point;
                        }
                    }
                    exact[i] = true;
                }
            }
        }
    }

    /// The nearest of the corners' nearest points: an upper bound.
    fn nearest(&self, p: Vec3) -> Hit {
        let mut best = Hit::NONE;
        for points in &self.points {
            let axis = |i: usize| {
                let d = points[i] - Vec4::splat(p[i]);
                d * d
            };
            let d2 = axis(0) + axis(1) + axis(2);
            let lane = d2.min_position();
            if d2[lane] < best.d2 {
                best = Hit { d2: d2[lane], point: Vec3::from_array([0, 1, 2].map(|i| points[i][lane])) };
            }
        }
        best
    }

    /// See the head of this file; about 0 where the surface may be near.
    fn lower_bound(&self, p: Vec3) -> f32 {
        let t = p / BLOCK as f32 - Vec3::from_array(self.block.map(|b| b as f32));
        let d2 = &self.squares;
        let x = [0, 2, 4, 6].map(|i| d2[i] + t.x * (d2[i + 1] - d2[i]));
        let (near, far) = (x[0] + t.y * (x[1] - x[0]), x[2] + t.y * (x[3] - x[2]));
        let excess = (t * (Vec3::ONE - t)).element_sum() * (BLOCK * BLOCK) as f32;
        (near + t.z * (far - near) - excess).max(0.0).sqrt() - ROUNDING
    }
}
