//! Analytic solids.
//!
//! Invariant: distances are exact up to f32 rounding. Source: J. Hart, "Sphere tracing", The Visual Computer 12, 1996, appendix.

use super::Bounds;
use glam::{Vec2, Vec3};

/// A solid given by a formula, centered at the origin, in world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Solid {
    /// All points within `radius` of the origin.
    Sphere {
        /// Radius.
        radius: f32,
    },
    /// An axis-aligned cube.
    Cube {
        /// Half of the edge length.
        half: f32,
    },
    /// A torus around the y axis.
    Torus {
        /// Distance from the axis to the center of the tube.
        major: f32,
        /// Radius of the tube.
        minor: f32,
    },
}

impl Solid {
    /// Exact signed Euclidean distance from `p` to the surface, positive outside, world units.
    ///
    /// `p` must be finite. Error: a few ulp of the largest coordinate involved.
    pub fn distance(&self, p: Vec3) -> f32 {
        match *self {
            Solid::Sphere { radius } => p.length() - radius,
            Solid::Cube { half } => {
                let q = p.abs() - half;
                q.max(Vec3::ZERO).length() + q.max_element().min(0.0)
            }
            Solid::Torus { major, minor } => Vec2::new(Vec2::new(p.x, p.z).length() - major, p.y).length() - minor,
        }
    }

    /// Closest point of the surface to `p`, world units; any of them where several are equally close.
    ///
    /// `p` must be finite. Error: a few ulp of the largest coordinate involved.
    pub fn closest(&self, p: Vec3) -> Vec3 {
        match *self {
            Solid::Sphere { radius } => p.normalize_or(Vec3::X) * radius,
            Solid::Cube { half } => {
                let mut closest = p.clamp(Vec3::splat(-half), Vec3::splat(half));
                if closest == p {
                    let axis = p.abs().max_position();
                    closest[axis] = half.copysign(p[axis]);
                }
                closest
            }
            Solid::Torus { major, minor } => {
                let ring = Vec3::new(p.x, 0.0, p.z).normalize_or(Vec3::X) * major;
                ring + (p - ring).normalize_or(Vec3::Y) * minor
            }
        }
    }

    /// The tight bounding box.
    pub fn bounds(&self) -> Bounds {
        let max = match *self {
            Solid::Sphere { radius } => Vec3::splat(radius),
            Solid::Cube { half } => Vec3::splat(half),
            Solid::Torus { major, minor } => Vec3::new(major + minor, minor, major + minor),
        };
        Bounds { min: -max, max }
    }
}

/// First-order signed distance to an ellipsoid about the origin, positive outside, exact on the surface (I. Quilez,
/// "Distance to an ellipsoid", 2008).
#[inline(always)] // into the vector code of `head`
pub(crate) fn ellipsoid_distance(p: Vec3, axes: Vec3) -> f32 {
    let (scaled, gradient) = ((p / axes).length(), (p / (axes * axes)).length());
    let away = scaled * (scaled - 1.0) / gradient;
    if gradient == 0.0 { -axes.min_element() } else { away }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOLIDS: [Solid; 3] =
        [Solid::Sphere { radius: 1.0 }, Solid::Cube { half: 0.8 }, Solid::Torus { major: 0.7, minor: 0.3 }];

    #[test]
    fn distances_at_known_points() {
        let [sphere, cube, torus] = SOLIDS;
        assert_eq!(sphere.distance(Vec3::new(0.0, 3.0, 4.0)), 4.0);
        assert_eq!(sphere.distance(Vec3::ZERO), -1.0);
        assert_eq!(cube.distance(Vec3::ZERO), -0.8);
        assert_eq!(cube.distance(Vec3::new(0.5, 0.0, -0.75)), 0.75 - 0.8);
        assert!((cube.distance(Vec3::new(3.8, -4.8, 0.0)) - 5.0).abs() < 1e-6);
        assert!((torus.distance(Vec3::ZERO) - 0.4).abs() < 1e-7);
        assert!((torus.distance(Vec3::new(0.0, 0.1, -0.7)) + 0.2).abs() < 1e-7);
    }

    #[test]
    fn a_distance_has_a_gradient_of_length_one() {
        let h = 1e-3;
        for solid in SOLIDS {
            for p in [[1.3, 0.4, -0.2], [0.71, 0.2, 0.11], [-0.3, -0.55, 0.2], [1.5, -1.4, 1.2]].map(Vec3::from) {
                let axes = [Vec3::X, Vec3::Y, Vec3::Z];
                let slope = axes.map(|axis| (solid.distance(p + axis * h) - solid.distance(p - axis * h)) / (2.0 * h));
                assert!((Vec3::from(slope).length() - 1.0).abs() < 1e-3, "{solid:?} at {p}");
            }
        }
    }

    #[test]
    fn p55_the_closest_point_is_on_the_surface_at_the_distance() {
        let places = [[1.3, 0.4, -0.2], [0.71, 0.2, 0.11], [-0.3, -0.55, 0.2], [1.5, -1.4, 1.2], [0.0; 3]];
        for (solid, p) in SOLIDS.iter().flat_map(|solid| places.map(|p| (solid, Vec3::from(p)))) {
            let closest = solid.closest(p);
            assert!(solid.distance(closest).abs() < 1e-6, "{solid:?} at {p}");
            assert!((p.distance(closest) - solid.distance(p).abs()).abs() < 1e-6, "{solid:?} at {p}");
        }
    }

    #[test]
    fn the_bounds_of_a_solid_touch_its_surface() {
        for solid in SOLIDS {
            let max = solid.bounds().max;
            assert!(solid.distance(Vec3::X * max.x).abs() < 1e-6, "{solid:?}");
            assert!(solid.distance(max) >= -1e-6, "{solid:?}");
        }
    }
}
