//! How often a surface winds around a point.
//!
//! Invariant: all lengths are in voxel units. The winding number of a closed, outward surface is 1 inside and 0
//! outside; of an open one it varies smoothly between, and its level 1/2 closes the holes as a soap film would.
//! Source: Jacobson et al. 2013 (the generalized winding number); Barill et al. 2018 (the tree: an expansion to first
//! order about the area-weighted center of each node, here with their second term); van Oosterom & Strackee 1983.

use super::bvh::{Bvh, WIDTH};
use glam::{Mat3, Vec3};
use rayon::prelude::*;
use std::f32::consts::PI;

/// A node is expanded when it is farther than this many radii. 2 is Barill's choice: errors of the sum stay below
/// about 0.01. Smaller: the level 1/2 in a hole becomes rough. Larger: 3 costs twice the time.
const FAR: f32 = 2.0;

/// Sums over the triangles of a node.
#[derive(Clone, Copy, Default)]
struct Moment {
    area: f32,
    center: Vec3,
    radius: f32,
    /// Sum of area vectors.
    normal: Vec3,
    /// Sum of area vector (row) times offset from the center (column).
    tensor: Mat3,
    min: Vec3,
    max: Vec3,
}

/// Evaluates the winding number of the triangles of a [`Bvh`].
pub(super) struct Winding<'a> {
    bvh: &'a Bvh,
    /// One per packet, then one per group of four of the level before.
    levels: Vec<Vec<Moment>>,
}

impl<'a> Winding<'a> {
    /// Gathers the moments of every node.
    pub(super) fn new(bvh: &'a Bvh) -> Winding<'a> {
        let mut levels =
            vec![(0..bvh.packets()).into_par_iter().map(|i| Moment::of_packet(bvh, i)).collect::<Vec<_>>()];
        while levels[levels.len() - 1].len() > 1 {
            let parents = levels[levels.len() - 1].par_chunks(WIDTH).map(Moment::of_children).collect();
            levels.push(parents);
        }
        Winding { bvh, levels }
    }

    /// Winding number around `q`: error about 0.01; on a triangle it is one of the values of its two sides.
    pub(super) fn at(&self, q: Vec3) -> f32 {
        if self.bvh.triangles() == 0 {
            return 0.0;
        }
        let mut stack = [(0u32, 0u32); 3 * 16 + WIDTH];
        let mut top = 1;
        stack[0] = (self.levels.len() as u32 - 1, 0);
        let mut sum = 0.0;
        while top > 0 {
            top -= 1;
            let (level, index) = stack[top];
            let moment = &self.levels[level as usize][index as usize];
            let to = moment.center - q;
            let r2 = to.length_squared();
            if r2 > (FAR * FAR) * moment.radius * moment.radius {
                let r3 = r2 * r2.sqrt();
                let trace = moment.tensor.x_axis.x + moment.tensor.y_axis.y + moment.tensor.z_axis.z;
                let second = trace - 3.0 * to.dot(moment.tensor * to) / r2;
                sum += (moment.normal.dot(to) + second) / r3;
            } else if level == 0 {
                sum += self.bvh.packet(index as usize).map(|(a, ab, ac)| solid_angle(a - q, ab, ac)).sum::<f32>();
            } else {
                let children = self.levels[level as usize - 1].len() as u32;
                let first = index * WIDTH as u32;
                for child in first..children.min(first + WIDTH as u32) {
                    stack[top] = (level - 1, child);
                    top += 1;
                }
            }
        }
        sum / (4.0 * PI)
    }
}

/// A point is inside where the surface winds around it at least half a turn, whichever way the surface is wound.
pub(super) fn inside(winding: f32) -> bool {
    winding.abs() >= 0.5
}

impl Moment {
    fn of_packet(bvh: &Bvh, packet: usize) -> Moment {
        let mut m = Moment { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY, ..Moment::default() };
        let mut weighted = Vec3::ZERO;
        for (a, ab, ac) in bvh.packet(packet) {
            let normal = 0.5 * ab.cross(ac);
            m.area += normal.length();
            m.normal += normal;
            weighted += normal.length() * (a + (ab + ac) / 3.0);
            for p in [a, a + ab, a + ac] {
                (m.min, m.max) = (m.min.min(p), m.max.max(p));
            }
        }
        m.center = if m.area > 0.0 { weighted / m.area } else { 0.5 * (m.min + m.max) };
        for (a, ab, ac) in bvh.packet(packet) {
            m.tensor += outer(0.5 * ab.cross(ac), a + (ab + ac) / 3.0 - m.center);
            for p in [a, a + ab, a + ac] {
                m.radius = m.radius.max(p.distance(m.center));
            }
        }
        m
    }

    fn of_children(children: &[Moment]) -> Moment {
        let mut m = Moment { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY, ..Moment::default() };
        let mut weighted = Vec3::ZERO;
        for child in children {
            m.area += child.area;
            m.normal += child.normal;
            weighted += child.area * child.center;
            (m.min, m.max) = (m.min.min(child.min), m.max.max(child.max));
        }
        m.center = if m.area > 0.0 { weighted / m.area } else { 0.5 * (m.min + m.max) };
        let mut spheres = 0.0f32;
        for child in children {
            let offset = child.center - m.center;
            m.tensor += child.tensor + outer(child.normal, offset);
            spheres = spheres.max(offset.length() + child.radius);
        }
        let farthest = (m.center - m.min).max(m.max - m.center);
        m.radius = spheres.min(farthest.length());
        m
    }
}

/// Matrix with element (row i, column j) = `row[i] * column[j]`.
fn outer(row: Vec3, column: Vec3) -> Mat3 {
    Mat3::from_cols(row * column.x, row * column.y, row * column.z)
}

/// Signed solid angle of a triangle seen from the origin, positive when its inner side faces the origin.
fn solid_angle(a: Vec3, ab: Vec3, ac: Vec3) -> f32 {
    let (b, c) = (a + ab, a + ac);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let volume = a.dot(ab.cross(ac));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * volume.atan2(denominator)
}
