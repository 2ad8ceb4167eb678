//! Hole filling for meshes.
//!
//! Invariant: with the added triangles, distances of neighbors of different sign add up to at most [`APART`] voxels, so the
//! signed field is continuous. The triangles are the level 1/2 of the winding number, in the tetrahedra of the grid where the
//! sign changes across an edge that no triangle crosses.

use super::sign::APART;
use super::tetra::{self, Triangle};
use super::winding::Winding;
use glam::Vec3;
use rayon::prelude::*;

/// Least distance of a winding number from 1/2 at a voxel, which keeps each crossing on its edge.
const OFF_HALF: f64 = 1.0e-3;

/// Closing triangles in voxel units; none if the field is continuous.
pub(super) fn closing_triangles(
    size: [usize; 3],
    distances: &[f32],
    inside: &[bool],
    winding: &Winding,
) -> Vec<Triangle> {
    let [nx, ny, nz] = size;
    let slabs = (0..nz - 1).into_par_iter().map(|z| {
        let mut triangles = Vec::new();
        for y in 0..ny - 1 {
            for x in 0..nx - 1 {
                let at = |i: usize| {
                    let [dx, dy, dz] = tetra::corner(i);
                    ((z + dz) * ny + y + dy) * nx + x + dx
                };
                let first = inside[at(0)];
                if (1..8).all(|i| inside[at(i)] == first) {
                    continue;
                }
                let uncrossed = |a: usize, b: usize| {
                    let (u, v) = (at(a), at(b));
                    let length = ((a ^ b).count_ones() as f32).sqrt();
                    inside[u] != inside[v] && distances[u] + distances[v] > length * APART
                };
                if !tetra::any_tetrahedron_edge(uncrossed) {
                    continue;
                }
                let origin = Vec3::new(x as f32, y as f32, z as f32);
                let corners = std::array::from_fn(|i| origin + Vec3::from_array(tetra::corner(i).map(|c| c as f32)));
                let numbers = winding.around(&corners);
                let values: [f64; 8] = std::array::from_fn(|i| {
                    let level = f64::from(numbers[i].abs()) - 0.5;
                    if inside[at(i)] { level.max(OFF_HALF) } else { level.min(-OFF_HALF) }
                });
                let place = |edge| (origin.as_dvec3() + tetra::crossing(&values, edge)).as_vec3();
                let wanted = |tetrahedron: &[usize; 4]| tetra::any_edge(tetrahedron, uncrossed);
                tetra::march(|i| values[i] >= 0.0, wanted, |triangle| triangles.push(triangle.map(place)));
            }
        }
        triangles
    });
    slabs.collect::<Vec<_>>().concat()
}
