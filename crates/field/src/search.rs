//! Nearest-triangle search for blocks of points.
//!
//! Invariant: squared distances only decrease, and are exact once every box that may hold a nearer triangle has been opened.
//! The points of a block visit nearly the same boxes, so the tree is traversed once for all of them. Triangles are then
//! measured lane by lane, for the layers of the block that may gain.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays become vectors")]

use super::bvh::{Bvh, WIDTH};
use super::face::{LANES, Lanes};
use glam::{Vec3, Vec4};

/// Points per side of a block. A layer fills the lanes.
pub(super) const SIDE: usize = 4;

/// The nearest surface point found for a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Squared distance to `point`.
    pub d2: f32,
    /// The surface point.
    pub point: Vec3,
}

impl Hit {
    /// Nothing found.
    pub(super) const NONE: Hit = Hit { d2: f32::INFINITY, point: Vec3::INFINITY };
}

/// A cube of points with the nearest found for each: layers of constant z, x fastest in each.
pub(super) struct Block {
    low: Vec3,
    spacing: f32,
    x: Lanes,
    y: Lanes,
    /// Squared distances, upper bounds before a search. Points of distance 0 are not searched.
    pub(super) d2: [Lanes; SIDE],
    /// Ids of the nearest found since the last [`Block::take`].
    id: [[u32; LANES]; SIDE],
}

/// A surface point for each point of a block.
pub(super) type Points = [[Vec3; LANES]; SIDE];

/// The id of nothing.
const NONE: u32 = u32::MAX;

/// A box to be opened: level, index, squared distance to the block.
type Pending = (u32, u32, f32);

impl Block {
    /// A block of points `spacing` apart, with nothing found.
    #[inline(always)]
    pub(super) fn new(low: Vec3, spacing: f32) -> Block {
        let x = std::array::from_fn(|lane| low.x + spacing * (lane % SIDE) as f32);
        let y = std::array::from_fn(|lane| low.y + spacing * (lane / SIDE) as f32);
        Block { low, spacing, x, y, d2: [[f32::INFINITY; LANES]; SIDE], id: [[NONE; LANES]; SIDE] }
    }

    /// Takes over a surface point of this id wherever it is nearer.
    #[inline(always)]
    pub(super) fn offer(&mut self, point: Vec3, id: u32) {
        for layer in 0..SIDE {
            let z = self.z(layer) - point.z;
            for lane in 0..LANES {
                let (x, y) = (self.x[lane] - point.x, self.y[lane] - point.y);
                let found = x * x + y * y + z * z;
                let nearer = found < self.d2[layer][lane];
                self.d2[layer][lane] = if nearer { found } else { self.d2[layer][lane] };
                self.id[layer][lane] = if nearer { id } else { self.id[layer][lane] };
            }
        }
    }

    /// Searches a tree for nearer triangles.
    #[inline(always)]
    pub(super) fn search(&mut self, bvh: &Bvh) {
        if bvh.triangles() == 0 {
            return;
        }
        let levels = bvh.levels();
        let high = self.low + self.spacing * (SIDE - 1) as f32;
        let (low, high) = (self.low.to_array().map(Vec4::splat), high.to_array().map(Vec4::splat));
        // At most three siblings are pending on each level, and 4^16 triangles need 16 levels.
        let mut stack: [Pending; 3 * 16 + WIDTH] = [(0, 0, 0.0); 3 * 16 + WIDTH];
        let mut top = 1;
        stack[0] = (levels.len() as u32, 0, 0.0);
        let mut farthest = self.farthest();
        while top > 0 {
            top -= 1;
            let (level, index, bound) = stack[top];
            if bound >= farthest {
                continue;
            }
            let mut gains = [true; SIDE];
            if let Some(nodes) = levels.get(level as usize) {
                let (low, high) = nodes[index as usize / WIDTH].child(index as usize % WIDTH);
                gains = self.gains(low, high);
            }
            if let Some(frame) = bvh.frame(level as usize, index as usize).filter(|_| gains != [false; SIDE]) {
                let flat = frame.flat(&self.x, &self.y);
                for layer in 0..SIDE {
                    gains[layer] = gains[layer] && frame.gains(&flat, self.z(layer), &self.d2[layer]);
                }
            }
            if gains == [false; SIDE] {
                continue;
            }
            if level == 0 {
                self.measure(bvh, index as usize, gains);
                farthest = self.farthest();
                continue;
            }
            let bounds = levels[level as usize - 1][index as usize].distance2(&low, &high).to_array();
            let first = top;
            for (lane, &bound) in bounds.iter().enumerate() {
                if bound < farthest {
                    // Insertion sort with the nearest on top.
                    let mut at = top;
                    while at > first && stack[at - 1].2 < bound {
                        stack[at] = stack[at - 1];
                        at -= 1;
                    }
                    stack[at] = (level - 1, index * WIDTH as u32 + lane as u32, bound);
                    top += 1;
                }
            }
        }
    }

    /// Measures the distances of some layers to the triangles of a packet.
    #[inline(always)]
    fn measure(&mut self, bvh: &Bvh, packet: usize, layers: [bool; SIDE]) {
        let first = packet * WIDTH;
        let faces = &bvh.faces()[first..bvh.triangles().min(first + WIDTH)];
        for (face, id) in faces.iter().zip(first as u32..) {
            let flat = face.frame().flat(&self.x, &self.y);
            for layer in 0..SIDE {
                let z = self.z(layer);
                if layers[layer] && face.frame().gains(&flat, z, &self.d2[layer]) {
                    face.lower(id, &flat, z, &mut self.d2[layer], &mut self.id[layer]);
                }
            }
        }
    }

    /// The layers with a point nearer to a box than its nearest found.
    #[inline(always)]
    fn gains(&self, low: [f32; 3], high: [f32; 3]) -> [bool; SIDE] {
        let outside = |p: f32, axis: usize| {
            let (before, behind) = (low[axis] - p, p - high[axis]);
            let farther = if before > behind { before } else { behind };
            if farther > 0.0 { farther * farther } else { 0.0 }
        };
        let mut flat = [0.0; LANES];
        for lane in 0..LANES {
            flat[lane] = outside(self.x[lane], 0) + outside(self.y[lane], 1);
        }
        let mut gains = [false; SIDE];
        for layer in 0..SIDE {
            let z = outside(self.z(layer), 2);
            let mut any = false;
            for lane in 0..LANES {
                any |= flat[lane] + z < self.d2[layer][lane];
            }
            gains[layer] = any;
        }
        gains
    }

    /// Largest squared distance.
    #[inline(always)]
    fn farthest(&self) -> f32 {
        let mut most = [0.0f32; LANES];
        for layer in &self.d2 {
            for lane in 0..LANES {
                most[lane] = if layer[lane] > most[lane] { layer[lane] } else { most[lane] };
            }
        }
        let mut width = LANES / 2;
        while width > 0 {
            for lane in 0..width {
                most[lane] = if most[lane + width] > most[lane] { most[lane + width] } else { most[lane] };
            }
            width /= 2;
        }
        most[0]
    }

    /// Height of a layer.
    #[inline(always)]
    fn z(&self, layer: usize) -> f32 {
        self.low.z + self.spacing * layer as f32
    }

    /// Updates `points` where something has been found since the last call; `of` gives the surface point of an id and a query point.
    #[inline(always)]
    pub(super) fn take(&mut self, points: &mut Points, of: impl Fn(u32, Vec3) -> Vec3) {
        for layer in 0..SIDE {
            for lane in 0..LANES {
                let id = std::mem::replace(&mut self.id[layer][lane], NONE);
                if id != NONE {
                    points[layer][lane] = of(id, Vec3::new(self.x[lane], self.y[lane], self.z(layer)));
                }
            }
        }
    }
}
