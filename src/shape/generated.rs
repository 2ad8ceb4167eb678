//! Objects made by code.
//!
//! Role: a name of [`BUILT_IN`] into a shape. Invariant: every mesh is closed, but the teapot, which is open and crosses
//! itself as it always did, and every mesh is wound counterclockwise seen from outside. y is up.

use super::teapot::teapot;
use super::{Mesh, Shape, Solid, phantom};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Names of the objects made by code, in the order in which they are listed.
pub const BUILT_IN: &[&str] = &["sphere", "cube", "torus", "dodecahedron", "pawn", "teapot", "knot", "head"];

/// The object of that name; `None` for a name that is not in [`BUILT_IN`].
pub(super) fn built_in(name: &str) -> Option<Shape> {
    Some(match name {
        "sphere" => Shape::Solid(Solid::Sphere { radius: 1.0 }),
        "cube" => Shape::Solid(Solid::Cube { half: 0.8 }),
        "torus" => Shape::Solid(Solid::Torus { major: 0.7, minor: 0.3 }),
        "dodecahedron" => Shape::Mesh(dodecahedron()),
        "pawn" => Shape::Mesh(revolve(&pawn_profile(), 96)),
        "teapot" => Shape::Mesh(teapot()),
        "knot" => Shape::Mesh(knot()),
        "head" => Shape::Volume(phantom::head()),
        _ => return None,
    })
}

/// The regular dodecahedron with vertices at distance 1 from the origin: 12 pentagons, each a fan of three triangles.
fn dodecahedron() -> Mesh {
    let golden = 0.5 * (1.0 + 5f32.sqrt());
    let mut vertices = Vec::new();
    for (a, b) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        vertices.extend([Vec3::new(a, b, -1.0), Vec3::new(a, b, 1.0)]);
        let (near, far) = (a / golden, b * golden);
        vertices.extend([Vec3::new(0.0, near, far), Vec3::new(near, far, 0.0), Vec3::new(far, 0.0, near)]);
    }
    let mut corners = Vec::new();
    for (a, b) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let (near, far) = (a, b * golden);
        for normal in [Vec3::new(0.0, far, near), Vec3::new(far, near, 0.0), Vec3::new(near, 0.0, far)] {
            let mut face: Vec<Vec3> = vertices.clone();
            face.sort_by(|p, q| q.dot(normal).total_cmp(&p.dot(normal)));
            face.truncate(5);
            let (center, first) = (face.iter().sum::<Vec3>() / 5.0, face[0]);
            let side = normal.cross(first - center).normalize();
            let along = (first - center).normalize();
            let angle = |p: &Vec3| (*p - center).dot(side).atan2((*p - center).dot(along)).rem_euclid(TAU - 1e-4);
            face.sort_by(|p, q| angle(p).total_cmp(&angle(q)));
            corners.extend([[0, 1, 2], [0, 2, 3], [0, 3, 4]].iter().flatten().map(|&i: &usize| face[i] / 3f32.sqrt()));
        }
    }
    Mesh::of_corners(&corners).0
}

/// The outline of a chess pawn, from the middle of its foot to the top of its head: distance from the axis, height.
fn pawn_profile() -> Vec<Vec2> {
    let arc = |center: Vec2, radius: Vec2, from: f32, to: f32| {
        (0..=24).map(move |i| center + radius * Vec2::from_angle(from + (to - from) * i as f32 / 24.0))
    };
    let mut profile = vec![Vec2::new(0.0, -1.0), Vec2::new(0.55, -1.0)];
    profile.extend(arc(Vec2::new(0.55, -0.9), Vec2::new(0.1, 0.1), -0.5 * PI, 0.5 * PI)); // foot
    profile.extend(arc(Vec2::new(0.46, -0.72), Vec2::new(0.09, 0.08), -0.5 * PI, 0.5 * PI)); // ring on the foot
    profile.extend(arc(Vec2::new(0.62, 0.1), Vec2::new(0.44, 0.74), 1.5 * PI - 0.38 * PI, 0.92 * PI)); // stem
    profile.extend(arc(Vec2::new(0.3, 0.36), Vec2::new(0.08, 0.05), -0.5 * PI, 0.5 * PI)); // collar
    let head = Vec2::new(0.0, 0.68);
    profile.extend(arc(head, Vec2::splat(0.32), -0.27 * PI, 0.5 * PI));
    profile.push(Vec2::new(0.0, 1.0));
    profile
}

/// The surface that a profile sweeps around the y axis, in `steps` steps. The profile runs from bottom to top, and
/// begins and ends on the axis.
fn revolve(profile: &[Vec2], steps: u32) -> Mesh {
    let at = |point: Vec2, step: u32| {
        let angle = TAU * (step % steps) as f32 / steps as f32;
        if point.x <= 1e-6 {
            Vec3::new(0.0, point.y, 0.0)
        } else {
            Vec3::new(point.x * angle.sin(), point.y, point.x * angle.cos())
        }
    };
    let mut corners = Vec::new();
    for pair in profile.windows(2) {
        for step in 0..steps {
            let (a, b) = (at(pair[0], step), at(pair[0], step + 1));
            let (c, d) = (at(pair[1], step), at(pair[1], step + 1));
            corners.extend([a, b, d, a, d, c]);
        }
    }
    Mesh::of_corners(&corners).0
}

/// A tube of radius 0.22 around the (2, 3) torus knot, on a torus with radii 0.75 and 0.35 around the y axis.
fn knot() -> Mesh {
    const ALONG: u32 = 256;
    const AROUND: u32 = 32;
    const TUBE: f32 = 0.22;
    let center = |t: f32| {
        let ring = 0.75 + 0.35 * (3.0 * t).cos();
        Vec3::new(ring * (2.0 * t).cos(), 0.35 * (3.0 * t).sin(), ring * (2.0 * t).sin())
    };
    // A frame that turns as little as possible, and closes by an even twist along the tube (Wang et al. 2008).
    let tangent = |t: f32| (center(t + 1e-3) - center(t - 1e-3)).normalize();
    let t = |i: u32| TAU * i as f32 / ALONG as f32;
    let mut sides = vec![tangent(0.0).any_orthonormal_vector()];
    for i in 0..ALONG {
        let turn = Quat::from_rotation_arc(tangent(t(i)), tangent(t(i + 1)));
        sides.push(turn * sides[i as usize]);
    }
    let (first, last) = (sides[0], sides[ALONG as usize]);
    let missing = last.cross(first).dot(tangent(0.0)).atan2(last.dot(first));
    let ring = |i: u32, j: u32| {
        let i = i % ALONG;
        let axis = tangent(t(i));
        let angle = TAU * (j % AROUND) as f32 / AROUND as f32 + missing * i as f32 / ALONG as f32;
        center(t(i)) + TUBE * (Quat::from_axis_angle(axis, angle) * sides[i as usize])
    };
    let mut corners = Vec::new();
    for i in 0..ALONG {
        for j in 0..AROUND {
            let (a, b, c, d) = (ring(i, j), ring(i, j + 1), ring(i + 1, j), ring(i + 1, j + 1));
            corners.extend([a, b, d, a, d, c]);
        }
    }
    Mesh::of_corners(&corners).0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(name: &str) -> Mesh {
        let Some(Shape::Mesh(mesh)) = built_in(name) else { panic!("{name} is a mesh") };
        mesh
    }

    #[test]
    fn every_built_in_name_gives_an_object() {
        for name in BUILT_IN {
            let bounds = built_in(name).unwrap().bounds();
            assert!((bounds.max - bounds.min).min_element() > 0.1, "{name}");
        }
        assert!(built_in("tea").is_none());
    }

    #[test]
    fn generated_meshes_are_closed_and_wound_outward() {
        // Volumes: dodecahedron of circumradius 1; the solids of revolution and the tube by Pappus, within 2 %.
        let golden = 0.5 * (1.0 + 5f64.sqrt());
        let edge: f64 = 2.0 / (3f64.sqrt() * golden);
        for (name, volume) in
            [("dodecahedron", Some((15.0 + 7.0 * 5f64.sqrt()) / 4.0 * edge.powi(3))), ("knot", None), ("pawn", None)]
        {
            let mesh = mesh(name);
            assert_eq!(mesh.open_edges(), 0, "{name}");
            let found = mesh.signed_volume();
            assert!(found > 0.1, "{name}: {found}");
            if let Some(volume) = volume {
                assert!((found / volume - 1.0).abs() < 1e-3, "{name}: {found} against {volume}");
            }
        }
        assert_eq!(mesh("dodecahedron").positions.len(), 20);
        assert_eq!(mesh("dodecahedron").triangles.len(), 36);
    }

    #[test]
    fn the_teapot_is_open_where_newell_left_it_open_and_wound_outward() {
        let teapot = mesh("teapot");
        let bounds = teapot.bounds();
        assert!((bounds.min - Vec3::new(-3.0, 0.0, -2.0)).abs().max_element() < 0.01, "{bounds:?}");
        assert!((bounds.max - Vec3::new(3.434, 3.15, 2.0)).abs().max_element() < 0.01, "{bounds:?}");
        assert!(teapot.open_edges() > 0);
        assert!(teapot.signed_volume() > 10.0, "{}", teapot.signed_volume());
    }
}
