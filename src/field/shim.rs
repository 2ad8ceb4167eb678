//! Stand-ins for methods of the shape room: the distance of a solid and the bounds of a shape.

use crate::shape::{Bounds, Shape, Solid};
use glam::{Vec2, Vec3};

/// Signed distance of a solid, exact, positive outside.
pub(super) fn distance(solid: &Solid, p: Vec3) -> f32 {
    match *solid {
        Solid::Sphere { radius } => p.length() - radius,
        Solid::Cube { half } => {
            let q = p.abs() - half;
            q.max(Vec3::ZERO).length() + q.max_element().min(0.0)
        }
        Solid::Torus { major, minor } => Vec2::new(Vec2::new(p.x, p.z).length() - major, p.y).length() - minor,
    }
}

/// Bounding box; of a volume, that of its samples.
pub(super) fn bounds(shape: &Shape) -> Bounds {
    match shape {
        Shape::Solid(solid) => {
            let max = match *solid {
                Solid::Sphere { radius } => Vec3::splat(radius),
                Solid::Cube { half } => Vec3::splat(half),
                Solid::Torus { major, minor } => Vec3::new(major + minor, minor, major + minor),
            };
            Bounds { min: -max, max }
        }
        Shape::Mesh(mesh) => {
            let corners = mesh.triangles.iter().flatten().map(|&i| mesh.positions[i as usize]);
            let (min, max) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p)));
            Bounds { min, max }
        }
        Shape::Volume(volume) => {
            let last = Vec3::from_array(volume.size.map(|n| n as f32 - 1.0));
            Bounds { min: volume.origin, max: volume.origin + last * volume.spacing }
        }
    }
}
