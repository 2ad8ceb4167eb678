//! The nearest triangles of a block of points, found together.
//!
//! Invariant: a squared distance only falls, and once every box that some point could still gain from has been opened it
//! is that of the nearest triangle. The points of a block meet nearly the same boxes, so the tree is walked once for all
//! of them; what is opened is then measured lane by lane, for the layers of the block that can gain.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays become vectors")]

use super::bvh::{Bvh, WIDTH};
use super::face::{LANES, Lanes};
use glam::{Vec3, Vec4};

/// Points along a side of a block. A layer of them fills the lanes.
pub(super) const SIDE: usize = 4;

/// What is nearest to a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Squared distance to `point`.
    pub d2: f32,
    /// A point of the surface.
    pub point: Vec3,
}

impl Hit {
    /// Nothing found yet.
    pub(super) const NONE: Hit = Hit { d2: f32::INFINITY, point: Vec3::INFINITY };
}

/// A cube of points and what is nearest to each: layers of constant z, in them x fastest.
pub(super) struct Block {
    low: Vec3,
    spacing: f32,
    x: Lanes,
    y: Lanes,
    /// Squared distances: upper bounds before a search. A point of distance 0 is not searched for.
    pub(super) d2: [Lanes; SIDE],
    /// Names of what has been found since the points were taken.
    id: [[u32; LANES]; SIDE],
}

/// A point of the surface for each point of a block.
pub(super) type Points = [[Vec3; LANES]; SIDE];

/// Not the name of a triangle.
const NONE: u32 = u32::MAX;

/// A box of the tree that waits: the level that it is a node of, its index there, its squared distance to the block.
type Waiting = (u32, u32, f32);

impl Block {
    /// A block of points that know nothing, `spacing` apart.
    #[inline(always)]
    pub(super) fn new(low: Vec3, spacing: f32) -> Block {
        let x = std::array::from_fn(|lane| low.x + spacing * (lane % SIDE) as f32);
        let y = std::array::from_fn(|lane| low.y + spacing * (lane / SIDE) as f32);
        Block { low, spacing, x, y, d2: [[f32::INFINITY; LANES]; SIDE], id: [[NONE; LANES]; SIDE] }
    }

    /// Takes over a point of the surface where it is nearer, under the name `id`.
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

    /// Finds what is nearer among the triangles of a tree.
    #[inline(always)]
    pub(super) fn search(&mut self, bvh: &Bvh) {
        if bvh.triangles() == 0 {
            return;
        }
        let levels = bvh.levels();
        let high = self.low + self.spacing * (SIDE - 1) as f32;
        let (low, high) = (self.low.to_array().map(Vec4::splat), high.to_array().map(Vec4::splat));
        // At most three siblings wait on each level, and 4^16 triangles need 16 levels.
        let mut stack: [Waiting; 3 * 16 + WIDTH] = [(0, 0, 0.0); 3 * 16 + WIDTH];
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
                    // Nearest on top: insertion keeps the new entries in falling order.
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

    /// Measures the triangles of a packet for some layers.
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

    /// The layers in which some point is nearer to a box than to all that is known.
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

    /// Puts into `points` what has been found since this was called last: `of` makes points of names and of the points
    /// that they are nearest to.
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
