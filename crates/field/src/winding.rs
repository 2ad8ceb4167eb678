//! Generalized winding numbers.
//!
//! Invariant: lengths are in voxels. The winding number of a closed, outward surface is 1 inside and 0 outside; that of an open
//! one varies smoothly, and its level 1/2 closes holes like a soap film.
//! Sources: Jacobson et al. 2013; Barill et al. 2018 (tree with an expansion about the area-weighted center of each node, here
//! to their second term); van Oosterom & Strackee 1983 (solid angle).

use super::bvh::{Bvh, WIDTH};
use super::tetra::Triangle;
use glam::{Mat3, Vec3};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Distance in radii beyond which a node is approximated. 2 is Barill's choice, with errors of about 0.01. Lower roughens the
/// level 1/2 in holes; 3 takes twice the time.
const FAR: f32 = 2.0;

/// Multipole moments of the triangles of a node.
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

/// Points evaluated together. Lower leaves vectors of 8 lanes half empty; higher opens nodes for a few of them.
pub(super) const POINTS: usize = 8;
/// A value per point.
type Lanes = [f32; POINTS];

/// Evaluates the winding number of the triangles of a [`Bvh`].
pub(super) struct Winding<'a> {
    bvh: &'a Bvh,
    /// One moment per packet, then one per four of the level below.
    levels: Vec<Vec<Moment>>,
    /// Vector instructions of this processor.
    arch: pulp::Arch,
}

impl<'a> Winding<'a> {
    /// Computes the moments of every node.
    pub(super) fn new(bvh: &'a Bvh) -> Winding<'a> {
        let mut levels =
            vec![(0..bvh.packets()).into_par_iter().map(|i| Moment::of_packet(bvh, i)).collect::<Vec<_>>()];
        while levels[levels.len() - 1].len() > 1 {
            let parents = levels[levels.len() - 1].par_chunks(WIDTH).map(Moment::of_children).collect();
            levels.push(parents);
        }
        Winding { bvh, levels, arch: pulp::Arch::new() }
    }

    /// Winding number around `q`. The error is about 0.01, up to 0.03 in the middle of a ball, where the errors of all nodes have
    /// one sign. On a triangle it is that of either side.
    pub(super) fn at(&self, q: Vec3) -> f32 {
        self.around(&[q; POINTS])[0]
    }

    /// Winding numbers around several points. Close points cost little more than one: a node near any is opened for all.
    pub(super) fn around(&self, points: &[Vec3; POINTS]) -> [f32; POINTS] {
        self.around_counted(points).0
    }

    /// Winding numbers around several points, and the number of nodes and triangles visited.
    pub(super) fn around_counted(&self, points: &[Vec3; POINTS]) -> ([f32; POINTS], u64) {
        self.arch.dispatch(Around { winding: self, points: [0, 1, 2].map(|axis| points.map(|point| point[axis])) })
    }
}

/// Evaluation at some points.
struct Around<'a> {
    winding: &'a Winding<'a>,
    /// Coordinates by axis.
    points: [Lanes; 3],
}

impl pulp::NullaryFnOnce for Around<'_> {
    type Output = (Lanes, u64);

    #[inline(always)] // with all its callees, to be compiled for the vectors of this processor
    fn call(self) -> (Lanes, u64) {
        let Around { winding: Winding { bvh, levels, .. }, points } = self;
        let (mut sum, mut visits) = ([0.0; POINTS], 0);
        if bvh.triangles() == 0 {
            return (sum, visits);
        }
        let mut stack = [(0u32, 0u32); 3 * 16 + WIDTH];
        let mut top = 1;
        stack[0] = (levels.len() as u32 - 1, 0);
        while top > 0 {
            top -= 1;
            visits += 1;
            let (level, index) = stack[top];
            let moment = &levels[level as usize][index as usize];
            let (to, near) = moment.seen_from(&points);
            if near == 0 {
                moment.add(&to, &mut sum);
            } else if level == 0 {
                visits += WIDTH as u64;
                for triangle in bvh.packet(index as usize) {
                    add_solid_angles(triangle, &points, &mut sum);
                }
            } else {
                let children = levels[level as usize - 1].len() as u32;
                let first = index * WIDTH as u32;
                for child in first..children.min(first + WIDTH as u32) {
                    stack[top] = (level - 1, child);
                    top += 1;
                }
            }
        }
        (sum.map(|sum| sum / (4.0 * PI)), visits)
    }
}

/// Whether a winding number means inside, for a surface wound either way.
pub(super) fn inside(winding: f32) -> bool {
    winding.abs() >= 0.5
}

impl Moment {
    /// Offset and squared distance from each point, and the number of points too near for the expansion.
    #[inline(always)]
    fn seen_from(&self, points: &[Lanes; 3]) -> ([Lanes; 4], u32) {
        let (mut to, mut near) = ([[0.0; POINTS]; 4], 0);
        let limit = (FAR * FAR) * self.radius * self.radius;
        for p in 0..POINTS {
            let [x, y, z] = [self.center.x - points[0][p], self.center.y - points[1][p], self.center.z - points[2][p]];
            let r2 = x * x + y * y + z * z;
            (to[0][p], to[1][p], to[2][p], to[3][p]) = (x, y, z, r2);
            near += u32::from(r2 <= limit);
        }
        (to, near)
    }

    /// Adds the solid angle by its expansion, from offsets and squared distances.
    #[inline(always)]
    fn add(&self, to: &[Lanes; 4], sum: &mut Lanes) {
        let [a, b, c] = [self.tensor.x_axis, self.tensor.y_axis, self.tensor.z_axis];
        let trace = a.x + b.y + c.z;
        for p in 0..POINTS {
            let [x, y, z, r2] = [to[0][p], to[1][p], to[2][p], to[3][p]];
            let r3 = r2 * r2.sqrt();
            let product = x * (a.x * x + b.x * y + c.x * z)
                + y * (a.y * x + b.y * y + c.y * z)
                + z * (a.z * x + b.z * y + c.z * z);
            let second = trace - 3.0 * product / r2;
            sum[p] += (self.normal.x * x + self.normal.y * y + self.normal.z * z + second) / r3;
        }
    }

    fn of_packet(bvh: &Bvh, packet: usize) -> Moment {
        let mut m = Moment { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY, ..Moment::default() };
        let mut weighted = Vec3::ZERO;
        for &[a, b, c] in bvh.packet(packet) {
            let normal = 0.5 * (b - a).cross(c - a);
            m.area += normal.length();
            m.normal += normal;
            weighted += normal.length() * (a + b + c) / 3.0;
            for p in [a, b, c] {
                (m.min, m.max) = (m.min.min(p), m.max.max(p));
            }
        }
        m.center = if m.area > 0.0 { weighted / m.area } else { 0.5 * (m.min + m.max) };
        for &[a, b, c] in bvh.packet(packet) {
            m.tensor += outer(0.5 * (b - a).cross(c - a), (a + b + c) / 3.0 - m.center);
            for p in [a, b, c] {
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

/// Adds the signed solid angle of a triangle seen from each point, positive when its inner side faces the point.
#[inline(always)]
fn add_solid_angles([corner, b, c]: &Triangle, points: &[Lanes; 3], sum: &mut Lanes) {
    let (ab, ac) = (*b - *corner, *c - *corner);
    let normal = ab.cross(ac);
    let (ab, ac) = (ab.to_array(), ac.to_array());
    let mut angles = [0.0; POINTS];
    for p in 0..POINTS {
        let a = [corner.x - points[0][p], corner.y - points[1][p], corner.z - points[2][p]];
        let b = [a[0] + ab[0], a[1] + ab[1], a[2] + ab[2]];
        let c = [a[0] + ac[0], a[1] + ac[1], a[2] + ac[2]];
        let dot = |u: [f32; 3], v: [f32; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
        let (la, lb, lc) = (dot(a, a).sqrt(), dot(b, b).sqrt(), dot(c, c).sqrt());
        let volume = dot(a, normal.to_array());
        let denominator = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
        angles[p] = 2.0 * atan2(volume, denominator);
    }
    for p in 0..POINTS {
        sum[p] += angles[p];
    }
}

/// Vectorizable `atan2` with an error of at most 2.5e-6; 0 at the origin.
/// Source: Hastings 1955, polynomial of degree 11 for the arctangent, error 1.7e-6.
#[inline(always)]
fn atan2(y: f32, x: f32) -> f32 {
    const C: [f32; 6] = [0.999_977_26, -0.332_623_47, 0.193_543_46, -0.116_432_87, 0.052_653_32, -0.011_721_2];
    let (ax, ay) = (x.abs(), y.abs());
    let (small, large) = if ax < ay { (ax, ay) } else { (ay, ax) };
    let part = small / if large > 0.0 { large } else { 1.0 };
    let s = part * part;
    let near = part * (C[0] + s * (C[1] + s * (C[2] + s * (C[3] + s * (C[4] + s * C[5])))));
    let first = if ax < ay { 0.5 * PI - near } else { near };
    let half = if x < 0.0 { PI - first } else { first };
    if y < 0.0 { -half } else { half }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_f64() {
        for k in 0..100_000 {
            let angle = std::f64::consts::PI * (f64::from(k) / 50_000.0 - 1.0);
            for r in [1e-6, 1.0, 1e6] {
                let (y, x) = ((r * angle.sin()) as f32, (r * angle.cos()) as f32);
                let error = f64::from(atan2(y, x)) - f64::from(y).atan2(f64::from(x));
                assert!(error.abs() < 2.5e-6, "{y} {x}: {error}");
            }
        }
        assert_eq!(atan2(0.0, 0.0), 0.0);
    }

    /// A ball of triangles around the origin.
    fn ball(radius: f32) -> Vec<Triangle> {
        let at = |i: u32, j: u32| {
            let (a, b) = (PI * i as f32 / 24.0, PI * j as f32 / 24.0);
            radius * Vec3::new(a.sin() * b.cos(), a.sin() * b.sin(), a.cos())
        };
        let quads = (0..24).flat_map(|i| (0..48).map(move |j| (i, j)));
        quads
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect()
    }

    #[test]
    fn batched_winding_numbers_equal_single_ones_and_a_ball_has_1() {
        let bvh = Bvh::new(&ball(10.0));
        let winding = Winding::new(&bvh);
        let points = [0.0, 3.0, 9.8, 10.2, 11.0, 15.0, 40.0, 900.0].map(|x| Vec3::new(x, 0.1, 0.2));
        let together = winding.around(&points);
        for (point, number) in points.into_iter().zip(together) {
            let expected = f32::from(u8::from(point.length() < 10.0));
            assert!((number - expected).abs() < 0.04, "{point}: {number}");
            assert!((number - winding.at(point)).abs() < 0.04, "{point}: {number}");
        }
    }
}
