//! The Utah teapot.
//!
//! Role: Newell's 32 Bezier patches into triangles. Invariant: the shape is his, with its open ends (both rims, the
//! ends of handle and spout) and the handle and spout that run into the body; only the bottom is a later addition.
//! Source: M. Newell 1975, see `teapot_data.rs`.

use super::Mesh;
use super::generated::tessellate;
use super::teapot_data::{PATCHES, POINTS};
use glam::{DVec3, Vec3};

/// Cells along each side of a patch: the usual tessellation, and the one of the meshes that go around.
///
/// With 10 no triangle is farther than 0.016 of Newell's units (1/400 of the length) from the surface; error and number
/// of triangles both go with the square.
const CELLS: usize = 10;
/// Middle of the bounding box in Newell's units, y up.
pub const CENTER: Vec3 = Vec3::new(0.217, 1.575, 0.0);
/// Half the length from handle to spout in Newell's units, rounded up.
pub const HALF_LENGTH: f32 = 3.2172;

/// The teapot in Newell's units, y up: x from the handle at -3 to the spout at 3.434, y from 0 to 3.15, z from -2 to 2.
///
/// 6320 triangles, wound outward. Not closed: 160 open edges.
pub fn newell() -> Mesh {
    let corners: Vec<Vec3> = (0..PATCHES.len()).flat_map(patch).collect();
    Mesh::of_corners(&corners).0
}

/// [`newell`] moved and scaled to fit [-1, 1]^3: minus [`CENTER`], divided by [`HALF_LENGTH`].
pub fn unit() -> Mesh {
    let mut mesh = newell();
    mesh.positions.iter_mut().for_each(|p| *p = (*p - CENTER) / HALF_LENGTH);
    mesh
}

/// Triangle corners of one patch.
fn patch(index: usize) -> Vec<Vec3> {
    let points = PATCHES[index].map(|point| {
        let [x, y, z] = POINTS[usize::from(point)];
        Vec3::new(x, z, -y).as_dvec3() // z up to y up
    });
    // Newell's rows and columns turn inward in this order: the columns go first.
    tessellate(CELLS, CELLS, |v, u| {
        let (rows, columns) = (bernstein(u, CELLS), bernstein(v, CELLS));
        let weighted = points.iter().enumerate().map(|(k, &point)| point * (rows[k / 4] * columns[k % 4]));
        weighted.sum::<DVec3>().as_vec3()
    })
}

/// Weights of the four points of a cubic Bezier curve at t = i / n.
///
/// In f64, so that the two sides of a seam round to the same f32.
pub(super) fn bernstein(i: usize, n: usize) -> [f64; 4] {
    let (t, s) = (i as f64 / n as f64, (n - i) as f64 / n as f64);
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

#[cfg(test)]
mod tests {
    use super::super::Bounds;
    use super::*;
    use std::collections::HashSet;

    /// Signed volume of some patches, about the middle of their vertices.
    fn volume(patches: std::ops::Range<usize>) -> f64 {
        let corners: Vec<Vec3> = patches.flat_map(patch).collect();
        let center = Bounds::around(&corners).unwrap().center();
        let moved: Vec<Vec3> = corners.iter().map(|corner| *corner - center).collect();
        Mesh::of_corners(&moved).0.signed_volume()
    }

    #[test]
    fn the_teapot_has_its_known_counts_and_bounds() {
        let mesh = newell();
        assert_eq!((mesh.positions.len(), mesh.triangles.len(), mesh.open_edges()), (3241, 6320, 160));
        let Bounds { min, max } = mesh.bounds();
        assert!(min.distance(Vec3::new(-3.0, 0.0, -2.0)) < 1e-6, "{min}");
        assert!(max.distance(Vec3::new(3.434, 3.15, 2.0)) < 1e-3, "{max}");
    }

    #[test]
    fn every_part_of_the_teapot_is_wound_outward() {
        // Rim with body and bottom, handle, spout, lid: each nearly closed, so the sign of its volume tells.
        let parts = [(0..12, "body"), (12..16, "handle"), (16..20, "spout"), (20..28, "lid"), (28..32, "bottom")];
        for (patches, name) in parts {
            assert!(volume(patches) > 0.0, "{name}");
        }
    }

    #[test]
    fn neighboring_triangles_of_the_teapot_agree_on_the_winding() {
        let mut directed = HashSet::new();
        for [a, b, c] in newell().triangles {
            assert!([(a, b), (b, c), (c, a)].into_iter().all(|edge| directed.insert(edge)));
        }
    }

    #[test]
    fn the_body_faces_away_from_the_axis_and_the_bottom_down() {
        let facing = |index: usize, direction: fn(Vec3) -> Vec3| {
            let corners = patch(index);
            corners.chunks(3).all(|t| (t[1] - t[0]).cross(t[2] - t[0]).dot(direction(t[0] + t[1] + t[2])) >= -1e-6)
        };
        assert!((4..8).all(|index| facing(index, |p| Vec3::new(p.x, 0.0, p.z))));
        assert!((28..32).all(|index| facing(index, |_| Vec3::NEG_Y)));
    }
}
