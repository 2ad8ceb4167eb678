//! Distance fields against brute force and closed forms.

mod broken;
mod closest;
mod exactness;
mod input;
mod oblique;
mod scalar;
mod shell;

use super::{DistanceField, FieldReport, Request, transform};
use glam::{DVec3, Mat3, Vec3};
use hypertexture_shape::{Mesh, Shape};
use std::collections::HashMap;

/// The field of a mesh; margin and band in world units.
fn field_of(mesh: &Mesh, resolution: u32, margin: f32, band: f32) -> (DistanceField, FieldReport) {
    transform(&Shape::Mesh(mesh.clone()), &Request { resolution, margin, band, iso: 0.0, shell: 0.0 }, &|_| {}).unwrap()
}

/// A sphere of `20 * 4^levels` triangles with its vertices on the sphere, wound outward.
fn icosphere(center: Vec3, radius: f32, levels: u32) -> Mesh {
    let t = (1.0 + 5.0f32.sqrt()) / 2.0;
    let mut positions: Vec<Vec3> = [-1.0, 1.0]
        .iter()
        .flat_map(|&s| [-t, t].map(|t| [Vec3::new(s, t, 0.0), Vec3::new(0.0, s, t), Vec3::new(t, 0.0, s)]))
        .flatten()
        .map(Vec3::normalize)
        .collect();
    // Faces of the icosahedron: the triples of mutually nearest vertices.
    let near = |a: usize, b: usize| positions[a].distance(positions[b]) < 1.1;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let outward =
                        (positions[b] - positions[a]).cross(positions[c] - positions[a]).dot(positions[a]) > 0.0;
                    triangles.push(if outward { [a, b, c] } else { [a, c, b] }.map(|i| i as u32));
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh { positions: positions.iter().map(|p| center + radius * *p).collect(), triangles, ..Mesh::default() }
}

/// A torus around the y axis, wound outward.
fn torus(major: f32, minor: f32, around: u32, across: u32) -> Mesh {
    let point = |i: u32, j: u32| {
        let (a, b) =
            (i as f32 / around as f32 * std::f32::consts::TAU, j as f32 / across as f32 * std::f32::consts::TAU);
        let r = major + minor * b.cos();
        Vec3::new(r * a.cos(), minor * b.sin(), r * a.sin())
    };
    let positions = (0..around).flat_map(|i| (0..across).map(move |j| point(i, j))).collect();
    let index = |i: u32, j: u32| i % around * across + j % across;
    let quads = (0..around)
        .flat_map(|i| (0..across).map(move |j| [index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j)]));
    let triangles = quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

/// The union of two meshes.
fn join(a: &Mesh, b: &Mesh) -> Mesh {
    let offset = a.positions.len() as u32;
    let mut joined = a.clone();
    joined.positions.extend(&b.positions);
    joined.triangles.extend(b.triangles.iter().map(|t| t.map(|i| i + offset)));
    joined
}

/// Distance to the nearest triangle, by brute force in f64.
fn brute_force(mesh: &Mesh, p: Vec3) -> f64 {
    let squares = mesh.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3());
        let p = p.as_dvec3();
        if (b - a).cross(c - a).length() < 1e-6 * (b - a).length().max((c - a).length()).powi(2) {
            [(a, b), (b, c), (c, a)].map(|(a, b)| segment_squared(p, a, b)).into_iter().fold(f64::INFINITY, f64::min)
        } else {
            distance_squared(p, a, b, c)
        }
    });
    squares.fold(f64::INFINITY, f64::min).sqrt()
}

fn segment_squared(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let ab = b - a;
    let t = if ab == DVec3::ZERO { 0.0 } else { ((p - a).dot(ab) / ab.length_squared()).clamp(0.0, 1.0) };
    p.distance_squared(a + ab * t)
}

/// Ericson 2005, Real-Time Collision Detection, 5.1.5: by regions, unlike the code under test.
fn distance_squared(p: DVec3, a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return ap.length_squared();
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return bp.length_squared();
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (ap - ab * (d1 / (d1 - d3))).length_squared();
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return cp.length_squared();
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (ap - ac * (d2 / (d2 - d6))).length_squared();
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (bp - (c - b) * w).length_squared();
    }
    let sum = va + vb + vc;
    (ap - ab * (vb / sum) - ac * (vc / sum)).length_squared()
}

/// Index, world position and value of every sample.
fn samples(field: &DistanceField) -> impl Iterator<Item = ([u32; 3], Vec3, f32)> + '_ {
    let [nx, ny, _] = field.grid.size;
    field.values.iter().enumerate().map(move |(i, &value)| {
        let at = [i as u32 % nx, i as u32 / nx % ny, i as u32 / (nx * ny)];
        (at, field.grid.position(at[0], at[1], at[2]), value)
    })
}

/// Largest difference between neighbors in the band, in voxels: 1 for a distance.
fn steepest(field: &DistanceField, band: f32) -> f32 {
    let mut worst = 0.0f32;
    for ([i, j, k], _, value) in samples(field) {
        let [nx, ny, nz] = field.grid.size;
        let next = [
            (i + 1 < nx).then(|| [i + 1, j, k]),
            (j + 1 < ny).then(|| [i, j + 1, k]),
            (k + 1 < nz).then(|| [i, j, k + 1]),
        ];
        for [i, j, k] in next.into_iter().flatten() {
            let other = field.value(i, j, k);
            if value.abs().max(other.abs()) <= band {
                worst = worst.max((value - other).abs() / field.grid.spacing.x);
            }
        }
    }
    worst
}
