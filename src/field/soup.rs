//! A mesh made ready for distances: voxel units, consistent winding, known rim.
//!
//! Invariant: positions are compared exactly, so a mesh cut along seams of equal positions counts as whole.

use super::grid::Local;
use super::tetra::Triangle;
use crate::shape::Mesh;
use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Triangles in voxel units and what their edges tell.
pub(super) struct Soup {
    /// Corners of each triangle, turned where its neighbors disagreed.
    pub triangles: Vec<Triangle>,
    /// Edges of a single triangle.
    pub open_edges: usize,
    /// Triangles turned around.
    pub turned: usize,
    /// Points, at most a voxel apart, on edges whose triangles do not cancel: rims of holes and contradictions.
    pub rim: Vec<Vec3>,
}

/// An edge use: the two welded corners in rising order, the triangle, and whether it runs from the first to the second.
type EdgeUse = (u32, u32, u32, bool);

impl Soup {
    /// Welds, turns and measures the triangles of `mesh`; every corner index is in range.
    pub(super) fn new(mesh: &Mesh, local: &Local) -> Soup {
        let ids = weld(mesh);
        let mut uses: Vec<EdgeUse> = mesh
            .triangles
            .par_iter()
            .enumerate()
            .flat_map_iter(|(t, corners)| {
                let [a, b, c] = corners.map(|i| ids[i as usize]);
                // A triangle with two equal corners covers its edge both ways: nothing to be left open.
                let edges = if a == b || b == c || c == a { [None; 3] } else { [(a, b), (b, c), (c, a)].map(Some) };
                edges.into_iter().flatten().map(move |(u, v)| (u.min(v), u.max(v), t as u32, u < v))
            })
            .collect();
        uses.par_sort_unstable();
        let triangles: Vec<Triangle> =
            mesh.triangles.par_iter().map(|t| t.map(|i| local.of_world(mesh.positions[i as usize]))).collect();
        let turn = turns(&uses, &triangles);
        let mut positions = vec![Vec3::ZERO; ids.len()];
        for (id, p) in ids.iter().zip(&mesh.positions) {
            positions[*id as usize] = local.of_world(*p);
        }
        let (mut open_edges, mut rim) = (0, Vec::new());
        for edge in uses.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            open_edges += usize::from(edge.len() == 1);
            let balance: i64 = edge.iter().map(|e| if e.3 != turn[e.2 as usize] { 1 } else { -1 }).sum();
            if balance != 0 {
                let (a, b) = (positions[edge[0].0 as usize], positions[edge[0].1 as usize]);
                let steps = a.distance(b).ceil().max(1.0) as usize;
                rim.extend((0..=steps).map(|s| a.lerp(b, s as f32 / steps as f32)));
            }
        }
        let turned = turn.iter().filter(|&&t| t).count();
        let oriented = triangles.into_par_iter().zip(turn);
        let triangles = oriented.map(|([a, b, c], turn)| if turn { [a, c, b] } else { [a, b, c] }).collect();
        Soup { triangles, open_edges, turned, rim }
    }
}

/// The same number for equal positions.
fn weld(mesh: &Mesh) -> Vec<u32> {
    let mut known = HashMap::with_capacity(mesh.positions.len());
    // Adding 0 makes -0 and 0 the same.
    let bits = |p: &Vec3| (*p + Vec3::ZERO).to_array().map(f32::to_bits);
    mesh.positions
        .iter()
        .map(|p| {
            let next = known.len() as u32;
            *known.entry(bits(p)).or_insert(next)
        })
        .collect()
}

/// Which triangles to turn so that neighbors agree across every edge of two triangles. The larger area of each
/// connected piece keeps its winding; a piece that cannot agree (a Moebius strip) is left as it is.
fn turns(uses: &[EdgeUse], triangles: &[Triangle]) -> Vec<bool> {
    let mut links: Vec<(u32, u32, bool)> = Vec::new();
    for pair in uses.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).filter(|edge| edge.len() == 2) {
        let disagree = pair[0].3 == pair[1].3;
        links.push((pair[0].2, pair[1].2, disagree));
        links.push((pair[1].2, pair[0].2, disagree));
    }
    let mut turn = vec![false; triangles.len()];
    if links.iter().all(|link| !link.2) {
        return turn;
    }
    links.par_sort_unstable();
    let mut seen = vec![false; triangles.len()];
    for seed in 0..triangles.len() {
        if seen[seed] {
            continue;
        }
        seen[seed] = true;
        let mut piece = vec![seed];
        let (mut next, mut contradiction) = (0, false);
        while next < piece.len() {
            let t = piece[next];
            next += 1;
            let first = links.partition_point(|link| (link.0 as usize) < t);
            for &(_, other, disagree) in links[first..].iter().take_while(|link| link.0 as usize == t) {
                let other = other as usize;
                if seen[other] {
                    contradiction |= turn[other] != (turn[t] != disagree);
                } else {
                    seen[other] = true;
                    turn[other] = turn[t] != disagree;
                    piece.push(other);
                }
            }
        }
        let area = |t: usize| {
            let [a, b, c] = triangles[t].map(Vec3::as_dvec3);
            (b - a).cross(c - a).length()
        };
        let balance: f64 = piece.iter().map(|&t| if turn[t] { area(t) } else { -area(t) }).sum();
        if contradiction || balance > 0.0 {
            piece.iter().for_each(|&t| turn[t] = !contradiction && !turn[t]);
        }
    }
    turn
}
