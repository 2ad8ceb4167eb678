//! Consistent orientation of the triangles of a mesh, without duplicates.
//!
//! Invariant: positions are compared exactly, so seams of equal positions are closed.

use super::Mesh;
use super::mesh::{Components, weld};
use glam::Vec3;
use rayon::prelude::*;

/// Use of an edge: its two ends as welded vertices in rising order, the triangle, and whether the edge runs from the first to
/// the second.
pub(crate) type EdgeUse = (u32, u32, u32, bool);

/// Consistently oriented triangles.
pub struct OrientedMesh {
    /// Distinct positions.
    pub places: Vec<Vec3>,
    /// Indices into `places`.
    pub triangles: Vec<[u32; 3]>,
    /// Uses of all edges, sorted by their ends.
    pub uses: Vec<EdgeUse>,
    /// Number of reversed triangles.
    pub turned: usize,
    /// Number of dropped duplicates.
    pub repeated: usize,
}

impl Mesh {
    /// Welds corners at equal positions, drops duplicate triangles, and reverses triangles to agree with their neighbors across
    /// edges of two triangles. Every index must be in range.
    ///
    /// A component in which each triangle has a duplicate of opposite winding is kept whole: it encloses nothing.
    pub fn oriented(&self) -> OrientedMesh {
        let (places, welded) = weld(&self.positions);
        let mut triangles: Vec<[u32; 3]> =
            self.triangles.par_iter().map(|triangle| triangle.map(|corner| welded[corner as usize])).collect();
        drop_repeated(&mut triangles, places.len());
        let repeated = self.triangles.len() - triangles.len();
        let edges = |(t, &[a, b, c]): (usize, &[u32; 3])| {
            // A triangle with two equal corners covers its edge both ways and leaves none open.
            let edges = if a == b || b == c || c == a { [None; 3] } else { [(a, b), (b, c), (c, a)].map(Some) };
            edges.into_iter().flatten().map(move |(u, v)| (u.min(v), u.max(v), t as u32, u < v))
        };
        let mut uses: Vec<EdgeUse> = triangles.par_iter().enumerate().flat_map_iter(edges).collect();
        uses.par_sort_unstable();
        let turn = turns(&uses, &triangles, &places);
        uses.par_iter_mut().for_each(|edge| edge.3 ^= turn[edge.2 as usize]);
        triangles.par_iter_mut().zip(&turn).filter(|(_, turn)| **turn).for_each(|(triangle, _)| triangle.swap(1, 2));
        let turned = turn.iter().filter(|turn| **turn).count();
        OrientedMesh { places, triangles, uses, turned, repeated }
    }
}

/// Whether the winding is that of the sorted corners; true for a triangle with equal corners.
fn rises([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a || (a < b) ^ (b < c) ^ (c > a)
}

/// Keeps the first of triangles with equal corners; keeps all of a component that occurs once in either direction.
fn drop_repeated(triangles: &mut Vec<[u32; 3]>, places: usize) {
    let key = |mut triangle: [u32; 3]| {
        triangle.sort_unstable();
        triangle
    };
    let mut order: Vec<([u32; 3], u32)> =
        triangles.par_iter().zip(0..triangles.len() as u32).map(|(triangle, at)| (key(*triangle), at)).collect();
    order.par_sort_unstable();
    let mut is_dropped = vec![false; triangles.len()];
    let mut single = Vec::new();
    for group in order.chunk_by(|a, b| a.0 == b.0) {
        group[1..].iter().for_each(|(_, at)| is_dropped[*at as usize] = true);
        let rising = group.iter().filter(|(_, at)| rises(triangles[*at as usize])).count();
        if 2 * rising != group.len() {
            single.push(group[0].0[0]);
        }
    }
    if !is_dropped.contains(&true) {
        return;
    }
    let mut bodies = Components::of(triangles, places);
    let mut is_solid = vec![false; places];
    single.into_iter().for_each(|corner| is_solid[bodies.root(corner) as usize] = true);
    let mut at = 0..;
    triangles.retain(|triangle| {
        let dropped = at.next().is_some_and(|at: usize| is_dropped[at]);
        !dropped || !is_solid[bodies.root(triangle[0]) as usize]
    });
}

/// Triangles to reverse so that neighbors agree across every edge of two triangles. The larger area of each connected piece
/// keeps its winding; a piece that cannot be oriented (a Moebius strip) is left unchanged.
fn turns(uses: &[EdgeUse], triangles: &[[u32; 3]], places: &[Vec3]) -> Vec<bool> {
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
            let [a, b, c] = triangles[t].map(|corner| places[corner as usize].as_dvec3());
            (b - a).cross(c - a).length()
        };
        let balance: f64 = piece.iter().map(|&t| if turn[t] { area(t) } else { -area(t) }).sum();
        if contradiction || balance > 0.0 {
            piece.iter().for_each(|&t| turn[t] = !contradiction && !turn[t]);
        }
    }
    turn
}
