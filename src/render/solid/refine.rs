//! Splits of the triangles whose distance is not proven.
//!
//! Invariant: a new vertex lies on the surface, and splits both triangles of its edge, so that the mesh stays closed.

use super::triangle::normal;
use crate::eval::ExactError;
use crate::render::density::Density;
use foldhash::{HashMap, HashMapExt};
use glam::DVec3;

/// Places along the normal on each side at which the surface is looked for, half a tolerance apart.
const PLACES: i32 = 4;
/// Bisections between two of them.
const HALVINGS: u32 = 22;
/// Least cosine between the normals of a triangle and of its parts.
const TURNED: f64 = 0.2;

/// A vertex on the surface, and the nearest place known to be inside.
pub(super) type Vertex = [DVec3; 2];

/// An edge, and the numbers of its two triangles.
type Edge = ([u32; 2], [usize; 2]);

/// Splits the longest edge of each of these triangles at a place of the surface, where one is near: no two edges of one
/// triangle. Returns the triangles that are new.
pub(super) fn split(
    density: &Density<'_>,
    distance: f64,
    vertices: &mut Vec<Vertex>,
    triangles: &mut Vec<[u32; 3]>,
    open: &[usize],
) -> Result<Vec<usize>, ExactError> {
    let edges = edges(vertices, triangles, open);
    let of = |number: usize| normal(&triangles[number].map(|corner| vertices[corner as usize][0])).normalize_or_zero();
    let ways: Vec<(DVec3, DVec3)> = (edges.iter())
        .map(|([a, b], both)| {
            let middle = vertices[*a as usize][0].midpoint(vertices[*b as usize][0]);
            (middle, (of(both[0]) + of(both[1])).normalize_or_zero() * distance)
        })
        .collect();
    let found = surfaces(density, &ways)?;
    let mut new = Vec::new();
    for ((edge, both), vertex) in edges.into_iter().zip(found) {
        let Some(vertex) = vertex else { continue };
        let number = vertices.len() as u32;
        let place = |corner: u32| if corner == number { vertex[0] } else { vertices[corner as usize][0] };
        let halves =
            both.map(|own| edge.map(|end| triangles[own].map(|corner| if corner == end { number } else { corner })));
        let is_kept = both.iter().zip(&halves).all(|(own, halves)| {
            let before = normal(&triangles[*own].map(place)).normalize_or_zero();
            halves.iter().all(|half| {
                let after = normal(&half.map(place));
                after.length() > 0.0 && after.dot(before) >= TURNED * after.length()
            })
        });
        if is_kept {
            vertices.push(vertex);
            for (own, [half, other]) in both.into_iter().zip(halves) {
                triangles[own] = half;
                new.extend([own, triangles.len()]);
                triangles.push(other);
            }
        }
    }
    Ok(new)
}

/// The longest edges of triangles, with both triangles of each; no two of one triangle.
fn edges(vertices: &[Vertex], triangles: &[[u32; 3]], open: &[usize]) -> Vec<Edge> {
    let length = |[a, b]: [u32; 2]| vertices[a as usize][0].distance_squared(vertices[b as usize][0]);
    let sides = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
    let mut of: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    for number in open {
        let [mut longest, next, last] = sides(triangles[*number]);
        for side in [next, last] {
            longest = if length(side) > length(longest) { side } else { longest };
        }
        of.entry(longest).or_default();
    }
    for (number, triangle) in triangles.iter().enumerate() {
        for side in sides(*triangle) {
            if let Some(both) = of.get_mut(&side) {
                both.push(number);
            }
        }
    }
    let mut edges: Vec<Edge> =
        of.into_iter().filter_map(|(edge, both)| Some((edge, *both.first_chunk::<2>()?))).collect();
    edges.sort_unstable();
    let mut is_taken = vec![false; triangles.len()];
    edges.retain(|(_, both)| {
        let is_free = both.iter().all(|number| !is_taken[*number]);
        both.iter().for_each(|number| is_taken[*number] |= is_free);
        is_free
    });
    edges
}

/// The place of the surface nearest to each middle, on the line of a way.
fn surfaces(density: &Density<'_>, ways: &[(DVec3, DVec3)]) -> Result<Vec<Option<Vertex>>, ExactError> {
    let at = |(middle, way): &(DVec3, DVec3), part: f64| middle + 0.5 * part * way;
    let parts: Vec<f64> = (-PLACES..=PLACES).map(f64::from).collect();
    let places: Vec<DVec3> = ways.iter().flat_map(|way| parts.iter().map(|part| at(way, *part))).collect();
    let values = density.at(&places)?;
    // Parts of the way inside and outside of the nearest crossing.
    let mut brackets: Vec<Option<[f64; 2]>> = (values.chunks(parts.len()))
        .map(|values| {
            let is_inside: Vec<bool> = values.iter().map(|value| *value >= density.level).collect();
            let crossed = (1..parts.len()).filter(|end| is_inside[end - 1] != is_inside[*end]);
            let nearest = crossed.min_by(|a, b| (parts[*a] - 0.5).abs().total_cmp(&(parts[*b] - 0.5).abs()))?;
            let pair = [parts[nearest - 1], parts[nearest]];
            Some(if is_inside[nearest] { [pair[1], pair[0]] } else { pair })
        })
        .collect();
    for _ in 0..HALVINGS {
        let middles: Vec<(usize, f64)> = (brackets.iter().enumerate())
            .filter_map(|(number, bracket)| bracket.map(|[inside, outside]| (number, 0.5 * (inside + outside))))
            .collect();
        let places: Vec<DVec3> = middles.iter().map(|(number, part)| at(&ways[*number], *part)).collect();
        for ((number, part), value) in middles.into_iter().zip(density.at(&places)?) {
            if let Some(bracket) = &mut brackets[number] {
                bracket[usize::from(value < density.level)] = part;
            }
        }
    }
    let vertex = |(way, bracket): (&(DVec3, DVec3), Option<[f64; 2]>)| {
        bracket.map(|[inside, outside]| [at(way, 0.5 * (inside + outside)), at(way, inside)])
    };
    Ok(ways.iter().zip(brackets).map(vertex).collect())
}
