//! The nearest point of a set of triangles.
//!
//! Invariant: everything is in voxel units (the grid's first sample is the origin, neighbors are 1 apart), so that
//! squares and areas stay far from the limits of f32 whatever the world units are.
//! Four boxes or four triangles are tested at once, one per lane of a [`Vec4`]; the tree is complete and has no
//! pointers: node `i` of a level has the children `4 i .. 4 i + 4` of the level below.

use super::tetra::Triangle;
use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

/// Width of the tree and of a packet of triangles: the lanes of a [`Vec4`].
pub(super) const WIDTH: usize = 4;
/// Smaller: more time in starting tasks than in sorting. Larger: idle threads on small meshes.
const PARALLEL: usize = 8192;

/// A tree of boxes over triangles.
pub(super) struct Bvh {
    packets: Vec<Packet>,
    /// Level 0 bounds packets; the last level is the root, one node.
    levels: Vec<Vec<Node>>,
    triangles: usize,
}

/// The nearest point found so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Squared distance to `point`.
    pub d2: f32,
    /// A point of the surface.
    pub point: Vec3,
}

/// Boxes of four children; a missing child has an inverted, infinite box.
struct Node {
    min: [Vec4; 3],
    max: [Vec4; 3],
}

/// Four triangles, one per lane; lanes past the last triangle repeat it.
struct Packet {
    a: [Vec4; 3],
    ab: [Vec4; 3],
    ac: [Vec4; 3],
    /// Unit normal, computed in f64: the normal of a needle would otherwise be off by its length over its width.
    /// Zero for a triangle without area, which then is its three edges.
    normal: [Vec4; 3],
    /// 1 / squared length of ab, ac and bc; 0 for an edge without length, which then is its first end.
    inverse: [Vec4; 3],
}

impl Hit {
    /// Nothing found yet.
    pub(super) const NONE: Hit = Hit { d2: f32::INFINITY, point: Vec3::INFINITY };

    /// The nearer of this and a known point of the surface.
    pub(super) fn or_point(self, p: Vec3, point: Vec3) -> Hit {
        let d2 = p.distance_squared(point);
        if d2 < self.d2 { Hit { d2, point } } else { self }
    }
}

impl Bvh {
    /// Tree over triangles in voxel units. Degenerate triangles are edges or points.
    pub(super) fn new(triangles: &[Triangle]) -> Bvh {
        let centers: Vec<Vec3> = triangles.par_iter().map(|t| (t[0] + t[1] + t[2]) / 3.0).collect();
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        arrange(&mut order, &centers);
        drop(centers);
        let packets: Vec<Packet> = order.par_chunks(WIDTH).map(|chunk| Packet::new(chunk, triangles)).collect();
        let boxes = order.par_chunks(WIDTH).map(|chunk| {
            let corners = chunk.iter().flat_map(|&t| triangles[t as usize]);
            corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p)))
        });
        let mut boxes: Vec<(Vec3, Vec3)> = boxes.collect();
        let mut levels = Vec::new();
        loop {
            let level: Vec<Node> = boxes.par_chunks(WIDTH).map(Node::new).collect();
            boxes = level.par_iter().map(Node::union).collect();
            let root = level.len() <= 1;
            levels.push(level);
            if root {
                return Bvh { packets, levels, triangles: triangles.len() };
            }
        }
    }

    /// The nearest point of the triangles to `p` if it is nearer than `best`, else `best`.
    pub(super) fn closest(&self, p: Vec3, best: Hit) -> Hit {
        if self.triangles == 0 {
            return best;
        }
        let lanes = [Vec4::splat(p.x), Vec4::splat(p.y), Vec4::splat(p.z)];
        // At most three siblings wait on each level, and 4^16 triangles need 16 levels.
        let mut stack = [(0u32, 0u32, 0.0f32); 3 * 16 + WIDTH];
        let mut top = 1;
        stack[0] = (self.levels.len() as u32, 0, 0.0);
        let (mut d2, mut winner) = (best.d2, None);
        while top > 0 {
            top -= 1;
            let (level, index, bound) = stack[top];
            if bound >= d2 {
                continue;
            }
            if level == 0 {
                let found = self.packets[index as usize].distance2(&lanes);
                let nearest = found.min_element();
                if nearest < d2 {
                    d2 = nearest;
                    winner = Some((index as usize, found.min_position()));
                }
                continue;
            }
            let bounds = self.levels[level as usize - 1][index as usize].distance2(&lanes).to_array();
            let first = top;
            for (lane, &bound) in bounds.iter().enumerate() {
                if bound < d2 {
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
        match winner {
            Some((packet, lane)) => Hit { d2, point: self.packets[packet].closest_point(lane, p) },
            None => best,
        }
    }

    /// Triangles in the tree.
    pub(super) fn triangles(&self) -> usize {
        self.triangles
    }

    /// Packets of [`WIDTH`] triangles, in the tree's order; only the last may hold fewer.
    pub(super) fn packets(&self) -> usize {
        self.packets.len()
    }

    /// First corner and the two edges from it of the triangles of a packet.
    pub(super) fn packet(&self, packet: usize) -> impl Iterator<Item = (Vec3, Vec3, Vec3)> + '_ {
        let count = WIDTH.min(self.triangles - packet * WIDTH);
        let packet = &self.packets[packet];
        (0..count).map(move |lane| (take(&packet.a, lane), take(&packet.ab, lane), take(&packet.ac, lane)))
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

    fn distance2(&self, p: &[Vec4; 3]) -> Vec4 {
        let axis = |i: usize| {
            let d = (self.min[i] - p[i]).max(p[i] - self.max[i]).max(Vec4::ZERO);
            d * d
        };
        axis(0) + axis(1) + axis(2)
    }
}

impl Packet {
    fn new(members: &[u32], triangles: &[Triangle]) -> Packet {
        let member = |lane: usize| triangles[members[lane.min(members.len() - 1)] as usize];
        let inverse = |v: Vec3| {
            let squared = v.length_squared();
            if squared > f32::MIN_POSITIVE { squared.recip() } else { 0.0 }
        };
        Packet {
            a: pack(|i| member(i)[0]),
            ab: pack(|i| member(i)[1] - member(i)[0]),
            ac: pack(|i| member(i)[2] - member(i)[0]),
            normal: pack(|i| {
                let [a, b, c] = member(i).map(Vec3::as_dvec3);
                (b - a).cross(c - a).try_normalize().unwrap_or(DVec3::ZERO).as_vec3()
            }),
            inverse: pack(|i| {
                let [a, b, c] = member(i);
                Vec3::new(inverse(b - a), inverse(c - a), inverse(c - b))
            }),
        }
    }

    /// Squared distances to the four triangles: to the plane where the foot point is inside, else to the edges.
    fn distance2(&self, p: &[Vec4; 3]) -> Vec4 {
        let ap = sub(p, &self.a);
        let bp = sub(&ap, &self.ab);
        let bc = sub(&self.ac, &self.ab);
        let edges = edge(&ap, &self.ab, self.inverse[0]).min(edge(&ap, &self.ac, self.inverse[1])).min(edge(
            &bp,
            &bc,
            self.inverse[2],
        ));
        let plane = dot(&self.normal, &ap);
        let left_of = |edge: &[Vec4; 3], to: &[Vec4; 3]| dot(&cross(edge, to), &self.normal);
        let inside = left_of(&self.ab, &ap).cmpgt(Vec4::ZERO)
            & left_of(&bc, &bp).cmpgt(Vec4::ZERO)
            & left_of(&self.ac, &ap).cmplt(Vec4::ZERO);
        Vec4::select(inside, plane * plane, edges)
    }

    fn closest_point(&self, lane: usize, p: Vec3) -> Vec3 {
        let (a, ab, ac) = (take(&self.a, lane), take(&self.ab, lane), take(&self.ac, lane));
        let (normal, inverse) = (take(&self.normal, lane), take(&self.inverse, lane));
        let (ap, bc) = (p - a, ac - ab);
        let bp = ap - ab;
        if ab.cross(ap).dot(normal) > 0.0 && bc.cross(bp).dot(normal) > 0.0 && ac.cross(ap).dot(normal) < 0.0 {
            return p - normal * normal.dot(ap);
        }
        let on =
            |start: Vec3, edge: Vec3, inverse: f32| start + edge * ((p - start).dot(edge) * inverse).clamp(0.0, 1.0);
        let points = [on(a, ab, inverse.x), on(a, ac, inverse.y), on(a + ab, bc, inverse.z)];
        points.into_iter().fold(Hit::NONE, |hit, point| hit.or_point(p, point)).point
    }
}

/// Sorts `order` so that the complete tree over consecutive groups has compact boxes: halves along the longest side,
/// cut at multiples of the size of a full subtree.
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

fn take(lanes: &[Vec4; 3], lane: usize) -> Vec3 {
    Vec3::from_array(lanes.map(|v| v[lane]))
}

fn sub(a: &[Vec4; 3], b: &[Vec4; 3]) -> [Vec4; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: &[Vec4; 3], b: &[Vec4; 3]) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: &[Vec4; 3], b: &[Vec4; 3]) -> [Vec4; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Squared distance to a segment from its start, given the vector from the start to the point.
fn edge(to: &[Vec4; 3], edge: &[Vec4; 3], inverse: Vec4) -> Vec4 {
    let t = (dot(to, edge) * inverse).max(Vec4::ZERO).min(Vec4::ONE);
    let off = [to[0] - edge[0] * t, to[1] - edge[1] * t, to[2] - edge[2] * t];
    dot(&off, &off)
}
