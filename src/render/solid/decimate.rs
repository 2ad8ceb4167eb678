//! Decimation of closed meshes by collapses of edges onto one of their ends.
//!
//! Invariant: the mesh stays closed, wound outward and manifold, and its vertices stay those of the full mesh, which lie on
//! the surface.
//! Sources: Garland & Heckbert 1997 (costs); Dey, Edelsbrunner, Guha & Nekhayev 1999 (the link condition).

use super::quadric::Quadric;
use super::triangle::{closest, normal};
use glam::DVec3;
use rayon::prelude::*;

/// Least cosine between the normals of a triangle before and after a collapse. Lower folds the surface; higher keeps creases
/// of noise.
const TURNED: f64 = 0.2;
/// Least height of a new triangle, in its longest side. Lower makes needles; higher keeps triangles.
const NEEDLE: f64 = 0.01;
/// Part of the vertices that a pass has to remove to be followed by another one.
const GAIN: f64 = 2e-3;
/// Length of an edge that may always collapse, in [`Limits::distance`]: shorter ones are lost in 32 bits.
const SHORT: f64 = 2e-3;

/// Level of vertices that stay.
pub(super) const LAST: u8 = 2;

/// Limits of a decimation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Distance of the surface from what it was, in the unit of the mesh.
    pub distance: f64,
    /// Triangles below which nothing is removed.
    pub least: usize,
}

/// A collapse: its cost, the vertex that goes and the one it goes to.
type Collapse = (f64, u32, u32);

/// Triangles of a mesh with, for each vertex, those around it.
struct Rings<'a> {
    places: &'a [DVec3],
    triangles: &'a [[u32; 3]],
    starts: Vec<u32>,
    around: Vec<u32>,
}

impl Rings<'_> {
    fn new<'a>(places: &'a [DVec3], triangles: &'a [[u32; 3]]) -> Rings<'a> {
        let mut starts = vec![0_u32; places.len() + 1];
        triangles.as_flattened().iter().for_each(|corner| starts[*corner as usize + 1] += 1);
        (0..places.len()).for_each(|vertex| starts[vertex + 1] += starts[vertex]);
        let (mut next, mut around) = (starts.clone(), vec![0; 3 * triangles.len()]);
        for (number, corner) in
            triangles.iter().enumerate().flat_map(|(number, triangle)| triangle.map(|c| (number, c)))
        {
            around[next[corner as usize] as usize] = number as u32;
            next[corner as usize] += 1;
        }
        Rings { places, triangles, starts, around }
    }

    fn around(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.around[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// The edges opposite to a vertex, in the winding of its triangles.
    fn link(&self, vertex: u32) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.around(vertex).iter().map(move |number| match self.triangles[*number as usize] {
            [a, b, c] if a == vertex => [b, c],
            [a, b, c] if b == vertex => [c, a],
            [a, b, _] => [a, b],
        })
    }

    fn place(&self, vertex: u32) -> DVec3 {
        self.places[vertex as usize]
    }

    /// Whether a collapse keeps the surface a manifold: the links of both ends meet in two vertices only.
    fn is_manifold(&self, star: &Star, to: u32) -> bool {
        let (mut common, mut is_doubled) = (0, false);
        for [start, end] in self.link(to) {
            common += u32::from(star.link.iter().any(|[own, _]| *own == start));
            is_doubled |= start != star.center && end != star.center && star.link.contains(&[end, start]);
        }
        common == 2 && !is_doubled
    }

    /// The cheapest collapse of a vertex within a distance. Edges shorter than `flat` cost nothing.
    fn best(&self, star: &mut Star, vertex: u32, quadric: &Quadric, (distance, flat): (f64, f64)) -> Option<Collapse> {
        star.fill(self, vertex, flat);
        star.costs.clear();
        for index in 0..star.link.len() {
            let (to, way) = (star.link[index][0], star.corners[index][0] - star.place);
            let cost = quadric.at(way);
            if cost <= distance * distance || way.length_squared() < flat * flat {
                star.costs.push((cost, to));
            }
        }
        star.costs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let is_kept = |(_, to): &&(f64, u32)| {
            star.keeps_shape(self.place(*to), *to, distance.max(flat)) && self.is_manifold(star, *to)
        };
        star.costs.iter().find(is_kept).map(|(cost, to)| (*cost, vertex, *to))
    }
}

/// The triangles around a vertex.
#[derive(Default)]
struct Star {
    center: u32,
    place: DVec3,
    /// The edges opposite to the vertex, and their ends.
    link: Vec<[u32; 2]>,
    corners: Vec<[DVec3; 2]>,
    /// Direction that each triangle has to keep, and the least height of its successor, in its longest side.
    meant: Vec<(DVec3, f64)>,
    /// Costs of the collapses onto its neighbors.
    costs: Vec<(f64, u32)>,
}

impl Star {
    /// Triangles lower than `flat` have no direction of their own; that of the others counts.
    fn fill(&mut self, rings: &Rings<'_>, vertex: u32, flat: f64) {
        (self.center, self.place) = (vertex, rings.place(vertex));
        self.link.clear();
        self.link.extend(rings.link(vertex));
        self.corners.clear();
        self.corners.extend(self.link.iter().map(|edge| edge.map(|end| rings.place(end))));
        self.meant.clear();
        let mut mean = DVec3::ZERO;
        for [a, b] in &self.corners {
            let (across, longest) = (normal(&[self.place, *a, *b]), longest(&[self.place, *a, *b]));
            let is_flat = across.length_squared() < flat * flat * longest;
            mean += across;
            let least = NEEDLE.min(0.5 * across.length() / longest);
            self.meant.push((if is_flat { DVec3::NAN } else { across.normalize_or_zero() }, least));
        }
        let mean = mean.normalize_or_zero();
        self.meant.iter_mut().filter(|(meant, _)| meant.is_nan()).for_each(|(meant, _)| *meant = mean);
    }

    /// Whether a collapse turns no triangle over, makes no needle, and leaves the vertex within a distance of the surface.
    fn keeps_shape(&self, target: DVec3, to: u32, distance: f64) -> bool {
        let mut nearest = f64::INFINITY;
        for ((edge, [a, b]), (meant, least)) in self.link.iter().zip(&self.corners).zip(&self.meant) {
            if edge.contains(&to) {
                continue;
            }
            let corners = [target, *a, *b];
            let across = normal(&corners);
            let area = across.length();
            if across.dot(*meant) < TURNED * area || area < least * longest(&corners) {
                return false;
            }
            if nearest > distance {
                nearest = nearest.min(closest(&corners, self.place).distance(self.place));
            }
        }
        nearest <= distance
    }
}

/// Square of the longest side.
fn longest([a, b, c]: &[DVec3; 3]) -> f64 {
    a.distance_squared(*b).max(b.distance_squared(*c)).max(c.distance_squared(*a))
}

/// Removes vertices while the surface stays within the limits. The distance is halved twice for each of the `levels` of a
/// vertex, and 0 at [`LAST`]. Vertices keep their numbers.
pub(super) fn decimate(places: &[DVec3], triangles: &mut Vec<[u32; 3]>, levels: &[u8], limits: &Limits) {
    let flat = SHORT * limits.distance;
    let distance = |level: u8| if level >= LAST { 0.0 } else { limits.distance * 0.25_f64.powi(level.into()) };
    let mut quadrics = quadrics(places, triangles);
    let mut is_open = vec![true; places.len()];
    loop {
        let rings = Rings::new(places, triangles);
        let of_vertex = |star: &mut Star, vertex: usize| {
            let is_there = is_open[vertex] && !rings.around(vertex as u32).is_empty();
            is_there
                .then(|| rings.best(star, vertex as u32, &quadrics[vertex], (distance(levels[vertex]), flat)))
                .flatten()
        };
        let mut found: Vec<Collapse> =
            (0..places.len()).into_par_iter().map_init(Star::default, of_vertex).flatten().collect();
        is_open.iter_mut().for_each(|is_open| *is_open = false);
        found.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (mut is_touched, mut moved) = (vec![false; places.len()], Vec::new());
        let most = (triangles.len().saturating_sub(limits.least)) / 2;
        for (_, from, to) in found {
            let mut ring = rings.link(from).map(|[start, _]| start);
            if moved.len() == most || is_touched[from as usize] || ring.any(|vertex| is_touched[vertex as usize]) {
                is_open[from as usize] = true;
                continue;
            }
            let changed: Vec<u32> = rings.link(from).map(|[start, _]| start).chain([from]).collect();
            changed.iter().for_each(|vertex| is_touched[*vertex as usize] = true);
            moved.push([from, to]);
        }
        for [from, to] in &moved {
            let moved = quadrics[*from as usize].around(places[*to as usize] - places[*from as usize]);
            quadrics[*to as usize].add(&moved);
            // All whose rings or links have changed.
            for [near, _] in rings.link(*from) {
                is_open[near as usize] = true;
                rings.link(near).for_each(|[far, _]| is_open[far as usize] = true);
            }
        }
        let mut target: Vec<u32> = (0..places.len() as u32).collect();
        moved.iter().for_each(|[from, to]| target[*from as usize] = *to);
        let is_enough = (moved.len() as f64) < GAIN * 0.5 * triangles.len() as f64 || moved.len() == most;
        drop(rings);
        triangles.par_iter_mut().for_each(|triangle| *triangle = triangle.map(|corner| target[corner as usize]));
        triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        if is_enough {
            return;
        }
    }
}

/// Quadrics of the planes around each vertex.
fn quadrics(places: &[DVec3], triangles: &[[u32; 3]]) -> Vec<Quadric> {
    let mut quadrics = vec![Quadric::default(); places.len()];
    for triangle in triangles {
        let across = normal(&triangle.map(|corner| places[corner as usize]));
        let (area, normal) = (0.5 * across.length(), across.normalize_or_zero());
        let plane = Quadric::of_plane(normal, area);
        triangle.iter().for_each(|corner| quadrics[*corner as usize].add(&plane));
    }
    quadrics
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Mesh;

    /// A sphere of 12 x 4^levels triangles.
    fn ball(levels: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let at = |u: usize, v: usize, n: usize| {
            let (phi, theta) =
                (std::f64::consts::TAU * u as f64 / n as f64, std::f64::consts::PI * v as f64 / n as f64);
            DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        };
        let n = 8 << levels;
        let mut places = vec![DVec3::Z, -DVec3::Z];
        places.extend((1..n).flat_map(|v| (0..n).map(move |u| at(u, v, n))));
        let index = |u: usize, v: usize| match v {
            0 => 0,
            v if v == n => 1,
            v => (2 + (v - 1) * n + u % n) as u32,
        };
        let mut triangles = Vec::new();
        for v in 0..n {
            for u in 0..n {
                let [a, b, c, d] = [index(u, v), index(u, v + 1), index(u + 1, v + 1), index(u + 1, v)];
                if v + 1 < n {
                    triangles.push([a, b, c]);
                }
                if v > 0 {
                    triangles.push([a, c, d]);
                }
            }
        }
        (places, triangles)
    }

    fn mesh(places: &[DVec3], triangles: &[[u32; 3]]) -> Mesh {
        let positions = places.iter().map(|place| place.as_vec3()).collect();
        Mesh { positions, triangles: triangles.to_vec(), ..Mesh::default() }
    }

    #[test]
    fn a_decimated_ball_is_closed_and_within_the_distance() {
        let (places, full) = ball(3);
        for distance in [0.002, 0.01, 0.05] {
            let mut triangles = full.clone();
            decimate(&places, &mut triangles, &vec![0; places.len()], &Limits { distance, least: 4 });
            let found = mesh(&places, &triangles);
            let edges = found.edges();
            assert_eq!((edges.open, edges.crowded, edges.turned, edges.bodies), (0, 0, 0, 1), "{distance}");
            // A chord of a sphere is as far from it as the square of its length over 8.
            let expected = (1.0 / distance) as usize;
            assert!((expected..20 * expected).contains(&triangles.len()), "{distance}: {}", triangles.len());
            for triangle in &triangles {
                let middle = triangle.map(|corner| places[corner as usize]).iter().sum::<DVec3>() / 3.0;
                assert!(1.0 - middle.length() < 2.0 * distance, "{distance}: {middle}");
            }
        }
    }

    #[test]
    fn vertices_of_the_last_level_stay_and_a_count_is_kept() {
        let (places, full) = ball(2);
        let levels: Vec<u8> = places.iter().map(|place| if place.z > 0.0 { LAST } else { 0 }).collect();
        let mut triangles = full.clone();
        decimate(&places, &mut triangles, &levels, &Limits { distance: 0.2, least: 4 });
        let used: std::collections::HashSet<u32> = triangles.as_flattened().iter().copied().collect();
        assert!((0..places.len()).all(|vertex| levels[vertex] == 0 || used.contains(&(vertex as u32))));
        assert!(triangles.len() < full.len());
        let mut triangles = full.clone();
        decimate(&places, &mut triangles, &vec![0; places.len()], &Limits { distance: 10.0, least: 300 });
        assert!((300..304).contains(&triangles.len()), "{}", triangles.len());
    }
}
