//! glTF and GLB: every encoding gives the mesh at its place; errors are one line with a place in the JSON.

mod hostile;
mod meshes;
mod wrong;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DVec3, Vec3};
use hypertexture_shape::{Mesh, Shape, read};
use serde_json::{Value, json};

/// A tetrahedron of volume 1/6, wound outward, its corners at the origin and at 1 on each axis.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[u16; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// 48 bytes of corners, then 24 of faces.
fn data() -> Vec<u8> {
    let mut bytes: Vec<u8> = CORNERS.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend(FACES.as_flattened().iter().flat_map(|index| index.to_le_bytes()));
    bytes
}

/// Document of one node with the tetrahedron.
fn document() -> Value {
    json!({
        "asset": { "version": "2.0", "generator": "by hand" },
        "scene": 0,
        "scenes": [{ "nodes": [0], "name": "all" }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1] },
            { "bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48, "target": 34962 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 24, "target": 34963 },
        ],
        "buffers": [{ "byteLength": 72 }],
    })
}

/// GLB chunk.
fn chunk(kind: &[u8; 4], mut bytes: Vec<u8>, fill: u8) -> Vec<u8> {
    bytes.resize(bytes.len().next_multiple_of(4), fill);
    [&(bytes.len() as u32).to_le_bytes()[..], kind, &bytes].concat()
}

fn glb(document: &Value, data: &[u8]) -> Vec<u8> {
    let json = chunk(b"JSON", document.to_string().into_bytes(), b' ');
    let chunks = if data.is_empty() { json } else { [json, chunk(b"BIN\0", data.to_vec(), 0)].concat() };
    [b"glTF\x02\0\0\0", &(chunks.len() as u32 + 12).to_le_bytes()[..], &chunks].concat()
}

/// Document with embedded data.
fn gltf(mut document: Value, data: &[u8]) -> Vec<u8> {
    let address = format!("data:application/octet-stream;base64,{}", STANDARD.encode(data));
    document["buffers"] = json!([{ "byteLength": data.len(), "uri": address }]);
    document.to_string().into_bytes()
}

fn mesh(bytes: &[u8]) -> Mesh {
    match read("test.glb", bytes) {
        Ok(Shape::Mesh(mesh)) => mesh,
        other => panic!("{other:?}"),
    }
}

/// Mesh of a modified document with the tetrahedron's data.
fn changed(change: impl Fn(&mut Value)) -> Mesh {
    let mut document = document();
    change(&mut document);
    mesh(&glb(&document, &data()))
}

/// Error of a file: one line of printable text.
fn error(bytes: &[u8]) -> String {
    let line = read("test.glb", bytes).unwrap_err().to_string();
    assert!(line.starts_with("test.glb: ") && line.lines().count() == 1 && line.len() < 400, "{line}");
    for foreign in
        ["u32", "u64", "f64", "usize", "Some(", "None", "os error", "invalid type", "EOF", "struct", "\u{1b}"]
    {
        assert!(!line.contains(foreign), "{foreign}: {line}");
    }
    line
}

fn corners(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    (0..mesh.triangles.len()).map(|triangle| mesh.corners(triangle)).collect()
}

#[track_caller]
fn assert_tetrahedron(mesh: &Mesh) {
    assert_eq!(mesh.triangles.len(), 4);
    for (found, face) in corners(mesh).iter().zip(FACES) {
        assert_eq!(*found, face.map(|corner| Vec3::from(CORNERS[usize::from(corner)])));
    }
    assert_eq!(mesh.offset, DVec3::ZERO);
}
