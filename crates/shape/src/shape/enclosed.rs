//! Volume enclosed by a mesh.
//!
//! Role: sums the contributions of connected components. Invariant: inside is as in the distance field: points with a winding
//! number of at least one half, in either direction.

use super::mesh::Components;
use super::orientation::OrientedMesh;
use super::{Bounds, Mesh};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::PI;

/// Relative volume, to area times longest side, below which a mesh is flat: the rounding of f32 coordinates.
const FLAT: f64 = 1e-6;
/// Most components tested against each other.
const MAX_BODIES: usize = 4096;
/// Most triangles in these tests.
const MAX_TRIANGLES_SEEN: usize = 20_000_000;

/// Solid enclosed by a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enclosed {
    /// Cubic world units. An estimate for an open mesh; the overlap of crossing components counts twice.
    pub volume: f64,
    /// Number of duplicate triangles, which count once.
    pub repeated: usize,
    /// Whether the inside is empty: faces cancel, or lie in a plane.
    pub is_nothing: bool,
}

/// Connected component.
struct Body<'a> {
    triangles: Vec<[DVec3; 3]>,
    volume: f64,
    bounds: Bounds,
    point: &'a Vec3,
}

impl Mesh {
    /// Message about a mesh without an inside.
    pub const ENCLOSES_NOTHING: &str =
        "it encloses nothing, its faces cancel or lie in a plane: a shell gives it a thickness (--shell)";

    /// Enclosed solid, after duplicate triangles are dropped and inconsistent ones reversed.
    pub fn enclosed(&self) -> Enclosed {
        let (oriented, bounds) = (self.oriented(), self.bounds());
        let is_closed = oriented.uses.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).all(|edge| edge.len() > 1);
        let bodies = bodies(&oriented, bounds.center().as_dvec3());
        let seen = |body: &Body| -> usize {
            bodies.iter().filter(|other| other.holds(body)).map(|other| other.triangles.len()).sum()
        };
        let is_few = is_closed && bodies.len() <= MAX_BODIES;
        let volume: f64 = if is_few && bodies.par_iter().map(seen).sum::<usize>() <= MAX_TRIANGLES_SEEN {
            bodies.par_iter().map(|body| body.adds(&bodies)).sum()
        } else {
            bodies.iter().map(|body| body.volume).sum()
        };
        let area: f64 =
            bodies.iter().flat_map(|body| &body.triangles).map(|[a, b, c]| (b - a).cross(c - a).length()).sum();
        let is_nothing = volume.abs() <= FLAT * area * f64::from(bounds.size().max_element());
        Enclosed { volume: if is_nothing { 0.0 } else { volume.abs() }, repeated: oriented.repeated, is_nothing }
    }
}

/// Components of a mesh; volumes are relative to `origin`.
fn bodies(oriented: &OrientedMesh, origin: DVec3) -> Vec<Body<'_>> {
    let mut roots = Components::of(&oriented.triangles, oriented.places.len());
    let (mut numbers, mut bodies) = (HashMap::new(), Vec::<Body>::new());
    for triangle in &oriented.triangles {
        let point = &oriented.places[triangle[0] as usize];
        let number = *numbers.entry(roots.root(triangle[0])).or_insert_with(|| {
            let bounds = Bounds { min: *point, max: *point };
            bodies.push(Body { triangles: Vec::new(), volume: 0.0, bounds, point });
            bodies.len() - 1
        });
        let body = &mut bodies[number];
        let corners = triangle.map(|corner| oriented.places[corner as usize]);
        for corner in corners {
            (body.bounds.min, body.bounds.max) = (body.bounds.min.min(corner), body.bounds.max.max(corner));
        }
        let [a, b, c] = corners.map(|corner| corner.as_dvec3() - origin);
        body.volume += a.dot(b.cross(c)) / 6.0;
        body.triangles.push(corners.map(Vec3::as_dvec3));
    }
    bodies
}

impl Body<'_> {
    /// Whether another component may lie inside of this one.
    fn holds(&self, other: &Body) -> bool {
        let Bounds { min, max } = self.bounds;
        !std::ptr::eq(self, other) && min.cmple(*other.point).all() && max.cmpge(*other.point).all()
    }

    /// Contribution to the volume of the solid among all components.
    fn adds(&self, all: &[Body]) -> f64 {
        let around: f64 =
            all.iter().filter(|other| other.holds(self)).map(|other| other.turns(self.point.as_dvec3())).sum();
        let is_inside = |turns: f64| f64::from(u8::from(turns.abs() >= 0.5));
        self.volume.abs() * (is_inside(around + self.volume.signum()) - is_inside(around))
    }

    /// Winding number around `p`. Source: van Oosterom & Strackee 1983.
    fn turns(&self, p: DVec3) -> f64 {
        let angle = |corners: &[DVec3; 3]| {
            let [a, b, c] = corners.map(|corner| corner - p);
            let (x, y, z) = (a.length(), b.length(), c.length());
            a.dot(b.cross(c)).atan2(x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y)
        };
        (self.triangles.iter().map(angle).sum::<f64>() / (2.0 * PI)).round()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box from `low` to `high`.
    fn cuboid(low: Vec3, high: Vec3) -> Mesh {
        let corner = |i: u32| Vec3::select(glam::BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), high, low);
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Mesh { positions: (0..8).map(corner).collect(), triangles, ..Mesh::default() }
    }

    fn joined(parts: &[Mesh]) -> Mesh {
        let mut all = Mesh::default();
        for part in parts {
            let first = all.positions.len() as u32;
            all.positions.extend(&part.positions);
            all.triangles.extend(part.triangles.iter().map(|t| t.map(|corner| first + corner)));
        }
        all
    }

    fn turned(mut mesh: Mesh) -> Mesh {
        mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        mesh
    }

    /// A box of volume 1 far from the origin.
    fn unit() -> Mesh {
        cuboid(Vec3::new(7.0, -3.0, 2.0), Vec3::new(9.0, -2.0, 2.5))
    }

    #[test]
    fn faces_turned_over_or_there_twice_change_no_volume() {
        for changed in 1..1 << 6 {
            let (mut flipped, mut twice, mut both_ways) = (unit(), unit(), unit());
            for at in (0..12).filter(|at| changed >> (at % 6) & 1 > 0) {
                let [a, b, c] = unit().triangles[at];
                flipped.triangles[at] = [a, c, b];
                twice.triangles.push([b, c, a]);
                both_ways.triangles.push([a, c, b]);
            }
            let repeated = twice.triangles.len() - 12;
            for (mesh, expected, repeated) in [(flipped, 1.0, 0), (twice, 1.0, repeated)] {
                let found = mesh.enclosed();
                assert!((found.volume - expected).abs() < 1e-9 && !found.is_nothing, "{changed:b} {found:?}");
                assert_eq!(found.repeated, repeated);
            }
            // A surface with two sides everywhere encloses nothing; a few faces with both are those of a solid.
            let found = both_ways.enclosed();
            assert_eq!(found.is_nothing, changed == 63, "{changed:b} {found:?}");
            assert!((found.volume - if changed == 63 { 0.0 } else { 1.0 }).abs() < 1e-9, "{changed:b} {found:?}");
        }
    }

    #[test]
    fn bodies_count_as_the_field_takes_them() {
        let big = || cuboid(Vec3::new(6.0, -4.0, 1.0), Vec3::new(10.0, -1.0, 4.0));
        let far = || cuboid(Vec3::splat(20.0), Vec3::splat(21.0));
        for (parts, expected) in [
            (vec![unit(), turned(far())], 2.0),
            (vec![turned(unit())], 1.0),
            (vec![big(), turned(unit())], 35.0),
            (vec![turned(big()), unit()], 35.0),
            (vec![unit(), big()], 36.0),
            (vec![far(), turned(big()), unit()], 36.0),
        ] {
            let volume = joined(&parts).enclosed().volume;
            assert!((volume - expected).abs() < 1e-9, "{volume} for {expected}");
        }
    }

    #[test]
    fn what_is_flat_encloses_nothing_at_any_scale() {
        for scale in [1e-15, 1e-6, 1.0, 1e6, 1e15] {
            let scaled = |mut mesh: Mesh| {
                mesh.positions.iter_mut().for_each(|position| *position *= scale);
                mesh.enclosed()
            };
            let plane = || {
                let mut plane = unit();
                plane.positions.iter_mut().for_each(|position| position.x = 0.3 * position.y + 1.7 * position.z);
                plane
            };
            let sheet = Mesh { triangles: unit().triangles[8..10].to_vec(), ..plane() };
            for mesh in [plane(), sheet.clone(), joined(&[sheet.clone(), turned(sheet)])] {
                assert!(scaled(mesh).is_nothing, "{scale}");
            }
            let (volume, cubic) = (scaled(unit()).volume, f64::from(scale).powi(3));
            assert!((volume / cubic - 1.0).abs() < 1e-5, "{scale}: {volume}");
        }
    }
}
