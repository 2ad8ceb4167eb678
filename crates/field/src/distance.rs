//! Unsigned distances on a grid of cubic voxels: exact near the surface, lower bounds far from it.
//!
//! Invariant: values are in voxels, and exact to f32 rounding or short by at most [`GAP`].
//! Exact distances are computed hierarchically at the corners of blocks of 4 x 4 x 4 voxels. Between them, `d(x)^2 - |x|^2` is
//! a minimum of linear functions of `x`, one for each surface point, hence concave: trilinear interpolation of its corner
//! values never exceeds it. Adding `|x|^2` gives a lower bound, exact at the corners and wherever they share a nearest point.
//! The corners' nearest points give an upper bound. Where the two differ too much or the band may be reached, the voxels of
//! the block are searched exactly.

use super::bvh::Bvh;
use super::face::{LANES, Lanes};
use super::search::{Block, Hit, Points, SIDE};
use super::stage::Stage;
use glam::Vec3;
use rayon::prelude::*;

/// Voxels per side of a block. Lower: corners cost more than they save. Higher: more blocks reach the medial axis or the
/// surface and are searched voxel by voxel.
pub(super) const BLOCK: usize = SIDE;
/// Largest error of a lower bound, in voxels. Lower needs more exact searches far away. Higher makes gradients outside the band
/// wrong by half of it where exact values and lower bounds meet.
const GAP: f32 = 0.25;
/// Rounding of coordinates up to 1024 voxels, with a margin, subtracted from lower bounds.
const ROUNDING: f32 = 1.0e-3;

/// Distances of the voxels of a grid and of the corners of its blocks.
pub(super) struct Distances {
    size: [usize; 3],
    corners: Vec<Hit>,
    values: Vec<f32>,
    exact: Vec<bool>,
    /// Nearest point of each value, if requested.
    points: Vec<Vec3>,
}

/// Block corners per axis of a grid of `size`.
pub(super) fn corner_size(size: [usize; 3]) -> [usize; 3] {
    size.map(|n| n.div_ceil(BLOCK) + 1)
}

impl Distances {
    /// Infinite distances. `points` requests nearest points.
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

    /// Adds the last of `surfaces`, after the others have been added. `band` is in voxels.
    pub(super) fn add(&mut self, surfaces: &[&Bvh], band: f32, stage: &Stage) {
        let Some(added) = surfaces.last() else { return };
        approach(&mut self.corners, corner_size(self.size), BLOCK as f32, added);
        let (size, corners, arch) = (self.size, &self.corners, pulp::Arch::new());
        let slab = size[0] * size[1] * BLOCK;
        let mut points: Vec<&mut [Vec3]> = self.points.chunks_mut(slab).collect();
        points.resize_with(size[2].div_ceil(BLOCK), Default::default);
        let slabs = self.values.par_chunks_mut(slab).zip(self.exact.par_chunks_mut(slab)).zip(points);
        slabs.enumerate().for_each(|(layer, ((values, exact), points))| {
            let layers = values.len() / (size[0] * size[1]);
            arch.dispatch(Fill { size, layer, corners, values, exact, points, surfaces, band });
            stage.advance(layers);
        });
    }

    /// Distance of each voxel, x fastest.
    pub(super) fn values(&self) -> &[f32] {
        &self.values
    }

    /// Distance of a block corner.
    pub(super) fn corner(&self, index: usize) -> f32 {
        self.corners[index].d2.sqrt()
    }

    /// Number of voxels with exact distances.
    pub(super) fn exact(&self) -> usize {
        self.exact.par_iter().filter(|&&exact| exact).count()
    }

    /// The values, and the nearest points if requested. The point of a lower bound is on the surface, farther by at most [`GAP`].
    pub(super) fn into_values(self) -> (Vec<f32>, Vec<Vec3>) {
        (self.values, self.points)
    }
}

/// Updates the exact nearest points of a lattice, `spacing` apart, with another surface.
fn approach(hits: &mut [Hit], size: [usize; 3], spacing: f32, surface: &Bvh) {
    let corners = corner_size(size);
    // A coarser lattice helps neither a single block nor an update.
    let coarse = (size.iter().any(|&n| n > SIDE) && hits[0].d2.is_infinite()).then(|| {
        let mut coarse = vec![Hit::NONE; corners.iter().product()];
        approach(&mut coarse, corners, spacing * SIDE as f32, surface);
        coarse
    });
    let (arch, coarse) = (pulp::Arch::new(), coarse.as_deref());
    hits.par_chunks_mut(size[0] * size[1] * SIDE).enumerate().for_each(|(layer, hits)| {
        arch.dispatch(Approach { size, spacing, layer, coarse, hits, surface });
    });
}

/// One layer of blocks of a lattice of exact distances.
struct Approach<'a> {
    size: [usize; 3],
    spacing: f32,
    layer: usize,
    /// Nearest points of the corners of all blocks, if known.
    coarse: Option<&'a [Hit]>,
    hits: &'a mut [Hit],
    surface: &'a Bvh,
}

impl pulp::NullaryFnOnce for Approach<'_> {
    type Output = ();

    #[inline(always)] // with all its callees, to be compiled for the vectors of this processor
    fn call(self) {
        for at in blocks(self.size, self.layer) {
            let low = Vec3::from_array(at.map(|c| (c * BLOCK) as f32)) * self.spacing;
            let (mut block, mut points) = (Block::new(low, self.spacing), NOWHERE);
            if let Some(coarse) = self.coarse {
                let corners = around(at, self.size, coarse);
                offer(&mut block, &corners);
                block.take(&mut points, |id, _| corners[id as usize].point);
            }
            for (layer, lane) in PLACES {
                let d2 = &mut block.d2[layer][lane];
                match index(self.size, at, layer, lane) {
                    Some(i) if self.hits[i].d2 < *d2 => {
                        (*d2, points[layer][lane]) = (self.hits[i].d2, self.hits[i].point);
                    }
                    Some(_) => {}
                    None => *d2 = 0.0,
                }
            }
            block.search(self.surface);
            block.take(&mut points, |id, p| self.surface.faces()[id as usize].closest(p));
            for (layer, lane) in PLACES {
                if let Some(i) = index(self.size, at, layer, lane) {
                    self.hits[i] = Hit { d2: block.d2[layer][lane], point: points[layer][lane] };
                }
            }
        }
    }
}

/// One layer of blocks of the voxels.
struct Fill<'a> {
    size: [usize; 3],
    layer: usize,
    corners: &'a [Hit],
    values: &'a mut [f32],
    exact: &'a mut [bool],
    /// One for each value, or empty.
    points: &'a mut [Vec3],
    surfaces: &'a [&'a Bvh],
    band: f32,
}

impl pulp::NullaryFnOnce for Fill<'_> {
    type Output = ();

    #[inline(always)] // see `Approach`
    fn call(mut self) {
        for at in blocks(self.size, self.layer) {
            self.fill(at);
        }
    }
}

impl Fill<'_> {
    /// Adds the last surface to the voxels of a block.
    #[inline(always)]
    fn fill(&mut self, at: [usize; 3]) {
        let (size, wanted) = (self.size, !self.points.is_empty());
        let corners = around(at, size, self.corners);
        let low = Vec3::from_array(at.map(|c| (c * BLOCK) as f32));
        let (mut block, mut points) = (Block::new(low, 1.0), NOWHERE);
        offer(&mut block, &corners);
        if wanted {
            block.take(&mut points, |id, _| corners[id as usize].point);
        }
        let lower = lower_bounds(&corners);
        // Squared upper bounds of voxels that are exact already, for the last surface.
        let mut kept = [[0.0; LANES]; SIDE];
        for (layer, lane) in PLACES {
            let d2 = &mut block.d2[layer][lane];
            let Some(i) = index(size, at, layer, lane) else {
                *d2 = 0.0;
                continue;
            };
            let bound = lower[layer][lane];
            if self.exact[i] {
                kept[layer][lane] = d2.min(self.values[i] * self.values[i]);
                *d2 = 0.0;
            } else if bound > self.band.max(1.0) && d2.sqrt() - bound <= GAP {
                // Within a voxel of the surface the sign needs the exact distance, whatever the band.
                self.values[i] = bound;
                if wanted {
                    self.points[i] = points[layer][lane];
                }
                *d2 = 0.0;
            } else {
                self.exact[i] = true;
                self.values[i] = f32::INFINITY;
            }
        }
        for (place, surface) in (1..).zip(self.surfaces) {
            if place == self.surfaces.len() {
                for (layer, lane) in PLACES {
                    block.d2[layer][lane] = block.d2[layer][lane].max(kept[layer][lane]);
                }
            }
            block.search(surface);
            if wanted {
                block.take(&mut points, |id, p| surface.faces()[id as usize].closest(p));
            }
        }
        for (layer, lane) in PLACES {
            let distance = block.d2[layer][lane].sqrt();
            let Some(i) = index(size, at, layer, lane).filter(|&i| self.exact[i]) else { continue };
            if distance < self.values[i] {
                self.values[i] = distance;
                if wanted {
                    self.points[i] = points[layer][lane];
                }
            }
        }
    }
}

/// Points of a block with nothing found.
const NOWHERE: Points = [[Vec3::INFINITY; LANES]; SIDE];
/// Layer and lane of each point of a block.
const PLACES: [(usize, usize); SIDE * LANES] = {
    let mut places = [(0, 0); SIDE * LANES];
    let mut i = 0;
    while i < places.len() {
        places[i] = (i / LANES, i % LANES);
        i += 1;
    }
    places
};

/// Blocks of a layer of a lattice of `size`.
#[inline(always)]
fn blocks(size: [usize; 3], layer: usize) -> impl Iterator<Item = [usize; 3]> {
    let [nx, ny, _] = size.map(|n| n.div_ceil(BLOCK));
    (0..nx * ny).map(move |i| [i % nx, i / nx, layer])
}

/// Index of a point of a block in its layer of blocks; `None` beyond the lattice.
#[inline(always)]
fn index(size: [usize; 3], at: [usize; 3], layer: usize, lane: usize) -> Option<usize> {
    let [x, y, z] = [at[0] * BLOCK + lane % BLOCK, at[1] * BLOCK + lane / BLOCK, at[2] * BLOCK + layer];
    (x < size[0] && y < size[1] && z < size[2]).then(|| (layer * size[1] + y) * size[0] + x)
}

/// The eight corners around a block of a lattice of `size`.
#[inline(always)]
fn around(at: [usize; 3], size: [usize; 3], corners: &[Hit]) -> [Hit; 8] {
    let count = corner_size(size);
    std::array::from_fn(|i| {
        let [x, y, z] = [at[0] + (i & 1), at[1] + (i >> 1 & 1), at[2] + (i >> 2)];
        corners[(z * count[1] + y) * count[0] + x]
    })
}

/// Offers the nearest points of the corners, with their numbers as ids.
#[inline(always)]
fn offer(block: &mut Block, corners: &[Hit; 8]) {
    for (corner, id) in corners.iter().zip(0..) {
        block.offer(corner.point, id);
    }
}

/// Lower bounds of a block, see the module documentation; about 0 near the surface.
#[inline(always)]
#[expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays become vectors")]
fn lower_bounds(corners: &[Hit; 8]) -> [Lanes; SIDE] {
    let part = |i: usize| i as f32 / BLOCK as f32;
    let excess = |t: f32| t * (1.0 - t) * (BLOCK * BLOCK) as f32;
    let mut bounds = [[0.0; LANES]; SIDE];
    for layer in 0..SIDE {
        let t = part(layer);
        let mix = |i: usize| corners[i].d2 + t * (corners[i + 4].d2 - corners[i].d2);
        let [a, b, c, d] = [mix(0), mix(1), mix(2), mix(3)];
        for lane in 0..LANES {
            let (x, y) = (part(lane % SIDE), part(lane / SIDE));
            let (near, far) = (a + x * (b - a), c + x * (d - c));
            let squared = near + y * (far - near) - (excess(x) + excess(y) + excess(t));
            bounds[layer][lane] = (if squared > 0.0 { squared } else { 0.0 }).sqrt() - ROUNDING;
        }
    }
    bounds
}
