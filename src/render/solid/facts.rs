//! Facts about a solid that a printer needs.

use super::tree::Tree;
use super::triangle::normal;
use crate::shape::Mesh;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Angle between a wall that hangs over and the vertical, from which printers need supports.
const OVERHANG: f64 = std::f64::consts::FRAC_PI_4;
/// Height over the lowest place below which the middle of a triangle stands on the plate, in the height of the solid.
const PLATE: f64 = 0.01;
/// Least cosine between the ways out on both sides of a wall: 37 degrees from parallel. Lower takes edges for walls.
const OPPOSITE: f64 = 0.8;
/// Start of the way through a wall, in its own length: past the triangle itself.
const START: f64 = 1e-6;

/// Facts about a closed mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidFacts {
    /// Thickness of each triangle's wall, from its middle straight inward to a side that is
    /// parallel to about 37 degrees; infinite where there is none.
    pub walls: Vec<f32>,
    /// Thinnest wall, and where it starts.
    pub thinnest: Option<(f64, Vec3)>,
    /// Part of the area that hangs over by more than 45 degrees and is not on the plate.
    pub overhang: f64,
}

impl SolidFacts {
    /// Facts of a mesh in its own unit; `up` is its upward direction, of length 1.
    pub fn of(mesh: &Mesh, up: DVec3) -> SolidFacts {
        let corners: Vec<[DVec3; 3]> =
            (0..mesh.triangles.len()).map(|index| mesh.corners(index).map(Vec3::as_dvec3)).collect();
        let heights = mesh.positions.iter().map(|place| place.as_dvec3().dot(up));
        let (lowest, highest) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)));
        let plate = lowest + PLATE * (highest - lowest);
        let (mut all, mut hanging) = (0.0, 0.0);
        for corners in &corners {
            let across = normal(corners);
            all += across.length();
            let is_on_plate = corners.iter().sum::<DVec3>().dot(up) / 3.0 < plate;
            if across.dot(up) < -OVERHANG.sin() * across.length() && !is_on_plate {
                hanging += across.length();
            }
        }
        let extent = mesh.bounds().max.distance(mesh.bounds().min);
        let tree = Tree::new(corners);
        let walls: Vec<f32> =
            (0..tree.len() as u32).into_par_iter().map(|number| wall(&tree, mesh, number, extent.into())).collect();
        let thin =
            (0..walls.len()).min_by(|a, b| walls[*a].total_cmp(&walls[*b])).filter(|thin| walls[*thin].is_finite());
        let thinnest = thin.map(|thin| {
            let middle = tree.corners(thin as u32).iter().sum::<DVec3>() / 3.0;
            (f64::from(walls[thin]), middle.as_vec3())
        });
        SolidFacts { walls, thinnest, overhang: if all > 0.0 { hanging / all } else { 0.0 } }
    }
}

/// Length of the way from the middle of a triangle straight inward to the other side, which is no neighbor.
fn wall(tree: &Tree, mesh: &Mesh, number: u32, extent: f64) -> f32 {
    let corners = tree.corners(number);
    let (middle, inward) = (corners.iter().sum::<DVec3>() / 3.0, -normal(corners).normalize_or_zero());
    let from = middle + START * extent * inward;
    let is_apart = |other: u32| {
        let own = &mesh.triangles[number as usize];
        !mesh.triangles[other as usize].iter().any(|corner| own.contains(corner))
    };
    let is_opposite = |other: u32| normal(tree.corners(other)).normalize_or_zero().dot(inward) >= OPPOSITE;
    match tree.first(from, middle + extent * inward, is_apart) {
        Some((part, other)) if is_opposite(other) => (extent * (START + part * (1.0 - START))) as f32,
        _ => f32::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_its_walls_and_its_overhang() {
        let mut mesh = Mesh::default();
        // A plate of 4 x 1 x 4 on a foot of 1 x 2 x 1, without the hidden parts.
        for (low, high) in [([0.0, 2.0, 0.0], [4.0, 3.0, 4.0]), ([1.5, -0.25, 1.5], [2.5, 1.75, 2.5])] {
            let (low, high) = (Vec3::from(low), Vec3::from(high));
            let first = mesh.positions.len() as u32;
            mesh.positions.extend((0..8).map(|i: u32| {
                Vec3::from([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] }))
            }));
            let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
            for [a, b, c, d] in faces.map(|face| face.map(|corner| first + corner)) {
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let found = SolidFacts::of(&mesh, DVec3::Y);
        let (thinnest, _) = found.thinnest.unwrap();
        assert!((thinnest - 1.0).abs() < 1e-5, "{thinnest}");
        // The lower side of the plate, of all sides: that of the foot stands.
        let expected = 16.0 / (2.0 * 16.0 + 4.0 * 4.0 + 2.0 + 4.0 * 2.0);
        assert!((found.overhang - expected).abs() < 1e-9, "{} {expected}", found.overhang);
        assert_eq!(SolidFacts::of(&mesh, -DVec3::Y).overhang, 1.0 / (2.0 * 16.0 + 16.0 + 2.0 + 8.0));
    }
}
