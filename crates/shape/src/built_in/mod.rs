//! Built-in objects.
//!
//! Invariant: every name of [`BUILT_IN`] gives a shape; meshes are closed and wound outward. All fit into [-1, 1]^3 with y up.

pub mod head;
pub mod phantom;
mod tank;
pub mod teapot;
mod teapot_data;

use crate::shape::mesh::tessellate;
use crate::shape::{Mesh, Shape, Solid, Volume};
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use std::sync::LazyLock;

/// Names of the built-in objects.
pub const BUILT_IN: &[&str] = &[
    "sphere",
    "cube",
    "torus",
    "dodecahedron",
    "pawn",
    "teapot",
    "knot",
    "head",
    "phantom",
    "hull",
    "turret",
    "gun",
    "tracks",
    "wheels",
];

/// Computed once: it takes seconds, and several objects of a scene may use it.
static HEAD: LazyLock<Volume> = LazyLock::new(head::head);

/// Built-in object by name.
pub(crate) fn by_name(name: &str) -> Option<Shape> {
    Some(match name {
        "sphere" => Shape::Solid(Solid::Sphere { radius: 1.0 }),
        "cube" => Shape::Solid(Solid::Cube { half: 0.8 }), // a cube of half 1 looks larger than the sphere
        "torus" => Shape::Solid(Solid::Torus { major: 0.7, minor: 0.3 }),
        "dodecahedron" => Shape::Mesh(dodecahedron()),
        "pawn" => Shape::Mesh(pawn()),
        "teapot" => Shape::Mesh(teapot::unit()),
        "knot" => Shape::Mesh(knot()),
        "head" => Shape::Volume(HEAD.clone()),
        "phantom" => Shape::Volume(phantom::head()),
        part if tank::PARTS.contains(&part) => Shape::Mesh(tank::part(part)),
        _ => return None,
    })
}

/// A regular dodecahedron with its corners on the unit sphere: 20 vertices, 36 triangles.
fn dodecahedron() -> Mesh {
    let phi = (1.0 + 5_f32.sqrt()) / 2.0;
    let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    // (0, a, b), (b, 0, a) and (a, b, 0) with all signs: 12 points.
    let cycled = |a: f32, b: f32| {
        signs.into_iter().flat_map(move |[s, t]| {
            let (a, b) = (s * a, t * b);
            [Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a), Vec3::new(a, b, 0.0)]
        })
    };
    let cube = signs.into_iter().flat_map(|[s, t]| [Vec3::new(s, t, 1.0), Vec3::new(s, t, -1.0)]);
    let positions: Vec<Vec3> = cube.chain(cycled(1.0 / phi, phi)).map(Vec3::normalize).collect();
    // Face normals are the corners of an icosahedron; a face has the 5 corners farthest along its normal.
    let mut triangles = Vec::new();
    for normal in cycled(phi, 1.0).map(Vec3::normalize) {
        let mut face: Vec<u32> = (0..positions.len() as u32).collect();
        face.sort_by(|&a, &b| normal.dot(positions[b as usize]).total_cmp(&normal.dot(positions[a as usize])));
        face.truncate(5);
        let (u, v) = normal.any_orthonormal_pair();
        let angle = |corner: u32| positions[corner as usize].dot(v).atan2(positions[corner as usize].dot(u));
        face.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)));
        triangles.extend((1..4).map(|i| [face[0], face[i], face[i + 1]]));
    }
    Mesh { positions, triangles, ..Mesh::default() }
}

/// A chess pawn around the y axis from y = -1 to 1, closed.
fn pawn() -> Mesh {
    /// Cells around the axis. Lower: the head shows corners. Higher: triangles become needles.
    const AROUND: usize = 96;
    let profile = pawn_profile();
    let corners = tessellate(profile.len() - 1, AROUND, |i, j| {
        let (sin, cos) = ((j % AROUND) as f32 * TAU / AROUND as f32).sin_cos();
        Vec3::new(profile[i].x * cos, profile[i].y, profile[i].x * sin)
    });
    Mesh::of_corners(&corners).0
}

/// Profile of the pawn as (radius, height), from the center of the bottom to the top of the head.
fn pawn_profile() -> Vec<Vec2> {
    /// Cubic Bezier curves: foot, step, stem and the three curves of the collar.
    const CURVES: [[[f32; 2]; 4]; 6] = [
        [[0.56, -1.0], [0.67, -1.0], [0.67, -0.8], [0.56, -0.8]],
        [[0.56, -0.8], [0.53, -0.8], [0.5, -0.79], [0.5, -0.74]],
        [[0.5, -0.74], [0.46, -0.5], [0.2, -0.4], [0.18, 0.1]],
        [[0.18, 0.1], [0.2, 0.2], [0.28, 0.21], [0.35, 0.23]],
        [[0.35, 0.23], [0.39, 0.24], [0.39, 0.31], [0.35, 0.32]],
        [[0.35, 0.32], [0.3, 0.33], [0.24, 0.34], [0.21, 0.37]],
    ];
    const STEPS: usize = 20;
    const HEAD_RADIUS: f32 = 0.35;
    let mut profile = vec![Vec2::ZERO.with_y(-1.0), Vec2::from(CURVES[0][0])];
    for curve in CURVES {
        let curve = curve.map(|point| Vec2::from(point).as_dvec2());
        profile.extend((1..=STEPS).map(|i| {
            let weights = teapot::bernstein(i, STEPS);
            (curve[0] * weights[0] + curve[1] * weights[1] + curve[2] * weights[2] + curve[3] * weights[3]).as_vec2()
        }));
    }
    // The head is a sphere that touches y = 1 and meets the end of the collar.
    let start = (CURVES[5][3][0] / HEAD_RADIUS).asin();
    let arc = (1..32).map(|i| {
        let (sin, cos) = (start + (PI - start) * i as f32 / 32.0).sin_cos();
        Vec2::new(HEAD_RADIUS * sin, 1.0 - HEAD_RADIUS - HEAD_RADIUS * cos)
    });
    profile.extend(arc);
    profile.push(Vec2::Y);
    profile
}

/// Major and minor radius of the torus that the knot lies on.
const KNOT_MAJOR: f32 = 0.55;
const KNOT_MINOR: f32 = 0.27;
/// Radius of the tube. Higher than 0.23: it touches itself (see the test). Lower than 0.1: it looks like wire.
const KNOT_TUBE: f32 = 0.16;

/// Closed tube along the (2, 3) torus knot, the trefoil: 2 times around the y axis, 3 times around the torus.
fn knot() -> Mesh {
    const ALONG: usize = 384;
    const AROUND: usize = 40;
    let corners = tessellate(ALONG, AROUND, |u, v| {
        let (center, tangent, normal) = knot_frame((u % ALONG) as f32 * TAU / ALONG as f32);
        let (sin, cos) = ((v % AROUND) as f32 * TAU / AROUND as f32).sin_cos();
        center + KNOT_TUBE * (cos * normal - sin * tangent.cross(normal))
    });
    Mesh::of_corners(&corners).0
}

/// Center, unit tangent and unit normal (that of the torus, so the frame closes) at parameter `t` in [0, 2 pi].
fn knot_frame(t: f32) -> (Vec3, Vec3, Vec3) {
    let ((sin2, cos2), (sin3, cos3)) = ((2.0 * t).sin_cos(), (3.0 * t).sin_cos());
    let outward = Vec3::new(cos2, 0.0, sin2);
    let normal = outward * cos3 + Vec3::Y * sin3;
    let radius = KNOT_MAJOR + KNOT_MINOR * cos3;
    let along = Vec3::new(-sin2, 0.0, cos2) * 2.0 * radius;
    let around = (Vec3::Y * cos3 - outward * sin3) * 3.0 * KNOT_MINOR;
    (outward * KNOT_MAJOR + normal * KNOT_MINOR, (along + around).normalize(), normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(name: &str) -> Mesh {
        match by_name(name) {
            Some(Shape::Mesh(mesh)) => mesh,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn every_listed_name_gives_a_shape_of_size_about_two() {
        for name in BUILT_IN {
            let bounds = by_name(name).unwrap().bounds();
            assert!(bounds.max.max(-bounds.min).max_element() <= 1.0 + 1e-6, "{name}: {bounds:?}");
            assert!(bounds.size().max_element() >= 1.6 - 1e-6, "{name}: {bounds:?}");
        }
    }

    #[test]
    fn built_in_meshes_are_closed_and_wound_outward() {
        for name in ["dodecahedron", "pawn", "knot", "teapot"].into_iter().chain(tank::PARTS) {
            let mesh = mesh(name);
            let least = if tank::PARTS.contains(&name) { 0.01 } else { 0.1 };
            assert_eq!(mesh.open_edges(), 0, "{name}");
            assert!(mesh.signed_volume() > least, "{name}: {}", mesh.signed_volume());
        }
    }

    #[test]
    fn the_dodecahedron_has_its_volume_and_its_euler_number() {
        let mesh = mesh("dodecahedron");
        let edge = 4.0 / (3_f64.sqrt() * (1.0 + 5_f64.sqrt()));
        let volume = (15.0 + 7.0 * 5_f64.sqrt()) / 4.0 * edge.powi(3);
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (20, 36));
        assert!((mesh.signed_volume() - volume).abs() < 1e-5 * volume);
        for triangle in 0..36 {
            let [a, b, c] = mesh.corners(triangle);
            assert!((b - a).cross(c - a).dot(a) > 0.0);
        }
    }

    #[test]
    fn the_volume_of_the_knot_is_its_length_times_its_cross_section() {
        // Pappus: exact for a tube that does not meet itself.
        let steps = 10_000;
        let point = |i: usize| knot_frame(i as f32 * TAU / steps as f32).0.as_dvec3();
        let length: f64 = (0..steps).map(|i| point(i).distance(point(i + 1))).sum();
        let expected = length * std::f64::consts::PI * f64::from(KNOT_TUBE).powi(2);
        let volume = mesh("knot").signed_volume();
        assert!((volume / expected - 1.0).abs() < 0.01, "{volume} {expected}");
    }

    #[test]
    fn the_tube_of_the_knot_does_not_touch_itself() {
        let steps = 600;
        let points: Vec<Vec3> = (0..steps).map(|i| knot_frame(i as f32 * TAU / steps as f32).0).collect();
        let mut closest = f32::INFINITY;
        for i in 0..steps {
            // Neighbors along the curve, up to a twelfth of it, are near without touching.
            for j in i + steps / 12..steps.min(i + steps - steps / 12) {
                closest = closest.min(points[i].distance(points[j]));
            }
        }
        assert!(closest > 2.0 * KNOT_TUBE && (closest - 2.0 * 0.232).abs() < 0.01, "{closest}");
    }

    #[test]
    fn the_outline_of_the_pawn_has_no_gap_between_collar_and_head() {
        let profile = pawn_profile();
        let longest = profile.windows(2).skip(1).map(|pair| pair[0].distance(pair[1])).fold(0.0, f32::max);
        assert!(longest < 0.08, "{longest}");
        assert!(profile.iter().all(|point| point.x >= 0.0));
    }
}
