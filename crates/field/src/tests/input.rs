//! Invalid and extreme input.

use super::*;
use crate::FieldError;
use hypertexture_shape::{Content, Solid, Volume};
use hypertexture_support::random::SplitMix;

fn error(shape: Shape, request: Request) -> FieldError {
    transform(&shape, &request, &|_| {}).unwrap_err()
}

const REQUEST: Request = Request { resolution: 16, margin: 0.1, band: 0.1, iso: 0.0, shell: 0.0 };

#[test]
fn a_bad_request_names_the_value_and_the_remedy() {
    let sphere = || Shape::Solid(Solid::Sphere { radius: 1.0 });
    for resolution in [0, 7, 1025, u32::MAX] {
        assert_eq!(error(sphere(), Request { resolution, ..REQUEST }), FieldError::Resolution { resolution });
    }
    for bad in [-1.0, f32::NAN, f32::INFINITY] {
        let text = error(sphere(), Request { margin: bad, ..REQUEST }).to_string();
        assert!(text.contains("margin") && text.contains(&bad.to_string()) && !text.contains('\n'), "{text}");
        assert!(error(sphere(), Request { band: bad, ..REQUEST }).to_string().contains("band"));
    }
    let memory = error(sphere(), Request { resolution: 1024, ..REQUEST });
    assert!(matches!(memory, FieldError::Memory { size: [1024, 1024, 1024], .. }));
}

#[test]
fn empty_and_damaged_shapes_are_refused() {
    assert_eq!(error(Shape::Mesh(Mesh::default()), REQUEST), FieldError::EmptyMesh);
    let damaged = Mesh { positions: vec![Vec3::ZERO, Vec3::X], triangles: vec![[0, 1, 2]], ..Mesh::default() };
    assert_eq!(error(Shape::Mesh(damaged), REQUEST), FieldError::Corner { index: 2, vertices: 2 });
    for (size, content) in
        [([2, 2, 2], Content::Scalar), ([0, 3, 3], Content::SignedDistance), ([u32::MAX; 3], Content::Scalar)]
    {
        let volume = Volume { size, origin: Vec3::ZERO, steps: Mat3::IDENTITY, values: vec![0.0; 7], content };
        assert!(matches!(error(Shape::Volume(volume), REQUEST), FieldError::Samples { found: 7, .. }));
    }
}

#[test]
fn no_finite_mesh_panics() {
    let wild = [0.0, 1.0, -1.0, 1e-30, 1e-45, 1e30, 3e38, -3e38, 1e6, 1e6 + 0.25];
    let mut random = SplitMix(7);
    for margin in [0.0, 1.0, 1e38] {
        for round in 0..60 {
            let reach = 3 + round % (wild.len() - 2);
            let mut coordinate = || wild[random.bits() as usize % reach];
            let positions = (0..9).map(|_| Vec3::new(coordinate(), coordinate(), coordinate())).collect();
            let mesh = Mesh {
                positions,
                triangles: vec![[0, 1, 2], [3, 4, 5], [6, 7, 8], [0, 3, 6], [1, 1, 2]],
                ..Mesh::default()
            };
            let request = Request { resolution: 9, margin, band: 1.0, iso: 0.0, shell: 0.0 };
            if let Ok((field, _)) = transform(&Shape::Mesh(mesh), &request, &|_| {}) {
                assert!(field.values.iter().all(|v| v.is_finite()));
            }
        }
    }
}

#[test]
fn tiny_huge_and_distant_meshes_have_the_same_field() {
    let unit = icosphere(Vec3::ZERO, 1.0, 3);
    let (reference, _) = field_of(&unit, 32, 0.25, 0.3);
    for scale in [1e-20f32, 1e-3, 1e20] {
        let mesh = Mesh { positions: unit.positions.iter().map(|p| *p * scale).collect(), ..unit.clone() };
        let (field, _) = field_of(&mesh, 32, 0.25 * scale, 0.3 * scale);
        assert!(field.values.iter().zip(&reference.values).all(|(a, b)| (a / scale - b).abs() < 1e-4));
    }
    let far = Mesh { positions: unit.positions.iter().map(|p| *p + 1024.0).collect(), ..unit };
    let (field, _) = field_of(&far, 32, 0.25, 0.3);
    let banded = field.values.iter().zip(&reference.values).filter(|(_, b)| b.abs() < 0.3);
    assert!({ banded }.all(|(a, b)| (a - b).abs() < 1e-3));
}

#[test]
fn a_shape_without_extent_needs_a_margin() {
    let point = Mesh { positions: vec![Vec3::ONE], triangles: vec![[0, 0, 0]], ..Mesh::default() };
    assert!(matches!(error(Shape::Mesh(point.clone()), Request { margin: 0.0, ..REQUEST }), FieldError::Extent { .. }));
    let (field, _) = field_of(&point, 16, 1.0, 10.0);
    assert!((field.sample(Vec3::new(1.0, 1.0, 1.9)) - 0.9).abs() < 0.05);
}

#[test]
fn the_grid_has_the_resolution_and_covers_the_margin() {
    let solid = Shape::Solid(Solid::Torus { major: 1.0, minor: 0.25 });
    for resolution in [8, 17, 100] {
        let request = Request { resolution, margin: 0.125, ..REQUEST };
        let (field, _) = transform(&solid, &request, &|_| {}).unwrap();
        let [nx, ny, nz] = field.grid.size;
        assert_eq!((nx, nz), (resolution, resolution));
        let (low, high) = (field.grid.position(0, 0, 0), field.grid.position(nx - 1, ny - 1, nz - 1));
        let wanted = Vec3::new(1.375, 0.375, 1.375);
        let slack = 1e-3 * field.grid.spacing.x;
        assert!(low.cmple(-wanted + slack).all() && high.cmpge(wanted - slack).all());
        assert!(high.y < wanted.y + field.grid.spacing.y);
    }
}
