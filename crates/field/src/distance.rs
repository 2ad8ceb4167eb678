//! Unsigned distances on a grid of cubic voxels: exact near the surface, safe lower bounds far from it.
//!
//! Invariant: voxel units; a value is the distance to f32 rounding, or less than it by at most [`GAP`].
//! Exact distances are first found at the corners of blocks of 4 x 4 x 4 voxels, and before those at the corners of
//! blocks of corners, and so on. Between them, `d(x)^2 - |x|^2` is a minimum of linear functions of `x`, one for each
//! surface point, hence concave: trilinear interpolation of its corner values never exceeds it. Adding `|x|^2` back gives
//! a lower bound, exact at the corners and wherever they share a nearest point. The corners' nearest points give an upper
//! bound, and where the two differ too much, or the band may be reached, the voxel is searched for exactly, together with
//! the others of its block.

use super::bvh::Bvh;
use super::face::{LANES, Lanes};
use super::search::{Block, Hit, Points, SIDE};
use super::stage::Stage;
use glam::Vec3;
use rayon::prelude::*;

/// Voxels along a side of a block. Smaller: the corners cost more than they save. Larger: blocks reach the medial
/// axis or the surface more often and are searched voxel by voxel.
pub(super) const BLOCK: usize = SIDE;
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

/// Brings what is known of a lattice of points, `spacing` apart, up to date with one more surface, exactly.
fn approach(hits: &mut [Hit], size: [usize; 3], spacing: f32, surface: &Bvh) {
    let corners = corner_size(size);
    // Of one block alone, or where something is known already, nothing is gained by looking from farther away.
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
    /// Corners of all blocks, if anything is known of them.
    coarse: Option<&'a [Hit]>,
    hits: &'a mut [Hit],
    surface: &'a Bvh,
}

impl pulp::NullaryFnOnce for Approach<'_> {
    type Output = ();

    #[inline(always)] // as all that is called here: into code for the vectors of this processor
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
    /// One for each value or none.
    points: &'a mut [Vec3],
    surfaces: &'a [&'a Bvh],
    band: f32,
}

impl pulp::NullaryFnOnce for Fill<'_> {
    type Output = ();

    #[inline(always)] // as above
    fn call(mut self) {
        for at in blocks(self.size, self.layer) {
            self.fill(at);
        }
    }
}

impl Fill<'_> {
    /// Adds the last of the surfaces to the voxels of a block. What was exact before can only be shortened by that one.
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
        // What is known of the voxels that were exact before, for the last of the surfaces.
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
                // Within a voxel of the surface the sign needs the exact distance whatever the band.
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

/// No points.
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

/// Where a point of a block is in its layer of blocks, if the lattice reaches so far.
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

/// Offers the nearest points of the corners, under their numbers.
#[inline(always)]
fn offer(block: &mut Block, corners: &[Hit; 8]) {
    for (corner, id) in corners.iter().zip(0..) {
        block.offer(corner.point, id);
    }
}

/// See the head of this file; about 0 where the surface may be near.
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
