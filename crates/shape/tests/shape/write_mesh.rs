//! Meshes written and read back unchanged in every format, without notes.

use glam::{DVec3, Vec3};
use hypertexture_shape::{Looks, Mesh, MeshFormat, Shape, read};
use proptest::prelude::*;
use serde_json::Value;
use std::path::Path;

const FORMATS: [(MeshFormat, &str); 5] = [
    (MeshFormat::Stl, "a.stl"),
    (MeshFormat::Ply, "a.ply"),
    (MeshFormat::Obj, "a.obj"),
    (MeshFormat::Glb, "a.glb"),
    (MeshFormat::ThreeMf, "a.3mf"),
];

fn bytes(format: MeshFormat, mesh: &Mesh) -> Vec<u8> {
    let mut bytes = Vec::new();
    format.write(mesh, &mut bytes).unwrap();
    bytes
}

fn again(name: &str, bytes: &[u8]) -> Mesh {
    match read(name, bytes) {
        Ok(Shape::Mesh(mesh)) => mesh,
        other => panic!("{name}: {other:?}"),
    }
}

/// Triangle corners in the coordinates of the file.
fn places(mesh: &Mesh) -> Vec<[DVec3; 3]> {
    let corners = |index| mesh.corners(index).map(|corner| corner.as_dvec3() + mesh.offset);
    (0..mesh.triangles.len()).map(corners).collect()
}

/// Fan around the first position, without triangles of zero area.
fn fan(places: &[[f32; 3]], offset: DVec3) -> Mesh {
    let positions: Vec<Vec3> = places.iter().copied().map(Vec3::from).collect();
    let has_area = |[a, b, c]: &[u32; 3]| {
        let [a, b, c] = [a, b, c].map(|corner| positions[*corner as usize].as_dvec3());
        (b - a).cross(c - a) != DVec3::ZERO
    };
    let triangles = (2..places.len() as u32).map(|last| [0, last - 1, last]).filter(has_area).collect();
    Mesh { positions, triangles, offset, ..Mesh::default() }
}

#[test]
fn names_say_the_format() {
    for (format, name) in FORMATS {
        assert_eq!(MeshFormat::from_path(Path::new(name)), Some(format));
        assert_eq!(MeshFormat::from_path(Path::new(&name.to_uppercase())), Some(format));
    }
    for name in ["a", "a.gltf", "stl", ".ply", "a.obj.gz", ""] {
        assert_eq!(MeshFormat::from_path(Path::new(name)), None, "{name}");
    }
}

#[test]
fn a_triangle_is_written_byte_by_byte() {
    let mesh = fan(&[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.5, 0.0]], DVec3::ZERO);
    assert_eq!(bytes(MeshFormat::Obj, &mesh), b"v 0 0 0\nv 2 0 0\nv 0 0.5 0\nf 1 2 3\n");
    let floats = |numbers: &[f32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let corners = floats(&[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.5, 0.0]);
    let stl = [&[b' '; 80][..], &[1, 0, 0, 0], &floats(&[0.0, 0.0, 1.0]), &corners, &[0; 2]].concat();
    assert_eq!(bytes(MeshFormat::Stl, &mesh), stl);
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar uint vertex_indices\nend_header\n";
    let corner = [0_u32, 1, 2].map(u32::to_le_bytes).concat();
    assert_eq!(bytes(MeshFormat::Ply, &mesh), [header.as_bytes(), &corners, &[3], &corner].concat());
    let glb = bytes(MeshFormat::Glb, &mesh);
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&glb[..4], word(4), word(8), &glb[16..20]), (&b"glTF"[..], 2, glb.len(), &b"JSON"[..]));
    let text = word(12);
    assert!(text.is_multiple_of(4) && glb.len().is_multiple_of(4));
    assert_eq!((word(20 + text), &glb[24 + text..28 + text]), (48, &b"BIN\0"[..]));
    assert_eq!(glb[28 + text..], [corners, corner].concat());
    let document: Value = serde_json::from_slice(&glb[20..20 + text]).unwrap();
    assert_eq!(document["accessors"][0]["max"], serde_json::json!([2.0, 0.5, 0.0]));
    assert!(document["nodes"][0]["translation"].is_null());
}

#[test]
fn a_mesh_far_away_keeps_its_place() {
    let offset = DVec3::new(1e5, -2e5, 3e5);
    let mesh = fan(&[[0.0, 0.0, 0.0], [1.0, 0.001, 0.0], [0.3, 1.0, 0.001], [-0.7, 0.5, 0.25]], offset);
    for (format, name) in FORMATS {
        // f32 has 1/64 left there.
        let error = if format == MeshFormat::Stl { 0.016 } else { 1e-7 };
        for (own, found) in places(&mesh).iter().zip(places(&again(name, &bytes(format, &mesh)))) {
            assert!(own.iter().zip(found).all(|(a, b)| a.distance(b) < error), "{name}: {own:?} {found:?}");
        }
    }
}

#[test]
fn what_no_file_can_hold_is_refused() {
    let good = fan(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], DVec3::ZERO);
    let bad = [
        Mesh::default(),
        Mesh { triangles: vec![[0, 1, 3]], ..good.clone() },
        Mesh { positions: vec![Vec3::NAN; 3], ..good.clone() },
        Mesh { offset: DVec3::INFINITY, ..good.clone() },
    ];
    for (format, name) in FORMATS {
        for mesh in &bad {
            let mut written = Vec::new();
            let error = format.write(mesh, &mut written).unwrap_err();
            assert_eq!((error.kind(), written.len()), (std::io::ErrorKind::InvalidInput, 0), "{name}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_mesh_comes_back_bit_for_bit(
        corners in prop::collection::vec(prop::array::uniform3(-1e3_f32..1e3), 3..40), small in -20..6
    ) {
        let corners: Vec<[f32; 3]> = corners.iter().map(|place| place.map(|x| x * (small as f32).exp2())).collect();
        let mesh = fan(&corners, DVec3::ZERO);
        prop_assume!(!mesh.triangles.is_empty());
        for (format, name) in FORMATS {
            let found = again(name, &bytes(format, &mesh));
            // A mesh that stands far from the origin gets an offset of which the sum is the same number.
            prop_assert_eq!(places(&found), places(&mesh), "{}", name);
        }
    }
}

#[test]
fn colors_of_vertices_come_back_and_codes_are_read_as_light() {
    let mesh = fan(&[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.5, 0.0]], DVec3::ZERO);
    let colors = vec![[1.0, 0.0, 0.5], [0.25, 1.0, 0.0], [0.0, 0.0, 0.75]];
    let looks = Looks { normals: vec![Vec3::Z; 3], colors: colors.clone() };
    for (format, name) in &FORMATS[1..] {
        let mut bytes = Vec::new();
        format.write_with(&mesh, Some(&looks), &mut bytes).unwrap();
        let read = again(name, &bytes).colors;
        let apart = read.iter().flatten().zip(colors.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(read.len() == 3 && apart.fold(0.0, f32::max) < 0.01, "{name}: {read:?}");
    }
    // 188 of 255 in sRGB is half of the light; a number that is none counts as 0, and a mesh without colors has none.
    let obj = again("a.obj", b"v 0 0 0 0.7373 nan 2\nv 1 0 0 1 1 1\nv 0 1 0 1 1 1\nf 1 2 3\n").colors;
    assert!((obj[0][0] - 0.503).abs() < 1e-3 && obj[0][1..] == [0.0, 1.0], "{obj:?}");
    assert!(again("a.obj", b"v 0 0 0 1 1 1\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").colors.is_empty());
}
