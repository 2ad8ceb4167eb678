//! Polygons into triangles.
//!
//! Role: convex polygons as fans, others by ear clipping. Invariant: a polygon of n corners gives n - 2 triangles with
//! its winding. Source: G. Meisters, "Polygons have ears", American Mathematical Monthly 82, 1975; the normal by
//! Newell's sums.

use glam::{DVec2, DVec3};

/// Most corners of a polygon that is not convex.
///
/// Ear clipping takes up to n^3 / 6 steps: the worst outline tried, a crossing one, took 8 ms with 512 corners. Fewer
/// and real outlines (lettering, plans) are refused, more and a made-up file holds the reader for seconds.
pub(super) const MAX_CONCAVE_CORNERS: usize = 512;

/// Appends the triangles of `polygon` (indices into `positions`, at least 3); `false` if it is concave and too large.
///
/// The polygon is projected along its longest normal axis. Self-crossing ones have no right answer: they still give
/// n - 2 triangles.
pub(super) fn triangulate(polygon: &[u32], positions: &[DVec3], triangles: &mut Vec<[u32; 3]>) -> bool {
    let outline = flattened(polygon, positions);
    let n = polygon.len();
    let convex = n == 3 || (0..n).all(|i| turn(outline[i], outline[(i + 1) % n], outline[(i + 2) % n]) >= 0.0);
    if convex {
        triangles.extend((1..n - 1).map(|i| [polygon[0], polygon[i], polygon[i + 1]]));
        return true;
    }
    if n > MAX_CONCAVE_CORNERS {
        return false;
    }
    let mut left: Vec<usize> = (0..n).collect();
    while left.len() > 3 {
        let m = left.len();
        let corners = |i: usize| [left[(i + m - 1) % m], left[i], left[(i + 1) % m]];
        // A crossing outline may have no ear; then any corner is as good.
        let ear = (0..m).find(|&i| is_ear(corners(i), &left, &outline)).unwrap_or(0);
        triangles.push(corners(ear).map(|corner| polygon[corner]));
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]].map(|corner| polygon[corner]));
    true
}

/// Corners in a plane, counterclockwise as a whole.
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

/// Twice the signed area of a triangle: positive where a, b, c turn left.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Whether the corner turns left and no other corner lies in its triangle.
fn is_ear([a, b, c]: [usize; 3], left: &[usize], outline: &[DVec2]) -> bool {
    let [pa, pb, pc] = [outline[a], outline[b], outline[c]];
    let inside = |&p: &usize| {
        let q = outline[p];
        // A corner at the same place as one of the three (a bridge to a hole) does not spoil the ear.
        q != pa && q != pb && q != pc && turn(pa, pb, q) >= 0.0 && turn(pb, pc, q) >= 0.0 && turn(pc, pa, q) >= 0.0
    };
    turn(pa, pb, pc) > 0.0 && !left.iter().any(inside)
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
    fn a_concave_polygon_is_covered_once_in_every_plane_and_direction() {
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
    fn nan_and_crossing_outlines_end() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::NAN, DVec3::Y, DVec3::Z, DVec3::ONE];
        for polygon in [vec![0, 1, 2, 3, 4, 5], vec![0, 5, 1, 3, 0, 1, 5]] {
            let mut triangles = Vec::new();
            assert!(triangulate(&polygon, &positions, &mut triangles));
            assert_eq!(triangles.len(), polygon.len() - 2);
        }
    }
}
