//! The Utah teapot, tessellated from its Bezier patches.
//!
//! Role: the control points of [`super::teapot_data`] into triangles. Invariant: y is up, and the triangles are wound
//! counterclockwise seen from outside. Source: M. Newell 1975.

use super::Mesh;
use super::teapot_data::{PATCHES, POINTS};
use glam::Vec3;

/// Squares along each side of a patch. Fewer: facets show at 512 pixels. More: the distance field takes longer.
const DIVISIONS: usize = 16;

/// The teapot of [-3, 3.434] x [0, 3.15] x [-2, 2]; open at the rim, the lid and the spout, and crossing itself where
/// spout and handle meet the body.
pub(super) fn teapot() -> Mesh {
    let mut corners = Vec::with_capacity(PATCHES.len() * DIVISIONS * DIVISIONS * 6);
    for patch in &PATCHES {
        let at = |i: usize, j: usize| point(patch, i as f32 / DIVISIONS as f32, j as f32 / DIVISIONS as f32);
        for i in 0..DIVISIONS {
            for j in 0..DIVISIONS {
                let (a, b, c, d) = (at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
                corners.extend([a, d, c, a, b, d]);
            }
        }
    }
    Mesh::of_corners(&corners).0
}

/// A point of a patch; u along its rows, v along its columns, both in [0, 1].
fn point(patch: &[u16; 16], u: f32, v: f32) -> Vec3 {
    let (row, column) = (bernstein(u), bernstein(v));
    let mut sum = Vec3::ZERO;
    for (index, &control) in patch.iter().enumerate() {
        let [x, y, z] = POINTS[usize::from(control)];
        sum += row[index / 4] * column[index % 4] * Vec3::new(x, z, -y);
    }
    sum
}

fn bernstein(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t]
}
