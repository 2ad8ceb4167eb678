//! Bounding volume hierarchy of triangles.
//!
//! Invariant: lengths are in voxels, so that squares and areas stay within f32 whatever the world units are.
//! The tree is complete and has no pointers: node `i` has the children `4 i .. 4 i + 4` of the level below; those of level 0
//! are packets of four triangles. Four boxes are tested at once, one per lane of a [`Vec4`].

use super::face::{Face, Frame};
use super::tetra::Triangle;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Children of a node and triangles of a packet: the lanes of a [`Vec4`].
pub(super) const WIDTH: usize = 4;
/// Triangles above which halves are sorted in parallel. Lower spends more time on tasks than on sorting; higher leaves threads idle
/// on small meshes.
const PARALLEL: usize = 8192;

/// Levels with oriented boxes. Lower measures more triangles in vain; higher gains nothing, since oriented boxes of many triangles
/// are as thick as aligned ones.
const FRAMES: u32 = 2;

/// Bounding volume hierarchy of triangles.
pub(super) struct Bvh {
    triangles: Vec<Triangle>,
    /// One for each triangle.
    faces: Vec<Face>,
    /// Oriented boxes of the packets, of the nodes of level 0, and so on for [`FRAMES`] levels.
    frames: Vec<Vec<Frame>>,
    /// Level 0 bounds packets; the last level is the root.
    levels: Vec<Vec<Node>>,
}

/// Boxes of four children, inverted and infinite for a missing child.
pub(super) struct Node {
    min: [Vec4; 3],
    max: [Vec4; 3],
}

impl Bvh {
    /// Builds the tree over triangles in voxel units.
    pub(super) fn new(triangles: &[Triangle]) -> Bvh {
        let centers: Vec<Vec3> = triangles.par_iter().map(|t| (t[0] + t[1] + t[2]) / 3.0).collect();
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        arrange(&mut order, &centers);
        drop(centers);
        let triangles: Vec<Triangle> = order.par_iter().map(|&t| triangles[t as usize]).collect();
        let faces = triangles.par_iter().map(Face::new).collect();
        let level = |level: u32| triangles.par_chunks(WIDTH.pow(level + 1)).map(Frame::around).collect();
        let frames = (0..FRAMES).map(level).collect();
        let boxes = triangles.par_chunks(WIDTH).map(|packet| {
            let corners = packet.iter().flatten();
            corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(*p), hi.max(*p)))
        });
        let mut boxes: Vec<(Vec3, Vec3)> = boxes.collect();
        let mut levels = Vec::new();
        loop {
            let level: Vec<Node> = boxes.par_chunks(WIDTH).map(Node::new).collect();
            boxes = level.par_iter().map(Node::union).collect();
            let root = level.len() <= 1;
            levels.push(level);
            if root {
                return Bvh { triangles, faces, frames, levels };
            }
        }
    }

    /// Number of triangles.
    pub(super) fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// Number of packets of [`WIDTH`] triangles. The last may hold fewer.
    pub(super) fn packets(&self) -> usize {
        self.triangles.len().div_ceil(WIDTH)
    }

    /// The triangles of a packet.
    #[inline(always)]
    pub(super) fn packet(&self, packet: usize) -> &[Triangle] {
        &self.triangles[packet * WIDTH..self.triangles.len().min((packet + 1) * WIDTH)]
    }

    /// Frames of the triangles, in the tree's order.
    pub(super) fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The oriented box of a packet (level 0) or of a node of the level below `level`; `None` for high levels.
    #[inline(always)]
    pub(super) fn frame(&self, level: usize, index: usize) -> Option<&Frame> {
        self.frames.get(level).map(|frames| &frames[index])
    }

    /// Levels of nodes, from those of packets to the root.
    pub(super) fn levels(&self) -> &[Vec<Node>] {
        &self.levels
    }
}

impl Node {
    fn new(children: &[(Vec3, Vec3)]) -> Node {
        let lane = |i: usize| children.get(i).copied().unwrap_or((Vec3::INFINITY, Vec3::NEG_INFINITY));
        Node { min: pack(|i| lane(i).0), max: pack(|i| lane(i).1) }
    }

    fn union(&self) -> (Vec3, Vec3) {
        (Vec3::from_array(self.min.map(|v| v.min_element())), Vec3::from_array(self.max.map(|v| v.max_element())))
    }

    /// Lower and upper corner of a child.
    #[inline(always)]
    pub(super) fn child(&self, lane: usize) -> ([f32; 3], [f32; 3]) {
        (self.min.map(|v| v[lane]), self.max.map(|v| v[lane]))
    }

    /// Squared distances of the children from a box, infinite for a missing child.
    #[inline(always)]
    pub(super) fn distance2(&self, low: &[Vec4; 3], high: &[Vec4; 3]) -> Vec4 {
        let axis = |i: usize| {
            let d = (self.min[i] - high[i]).max(low[i] - self.max[i]).max(Vec4::ZERO);
            d * d
        };
        axis(0) + axis(1) + axis(2)
    }
}

/// Sorts `order` for compact boxes of the complete tree: halves along the longest side, cut at multiples of a full subtree.
fn arrange(order: &mut [u32], centers: &[Vec3]) {
    if order.len() <= WIDTH {
        return;
    }
    let mut full = WIDTH;
    while full * WIDTH < order.len() {
        full *= WIDTH;
    }
    let middle = order.len().div_ceil(full).div_ceil(2) * full;
    let at = |t: u32| centers[t as usize];
    let bounds = order.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), &t| (lo.min(at(t)), hi.max(at(t))));
    let axis = (bounds.1 - bounds.0).max_position();
    let by_center = |a: &u32, b: &u32| at(*a)[axis].total_cmp(&at(*b)[axis]).then(a.cmp(b));
    order.select_nth_unstable_by(middle, by_center);
    let (left, right) = order.split_at_mut(middle);
    if left.len() > PARALLEL {
        rayon::join(|| arrange(left, centers), || arrange(right, centers));
    } else {
        arrange(left, centers);
        arrange(right, centers);
    }
}

fn pack(lane: impl Fn(usize) -> Vec3) -> [Vec4; 3] {
    let lanes: [Vec3; WIDTH] = std::array::from_fn(lane);
    std::array::from_fn(|axis| Vec4::from_array(lanes.map(|v| v[axis])))
}
