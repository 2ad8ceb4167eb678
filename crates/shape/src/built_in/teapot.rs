//! The Utah teapot.
//!
//! Newell's 32 Bezier patches, with handle and spout that reach into the body, and a bottom that was added later. [`newell`]
//! keeps the open ends (both rims, the ends of handle and spout), [`unit()`] closes them. Source: M. Newell 1975, see
//! `teapot_data.rs`.
use super::teapot_data::{PATCHES, POINTS};
use crate::shape::Mesh;
use crate::shape::mesh::tessellate;
use foldhash::{HashSet, HashSetExt};
use glam::{DVec3, Vec3};
use std::collections::BTreeMap;

/// Cells along each side of a patch in [`newell`]: the usual tessellation.
const USUAL: usize = 10;
/// Cells along each side of a patch in [`unit`]. 10 shows facets of 9 degrees; with 40 the error is at most 1/40 voxel of the
/// default resolution. Error and number of triangles are quadratic in it.
const FINE: usize = 40;
/// Center of the bounding box in Newell's units, y up.
pub const CENTER: Vec3 = Vec3::new(0.217, 1.575, 0.0);
/// Half the length from handle to spout in Newell's units, rounded up.
pub(crate) const HALF_LENGTH: f32 = 3.2172;

/// Offset from the center of the spout's mouth to the bottom of its hollow, in Newell's units.
const MOUTH: Vec3 = Vec3::new(-0.3, -0.25, 0.0);

/// The teapot in Newell's units, y up: x from the handle at -3 to the spout at 3.434, y from 0 to 3.15, z from -2 to 2.
///
/// 6320 triangles, wound outward. Not closed: 160 open edges.
pub fn newell() -> Mesh {
    tessellated(USUAL)
}

/// Finer, closed teapot in [-1, 1]^3: relative to [`CENTER`], divided by `HALF_LENGTH`.
///
/// Three solids, each closed and wound outward: the body with its lid, the handle, and the spout.
pub fn unit() -> Mesh {
    let mut mesh = closed(tessellated(FINE));
    mesh.positions.iter_mut().for_each(|p| *p = (*p - CENTER) / HALF_LENGTH);
    mesh
}

/// All patches with `cells` cells along each side.
fn tessellated(cells: usize) -> Mesh {
    let corners: Vec<Vec3> = (0..PATCHES.len()).flat_map(|index| patch(index, cells)).collect();
    Mesh::of_corners(&corners).0
}

/// The teapot without open ends: body and lid are joined at the bottom of the groove between them; the ends of the handle and
/// the foot of the spout, inside of the body, are flat; the mouth of the spout is a hollow.
fn closed(mut mesh: Mesh) -> Mesh {
    let mut circles = Vec::new();
    for edges in open_loops(&mesh) {
        let sum: Vec3 = edges.iter().map(|edge| mesh.positions[edge[0] as usize]).sum();
        let middle = sum / edges.len() as f32;
        if middle.with_y(0.0).length() < 0.5 {
            circles.push(edges); // around the axis: the rim of the body, the edge of the lid
            continue;
        }
        let tip = mesh.positions.len() as u32;
        mesh.positions.push(if middle.x > 2.5 { middle + MOUTH } else { middle });
        mesh.triangles.extend(edges.iter().map(|&[a, b]| [b, a, tip]));
    }
    let [rim, lid] = circles.as_slice() else { return mesh };
    let across = |corner: u32| {
        let far = |other: u32| mesh.positions[other as usize].distance_squared(mesh.positions[corner as usize]);
        lid.iter().map(|edge| edge[0]).min_by(|&a, &b| far(a).total_cmp(&far(b))).unwrap_or(corner)
    };
    let groove = rim.iter().flat_map(|&[a, b]| [[b, a, across(a)], [b, across(a), across(b)]]);
    let groove: Vec<[u32; 3]> = groove.collect();
    mesh.triangles.extend(groove);
    mesh
}

/// Boundary edges, from the first corner in their triangle to the second, joined to loops.
fn open_loops(mesh: &Mesh) -> Vec<Vec<[u32; 2]>> {
    let mut single = HashSet::with_capacity(mesh.triangles.len());
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if !single.remove(&(to, from)) {
                single.insert((from, to));
            }
        }
    }
    let mut single: Vec<(u32, u32)> = single.into_iter().collect();
    single.sort_unstable(); // the order of a set is random
    let mut next: BTreeMap<u32, u32> = single.into_iter().collect();
    let mut loops = Vec::new();
    while let Some((&start, _)) = next.first_key_value() {
        let mut edges = Vec::new();
        let mut from = start;
        while let Some(to) = next.remove(&from) {
            edges.push([from, to]);
            from = to;
        }
        loops.push(edges);
    }
    loops
}

/// Triangle corners of one patch.
fn patch(index: usize, cells: usize) -> Vec<Vec3> {
    let points = PATCHES[index].map(|point| {
        let [x, y, z] = POINTS[usize::from(point)];
        Vec3::new(x, z, -y).as_dvec3() // z up to y up
    });
    // Newell's rows and columns turn inward in this order, so columns come first.
    tessellate(cells, cells, |v, u| {
        let (rows, columns) = (bernstein(u, cells), bernstein(v, cells));
        let weighted = points.iter().enumerate().map(|(k, &point)| point * (rows[k / 4] * columns[k % 4]));
        weighted.sum::<DVec3>().as_vec3()
    })
}

/// Bernstein weights of a cubic Bezier curve at t = i / n.
///
/// In f64, so that both sides of a seam round to the same f32.
pub(super) fn bernstein(i: usize, n: usize) -> [f64; 4] {
    let (t, s) = (i as f64 / n as f64, (n - i) as f64 / n as f64);
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Bounds;
    use std::collections::HashSet;

    /// Signed volume of some patches, about the middle of their vertices.
    fn volume(patches: std::ops::Range<usize>) -> f64 {
        let corners: Vec<Vec3> = patches.flat_map(|index| patch(index, USUAL)).collect();
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
        for mesh in [newell(), unit()] {
            let mut directed = HashSet::new();
            for [a, b, c] in mesh.triangles {
                assert!([(a, b), (b, c), (c, a)].into_iter().all(|edge| directed.insert(edge)));
            }
        }
    }

    #[test]
    fn the_built_in_teapot_is_closed_and_keeps_its_volume() {
        let mesh = unit();
        assert_eq!(mesh.open_edges(), 0);
        // Body and lid alone, by the integral of the area over the profile: 25.25; handle and spout add a twentieth.
        let volume = mesh.signed_volume() * f64::from(HALF_LENGTH).powi(3);
        assert!((25.75..26.75).contains(&volume), "{volume}");
    }

    /// The point of a bicubic patch and its normal, by de Casteljau's construction in f64.
    fn exact(index: usize, u: f64, v: f64) -> (DVec3, DVec3) {
        fn casteljau(mut points: Vec<DVec3>, t: f64) -> (DVec3, DVec3) {
            while points.len() > 2 {
                points = points.windows(2).map(|pair| pair[0].lerp(pair[1], t)).collect();
            }
            (points[0].lerp(points[1], t), points[1] - points[0])
        }
        let points = PATCHES[index].map(|point| {
            let [x, y, z] = POINTS[usize::from(point)].map(f64::from);
            DVec3::new(x, z, -y)
        });
        let rows: Vec<DVec3> = points.chunks(4).map(|row| casteljau(row.to_vec(), v).0).collect();
        let columns: Vec<DVec3> =
            (0..4).map(|column| casteljau((0..4).map(|row| points[4 * row + column]).collect(), u).0).collect();
        let ((place, along), (_, across)) = (casteljau(rows, u), casteljau(columns, v));
        (place, across.cross(along).normalize_or_zero())
    }

    #[test]
    fn teapot_triangles_lie_within_field_precision_of_patches() {
        // A voxel of the default resolution, 192, with the least margin around the object, in Newell's units.
        let voxel = 2.5 / 191.0 * f64::from(HALF_LENGTH);
        let worst_of = |cells: usize| {
            let mut worst: f64 = 0.0;
            for index in 0..PATCHES.len() {
                for (cell, triangles) in patch(index, cells).chunks(6).enumerate() {
                    let [v, u] = [cell / cells, cell % cells].map(|i| (i as f64 + 0.5) / cells as f64);
                    let (place, normal) = exact(index, u, v);
                    let middle = 0.5 * (triangles[0] + triangles[2]).as_dvec3(); // of the edge that both triangles share
                    worst = worst.max((place - middle).dot(normal).abs());
                }
            }
            worst / voxel
        };
        let (usual, fine) = (worst_of(USUAL), worst_of(FINE));
        eprintln!("farthest middle of a cell, in voxels: {usual:.3} with {USUAL} cells, {fine:.4} with {FINE}");
        assert!(usual > 0.1 && fine < 0.025, "{usual} {fine}");
    }

    #[test]
    fn the_body_faces_away_from_the_axis_and_the_bottom_down() {
        let facing = |index: usize, direction: fn(Vec3) -> Vec3| {
            let corners = patch(index, USUAL);
            corners.chunks(3).all(|t| (t[1] - t[0]).cross(t[2] - t[0]).dot(direction(t[0] + t[1] + t[2])) >= -1e-6)
        };
        assert!((4..8).all(|index| facing(index, |p| Vec3::new(p.x, 0.0, p.z))));
        assert!((28..32).all(|index| facing(index, |_| Vec3::NEG_Y)));
    }
}
