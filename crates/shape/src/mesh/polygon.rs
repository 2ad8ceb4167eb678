//! Triangulation of polygons: convex ones as fans, others by ear clipping.
//!
//! Invariant: a polygon of n corners gives n - 2 triangles with its winding. Source: G. Meisters, "Polygons have ears", American
//! Mathematical Monthly 82, 1975; normals by Newell's method.

use crate::error::{Location, ShapeError};
use crate::source::Source;
use earcut::Earcut;
use glam::{DVec2, DVec3};

/// Most corners of a concave polygon.
///
/// Time is quadratic: a star of this size took 72 ms, an outline that crosses itself everywhere 0.5 s. Lower: real outlines
/// (lettering, plans) are refused.
const MAX_CONCAVE_CORNERS: usize = 1 << 14;

/// Appends the triangles of `polygon` (indices into `positions`, at least 3); `false` if it is concave and too large.
///
/// The polygon is projected along its longest normal axis. Copies of a convex polygon, flipped or not, are divided alike.
/// Self-intersecting polygons give n - 2 arbitrary triangles.
pub(super) fn triangulate(polygon: &[u32], positions: &[DVec3], triangles: &mut Vec<[u32; 3]>) -> bool {
    let outline = flattened(polygon, positions);
    let n = polygon.len();
    let is_convex = n == 3 || (0..n).all(|i| turn(outline[i], outline[(i + 1) % n], outline[(i + 2) % n]) >= 0.0);
    if !is_convex && n > MAX_CONCAVE_CORNERS {
        return false;
    }
    let mut ears: Vec<u32> = Vec::new();
    if !is_convex {
        Earcut::new().earcut(outline.iter().map(DVec2::to_array), &[], &mut ears);
    }
    match ears.as_chunks().0 {
        ears if ears.len() == n - 2 => triangles.extend(ears.iter().map(|ear| ear.map(|i| polygon[i as usize]))),
        _ => {
            let first = if n == 3 { 0 } else { (0..n).min_by_key(|&i| polygon[i]).unwrap_or_default() };
            let corner = |i: usize| polygon[(first + i) % n];
            triangles.extend((1..n - 1).map(|i| [corner(0), corner(i), corner(i + 1)]));
        }
    }
    true
}

/// Error of a concave face with too many corners.
pub(crate) fn too_large(source: &Source, place: Location, corners: usize) -> ShapeError {
    let found = format!("with {corners} corners (the limit is {MAX_CONCAVE_CORNERS})");
    source.unsupported(place, "a concave face", found, "triangulate the mesh first")
}

/// Corners projected to a plane, counterclockwise as a whole.
fn flattened(polygon: &[u32], positions: &[DVec3]) -> Vec<DVec2> {
    let corners: Vec<DVec3> = polygon.iter().map(|&corner| positions[corner as usize]).collect();
    let next = corners.iter().cycle().skip(1);
    let normal: DVec3 = corners.iter().zip(next).map(|(a, b)| (*a - corners[0]).cross(*b - corners[0])).sum();
    let size = normal.abs();
    let project = |p: &DVec3| {
        if size.z >= size.x && size.z >= size.y {
            DVec2::new(p.x, p.y * normal.z.signum())
        } else if size.x >= size.y {
            DVec2::new(p.y, p.z * normal.x.signum())
        } else {
            DVec2::new(p.z, p.x * normal.y.signum())
        }
    };
    corners.iter().map(project).collect()
}

/// Twice the signed area of a triangle: positive if a, b, c turn left.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sum of triangle areas and length of the summed area vectors: equal where no triangle is turned over.
    fn areas(positions: &[DVec3], triangles: &[[u32; 3]]) -> (f64, f64) {
        let vectors = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|corner| positions[corner as usize]);
            0.5 * (b - a).cross(c - a)
        });
        (vectors.clone().map(DVec3::length).sum(), vectors.sum::<DVec3>().length())
    }

    /// An arrow head: corner 3 is concave.
    const ARROW: [[f64; 2]; 4] = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [1.0, 1.0]];

    #[test]
    fn concave_polygons_are_covered_once_in_every_direction() {
        let planes: [fn([f64; 2]) -> DVec3; 3] =
            [|[u, v]| DVec3::new(u, v, 5.0), |[u, v]| DVec3::new(5.0, u, v), |[u, v]| DVec3::new(v, 5.0, u)];
        for plane in planes {
            let positions = ARROW.map(plane);
            for polygon in [[0, 1, 2, 3], [3, 2, 1, 0], [2, 3, 0, 1]] {
                let mut triangles = Vec::new();
                assert!(triangulate(&polygon, &positions, &mut triangles));
                let (sum, net) = areas(&positions, &triangles);
                assert_eq!((triangles.len(), sum, net), (2, 1.0, 1.0));
            }
        }
    }

    #[test]
    fn a_star_is_covered_once() {
        let corner = |i: u32| {
            let (sin, cos) = (i as f64 * std::f64::consts::PI / 20.0).sin_cos();
            let radius = if i.is_multiple_of(2) { 1.0 } else { 0.3 };
            DVec3::new(radius * cos, radius * sin, 0.0)
        };
        let positions: Vec<DVec3> = (0..40).map(corner).collect();
        let polygon: Vec<u32> = (0..40).collect();
        let mut triangles = Vec::new();
        assert!(triangulate(&polygon, &positions, &mut triangles));
        let (sum, net) = areas(&positions, &triangles);
        assert_eq!(triangles.len(), 38);
        assert!((sum - net).abs() < 1e-5, "{sum} {net}");
    }

    #[test]
    fn a_convex_polygon_is_a_fan() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let mut triangles = Vec::new();
        assert!(triangulate(&[0, 1, 2, 3], &positions, &mut triangles));
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn copies_of_a_convex_polygon_have_equal_triangles() {
        let positions = [DVec3::X, DVec3::Y, DVec3::ZERO, DVec3::X + DVec3::Y];
        let divided = |polygon: &[u32]| {
            let mut triangles = Vec::new();
            assert!(triangulate(polygon, &positions, &mut triangles));
            triangles.iter_mut().for_each(|triangle| triangle.sort_unstable());
            triangles.sort_unstable();
            triangles
        };
        let quad = [2, 0, 3, 1];
        for from in 0..4 {
            let mut copy = quad;
            copy.rotate_left(from);
            assert_eq!(divided(&copy), divided(&quad));
            copy.reverse();
            assert_eq!(divided(&copy), divided(&quad));
        }
    }

    #[test]
    fn a_polygon_with_a_hole_by_a_bridge_is_covered_once() {
        let ring = |radius: f64, back: bool| {
            (0..13).map(move |i| {
                let angle = if back { -1.0 } else { 1.0 } * f64::from(i % 12) / 12.0 * std::f64::consts::TAU;
                DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
            })
        };
        let positions: Vec<DVec3> = ring(2.0, false).chain(ring(1.0, true)).collect();
        let mut triangles = Vec::new();
        assert!(triangulate(&(0..26).collect::<Vec<u32>>(), &positions, &mut triangles));
        let (sum, net) = areas(&positions, &triangles);
        let expected = 12.0 * 0.5 * (4.0 - 1.0) * (std::f64::consts::TAU / 12.0).sin();
        assert!(triangles.len() == 24 && (sum - expected).abs() < 1e-12 && (net - expected).abs() < 1e-12, "{sum}");
    }

    #[test]
    fn nan_and_crossing_outlines_end() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::NAN, DVec3::Y, DVec3::Z, DVec3::ONE];
        for polygon in [vec![0, 1, 2, 3, 4, 5], vec![0, 5, 1, 3, 0, 1, 5]] {
            let mut triangles = Vec::new();
            assert!(triangulate(&polygon, &positions, &mut triangles));
            assert_eq!(triangles.len(), polygon.len() - 2);
        }
    }
}
