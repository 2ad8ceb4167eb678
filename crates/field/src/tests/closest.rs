//! Closest points against closed forms and against the distances that they belong to.

use super::*;
use crate::{ClosestPoints, Grid, transform_with_closest};
use hypertexture_shape::{Solid, Volume};

const REQUEST: Request = Request { resolution: 40, margin: 0.3, band: 0.3, iso: 0.0, shell: 0.0 };

/// A cube around the origin, wound outward.
fn block(half: f32) -> Mesh {
    let sign = |bit: u32, corner: u32| if corner >> bit & 1 == 1 { half } else { -half };
    let positions = (0..8).map(|c| Vec3::new(sign(0, c), sign(1, c), sign(2, c))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions,
        triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    }
}

/// The worst of: a point's distance from the surface, and how much farther or nearer it is than the field says, where
/// the field is exact. In voxels.
fn worst(field: &DistanceField, closest: &ClosestPoints, band: f32, surface: impl Fn(Vec3) -> f32) -> (f32, f32) {
    assert_eq!(field.grid, closest.grid);
    let [nx, ny, _] = field.grid.size;
    let mut worst = (0f32, 0f32);
    for (index, (value, point)) in field.values.iter().zip(&closest.points).enumerate() {
        assert!(point.is_finite());
        let i = index as u32;
        let p = field.grid.position(i % nx, i / nx % ny, i / (nx * ny));
        if value.abs() <= band {
            worst.0 = worst.0.max(surface(*point).abs());
            worst.1 = worst.1.max((p.distance(*point) - value.abs()).abs());
        }
    }
    let voxel = field.grid.spacing.min_element();
    (worst.0 / voxel, worst.1 / voxel)
}

#[test]
fn p55_the_closest_point_lies_on_the_surface() {
    let cube = Solid::Cube { half: 0.8 };
    let sphere = |p: Vec3| p.length() - 1.0;
    let ring = Solid::Torus { major: 0.7, minor: 0.3 };
    // The meshes are inscribed: their triangles are inside of the round solids by the sag of a chord.
    for (name, mesh, solid, sag) in [
        ("sphere", icosphere(Vec3::ZERO, 1.0, 4), &sphere as &dyn Fn(Vec3) -> f32, 0.03),
        ("torus", torus(0.7, 0.3, 96, 48), &|p| ring.distance(p), 0.03),
        ("cube", block(0.8), &|p| cube.distance(p), 1e-4),
    ] {
        let (field, closest, _) = transform_with_closest(&Shape::Mesh(mesh), &REQUEST, &|_| {}).unwrap();
        let (off, farther) = worst(&field, &closest, REQUEST.band, solid);
        println!("{name}: {off:e} voxels off the surface, {farther:e} from the distance");
        assert!(off <= sag && farther <= 1e-3, "{name}: {off} and {farther} voxels");
    }
}

#[test]
fn p55_beyond_the_band_the_point_is_one_of_the_surface_too() {
    let request = Request { margin: 1.0, band: 0.05, ..REQUEST };
    let cube = Solid::Cube { half: 0.8 };
    let mesh = block(0.8);
    let (field, closest, _) = transform_with_closest(&Shape::Mesh(mesh), &request, &|_| {}).unwrap();
    let (off, farther) = worst(&field, &closest, f32::INFINITY, |p| cube.distance(p));
    assert!(off <= 1e-3 && farther <= 0.251, "{off} and {farther} voxels");
}

#[test]
fn p55_asking_for_closest_points_changes_no_distance() {
    let mesh = join(&torus(0.7, 0.3, 48, 24), &icosphere(Vec3::new(0.7, 0.1, 0.0), 0.4, 2)); // overlapping solids
    let shape = Shape::Mesh(mesh);
    let (alone, report) = transform(&shape, &REQUEST, &|_| {}).unwrap();
    let (field, closest, with) = transform_with_closest(&shape, &REQUEST, &|_| {}).unwrap();
    assert!(report.buried && alone == field);
    assert_eq!(FieldReport { ms: 0.0, ..report }, FieldReport { ms: 0.0, ..with });
    let (_, farther) = worst(&field, &closest, REQUEST.band, |_| 0.0);
    assert!(farther <= 1e-3, "{farther}: the points are those of the surface that is left");
}

#[test]
fn p55_a_scalar_volume_has_closest_points_on_its_surface() {
    let (size, spacing) = ([33; 3], Vec3::splat(2.4 / 32.0));
    let grid = Grid { size, origin: Vec3::splat(-1.2), spacing };
    let values = (0..33u32.pow(3)).map(|i| 1.0 - grid.position(i % 33, i / 33 % 33, i / 33 / 33).length()).collect();
    let volume = Volume {
        size,
        origin: grid.origin,
        steps: Mat3::from_diagonal(spacing),
        values,
        content: hypertexture_shape::Content::Scalar,
    };
    let (field, closest, _) = transform_with_closest(&Shape::Volume(volume), &REQUEST, &|_| {}).unwrap();
    let (off, farther) = worst(&field, &closest, REQUEST.band, |p| p.length() - 1.0);
    // The surface is linear in tetrahedra of 0.075: off the sphere by h^2 / 8 and some, and a voxel is 0.077.
    assert!(off <= 0.05 && farther <= 1e-3, "{off} and {farther} voxels");
}

#[test]
fn p55_closest_points_of_foreign_fields_use_gradients() {
    let (size, spacing) = ([41, 33, 47], Vec3::new(0.07, 0.08, 0.06));
    let grid = Grid { size, origin: -0.5 * spacing * Vec3::new(40.0, 32.0, 46.0), spacing };
    for (name, solid, bounds) in [
        ("sphere", Solid::Sphere { radius: 0.8 }, (0.05, 0.05)),
        ("torus", Solid::Torus { major: 0.7, minor: 0.3 }, (0.1, 0.1)),
        // The samples know nothing of edges between them: the zero level of their interpolation cuts the corners.
        ("cube", Solid::Cube { half: 0.7 }, (0.6, 1.0)),
    ] {
        let samples = 41 * 33 * 47u32;
        let place = |i: u32| grid.position(i % 41, i / 41 % 33, i / (41 * 33));
        let values: Vec<f32> = (0..samples).map(|i| solid.distance(place(i))).collect();
        let field = DistanceField { grid, values };
        let closest = ClosestPoints::of_field(&field, &|_| {});
        let (off, farther) = worst(&field, &closest, 0.3, |p| solid.distance(p));
        println!("{name}: {off:e} voxels off the surface, {farther:e} from the distance");
        assert!(off <= bounds.0 && farther <= bounds.1, "{name}: {off} and {farther} voxels");
        let off = closest.points.iter().map(|p| field.sample(*p).abs()).fold(0.0, f32::max) / spacing.min_element();
        assert!(off <= 0.1, "{name}: {off} voxels off the level of the field itself");
    }
}

#[test]
fn p55_turned_points_belong_to_the_turned_field() {
    let mesh = torus(0.7, 0.3, 48, 24);
    let (field, closest, _) = transform_with_closest(&Shape::Mesh(mesh), &REQUEST, &|_| {}).unwrap();
    for axes in [[(0, false), (2, false), (1, true)], [(1, true), (2, true), (0, false)]] {
        let (field, closest) = (field.clone().turned(axes), closest.clone().turned(axes));
        let (_, farther) = worst(&field, &closest, REQUEST.band, |_| 0.0);
        assert!(farther <= 1e-3, "{axes:?}: {farther} voxels");
    }
}
