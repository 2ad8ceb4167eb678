//! Triangle soup in voxel units, with consistent winding and its rim.

use super::grid::Local;
use super::tetra::Triangle;
use glam::Vec3;
use hypertexture_shape::Mesh;
use rayon::prelude::*;

/// Triangles in voxel units, and properties of their edges.
pub(super) struct Soup {
    /// Corners of each triangle, flipped to agree with its neighbors.
    pub triangles: Vec<Triangle>,
    /// Edges with a single triangle.
    pub open_edges: usize,
    /// Flipped triangles.
    pub turned: usize,
    /// Points, at most a voxel apart, on edges with unbalanced winding: rims of holes and contradictions.
    pub rim: Vec<Vec3>,
}

impl Soup {
    /// The soup of a mesh whose corner indices are in range.
    pub(super) fn new(mesh: &Mesh, local: &Local) -> Soup {
        let wound = mesh.oriented();
        let positions: Vec<Vec3> = wound.places.par_iter().map(|place| local.of_world(*place)).collect();
        let (mut open_edges, mut rim) = (0, Vec::new());
        for edge in wound.uses.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            open_edges += usize::from(edge.len() == 1);
            let balance: i64 = edge.iter().map(|e| if e.3 { 1 } else { -1 }).sum();
            if balance != 0 {
                let (a, b) = (positions[edge[0].0 as usize], positions[edge[0].1 as usize]);
                let steps = a.distance(b).ceil().max(1.0) as usize;
                rim.extend((0..=steps).map(|s| a.lerp(b, s as f32 / steps as f32)));
            }
        }
        let triangles = wound.triangles.par_iter().map(|t| t.map(|corner| positions[corner as usize])).collect();
        Soup { triangles, open_edges, turned: wound.turned, rim }
    }
}
