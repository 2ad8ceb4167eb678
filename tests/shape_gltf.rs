//! glTF and GLB: every way to write a mesh gives the mesh, where its nodes put it, and what is wrong is one line with its
//! place in the JSON.
#![allow(clippy::unwrap_used)] // clippy sees a test only in `#[test]`, not in what it calls

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DVec3, Vec3};
use hypertexture::shape::{Mesh, Shape, open, open_noted, read, read_noted};
use proptest::prelude::*;
use serde_json::{Value, json};
use std::fs;
use std::time::Instant;

/// A tetrahedron of volume 1/6, wound outward, its corners at the origin and at 1 on each axis.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[u16; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// The corners as 48 bytes, then the faces as 24.
fn data() -> Vec<u8> {
    let mut bytes: Vec<u8> = CORNERS.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend(FACES.as_flattened().iter().flat_map(|index| index.to_le_bytes()));
    bytes
}

/// The document of one node that shows the tetrahedron.
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

/// The bytes of a chunk of GLB.
fn chunk(kind: &[u8; 4], mut bytes: Vec<u8>, fill: u8) -> Vec<u8> {
    bytes.resize(bytes.len().next_multiple_of(4), fill);
    [&(bytes.len() as u32).to_le_bytes()[..], kind, &bytes].concat()
}

fn glb(document: &Value, data: &[u8]) -> Vec<u8> {
    let json = chunk(b"JSON", document.to_string().into_bytes(), b' ');
    let chunks = if data.is_empty() { json } else { [json, chunk(b"BIN\0", data.to_vec(), 0)].concat() };
    [b"glTF\x02\0\0\0", &(chunks.len() as u32 + 12).to_le_bytes()[..], &chunks].concat()
}

/// The document with its data inside.
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

/// The mesh of a changed document over the tetrahedron's data.
fn changed(change: impl Fn(&mut Value)) -> Mesh {
    let mut document = document();
    change(&mut document);
    mesh(&glb(&document, &data()))
}

/// The one line about a file that is not read, whose words are those of a person.
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

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_duck_stands_where_its_node_puts_it() {
    let folder = std::env::var("HYPERTEXTURE_DATA").expect("HYPERTEXTURE_DATA names the folder with the data");
    let (shape, notes) = open_noted(&format!("{folder}/duck.glb")).unwrap();
    let Shape::Mesh(duck) = shape else { panic!("no mesh") };
    assert_eq!((duck.triangles.len(), duck.positions.len(), duck.open_edges(), notes.len()), (4212, 2399, 0, 0));
    let bounds = duck.bounds();
    assert!(bounds.min.distance(Vec3::new(-0.6930, 0.0993, -0.6133)) < 1e-4, "{bounds:?}");
    assert!(bounds.max.distance(Vec3::new(0.9618, 1.6397, 0.5393)) < 1e-4, "{bounds:?}");
    assert!((duck.signed_volume() - 1.1958).abs() < 5e-5, "{}", duck.signed_volume());
}

#[test]
fn data_in_a_chunk_in_the_text_and_in_a_file_beside_it_is_the_same() {
    let chunk = glb(&document(), &data());
    assert_tetrahedron(&mesh(&chunk));
    assert_tetrahedron(&mesh(&gltf(document(), &data())));
    // Chunks behind the data are of extensions.
    let mut more = [chunk, self::chunk(b"ABCD", vec![1, 2, 3], 0)].concat();
    let length = more.len() as u32;
    more[8..12].copy_from_slice(&length.to_le_bytes());
    assert_tetrahedron(&mesh(&more));
    // As other programs write it: a mark at its start, spaces, no `=` at the end of base64 and slashes with escapes.
    let text = String::from_utf8(gltf(document(), &data()[..70])).unwrap();
    assert!(text.contains("=="), "70 bytes need them");
    let text = String::from_utf8(gltf(document(), &data())).unwrap().replace('/', "\\/");
    assert_tetrahedron(&mesh(format!("\u{feff} \n{text}\n").as_bytes()));

    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("some data")).unwrap();
    fs::write(at("some data/ä%.bin"), data()).unwrap();
    let mut document = document();
    document["buffers"][0]["uri"] = json!("./some%20data/%C3%A4%25.bin");
    fs::write(at("a.gltf"), document.to_string()).unwrap();
    let Ok(Shape::Mesh(read)) = open(at("a.gltf").to_str().unwrap()) else { panic!("no mesh") };
    assert_tetrahedron(&read);
    for (uri, said) in [
        ("../some.bin", "buffers[0].uri: the data file `../some.bin` is not supported; put the file"),
        ("%2e%2e/some.bin", "buffers[0].uri: the data file `../some.bin` is not supported; put the file"),
        ("/etc/passwd", "buffers[0].uri: the data file `/etc/passwd` is not supported; put the file"),
        ("https://a.example/b.bin", "buffers[0].uri: the address `https://a.example/b.bin` is not supported"),
        ("none.bin", "none.bin: cannot be read: there is no such file"),
        ("some%20data", "is a directory"),
        ("a.gltf%00", "buffers[0].uri: expected the name of a file"),
        ("%zz", "buffers[0].uri: expected the name of a file"),
        ("%+1", "buffers[0].uri: expected the name of a file"),
        ("%ff", "buffers[0].uri: expected the name of a file"),
        ("", "buffers[0].uri: expected the name of a file"),
    ] {
        document["buffers"][0]["uri"] = json!(uri);
        fs::write(at("b.gltf"), document.to_string()).unwrap();
        let line = open(at("b.gltf").to_str().unwrap()).unwrap_err().to_string();
        assert!(line.contains(said) && line.lines().count() == 1, "{uri}: {line}");
    }
    document["buffers"][0] = json!({ "uri": "some%20data/%C3%A4%25.bin", "byteLength": 73 });
    fs::write(at("b.gltf"), document.to_string()).unwrap();
    let line = open(at("b.gltf").to_str().unwrap()).unwrap_err().to_string();
    assert!(line.contains("declares 73 bytes of data (the length of the buffer), the file holds 72"), "{line}");
    document["buffers"][0]["uri"] = json!("some.bin");
    assert!(error(document.to_string().as_bytes()).contains("put the file of the data beside this one"));
}

#[test]
fn triangles_strips_and_fans_with_and_without_indices_face_the_same_way() {
    // A square in z = 0, seen from +z: its corners in the order of a strip, and of a fan.
    let strip = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0_f32]];
    let fan = [strip[0], strip[1], strip[3], strip[2]];
    let list = [strip[0], strip[1], strip[2], strip[1], strip[3], strip[2]];
    for (mode, corners) in [(4, &list[..]), (5, &strip), (6, &fan)] {
        for (code, bytes) in [(0, 0), (5121, 1), (5123, 2), (5125, 4_usize)] {
            let count = corners.len();
            let mut data: Vec<u8> =
                (0..count).flat_map(|index| (index as u32).to_le_bytes()[..bytes].to_vec()).collect();
            data.resize(24, 0);
            data.extend(corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
            let mut document = document();
            document["accessors"] = json!([
                { "bufferView": 1, "componentType": 5126, "count": count, "type": "VEC3" },
                { "bufferView": 0, "componentType": code, "count": count, "type": "SCALAR" },
            ]);
            document["bufferViews"] = json!([
                { "buffer": 0, "byteLength": 24 },
                { "buffer": 0, "byteOffset": 24, "byteLength": 12 * count },
            ]);
            document["buffers"][0]["byteLength"] = json!(24 + 12 * count);
            let primitive = &mut document["meshes"][0]["primitives"][0];
            primitive["mode"] = json!(mode);
            if bytes == 0 {
                primitive.as_object_mut().unwrap().remove("indices");
            }
            let mesh = mesh(&glb(&document, &data));
            let normals: Vec<Vec3> = self::corners(&mesh).iter().map(|[a, b, c]| (b - a).cross(c - a)).collect();
            assert_eq!(normals, [Vec3::Z, Vec3::Z], "mode {mode}, indices of {bytes} bytes");
            assert_eq!(mesh.positions.len(), if mode == 4 { 6 } else { 4 });
        }
    }
}

#[test]
fn nodes_put_meshes_in_their_places_and_mirrored_ones_stay_outside_out() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mesh = changed(|document| {
        document["scenes"][0]["nodes"] = json!([4, 0]);
        document["nodes"] = json!([
            // A quarter turn around z, twice as large on x, and moved; its child is moved on x before that.
            { "children": [1, 2], "rotation": [0, 0, half, half], "scale": [2, 1, 1], "translation": [10, 0, 0] },
            { "mesh": 0, "translation": [3, 0, 0] },
            { "children": [3] },
            // By columns: x becomes -x.
            { "mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1] },
            { "mesh": 0, "camera": 7, "extras": { "any": [1, "b"] } },
            { "mesh": 0, "translation": [100, 0, 0], "name": "not in the scene" },
        ]);
    });
    assert_eq!((mesh.triangles.len(), mesh.positions.len()), (12, 12));
    // In the order of the scene: the plain one, the moved one, the mirrored one.
    let part = |index: usize| Mesh {
        positions: mesh.positions.clone(),
        triangles: mesh.triangles[4 * index..][..4].to_vec(),
        ..Mesh::default()
    };
    let bounds = |index: usize| {
        let corners: Vec<Vec3> = corners(&part(index)).into_flattened();
        let min = corners.iter().fold(Vec3::MAX, |a, b| a.min(*b));
        (min, corners.iter().fold(Vec3::MIN, |a, b| a.max(*b)))
    };
    assert_eq!(bounds(0), (Vec3::ZERO, Vec3::ONE));
    // x of 3..4 becomes y of 6..8, y of 0..1 becomes x of 10..9.
    let near = |(min, max): (Vec3, Vec3), low: [f32; 3], high: [f32; 3]| {
        assert!(min.distance(Vec3::from(low)) < 1e-6 && max.distance(Vec3::from(high)) < 1e-6, "{min} {max}");
    };
    near(bounds(1), [9.0, 6.0, 0.0], [10.0, 8.0, 1.0]);
    near(bounds(2), [9.0, -2.0, 5.0], [10.0, 0.0, 6.0]);
    for (index, volume) in [(0, 1.0), (1, 2.0), (2, 2.0)] {
        assert!((part(index).signed_volume() - volume / 6.0).abs() < 1e-5, "{index}: {}", part(index).signed_volume());
        assert_eq!(part(index).open_edges(), 0);
    }
}

#[test]
fn the_named_scene_else_the_first_else_every_root_is_read() {
    let at = |change: fn(&mut Value)| {
        let mesh = changed(|document| {
            document["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0, "translation": [5, 0, 0] }, { "children": [1] }]);
            document["scenes"] = json!([{ "nodes": [0] }, { "nodes": [2] }]);
            change(document);
        });
        (mesh.bounds().min.x, mesh.bounds().max.x, mesh.triangles.len())
    };
    let remove = |document: &mut Value, name: &str| drop(document.as_object_mut().unwrap().remove(name));
    assert_eq!(at(|_| ()), (0.0, 1.0, 4));
    assert_eq!(at(|document| document["scene"] = json!(1)), (5.0, 6.0, 4));
    assert_eq!(at(move |document| remove(document, "scene")), (0.0, 1.0, 4));
    assert_eq!(
        at(move |document| {
            remove(document, "scene");
            remove(document, "scenes");
        }),
        (0.0, 6.0, 8)
    );
}

#[test]
fn interleaved_vertices_are_found_in_their_places() {
    // 4 bytes before, and behind each position a normal that is none.
    let mut data = vec![9; 4];
    for corner in CORNERS {
        data.extend(corner.iter().flat_map(|x| x.to_le_bytes()));
        data.extend([f32::NAN; 3].iter().flat_map(|x| x.to_le_bytes()));
    }
    data.truncate(4 + 3 * 24 + 12); // The last one has nothing behind it.
    data.extend(FACES.as_flattened().iter().flat_map(|index| index.to_le_bytes()));
    let mut document = document();
    document["bufferViews"] = json!([
        { "buffer": 0, "byteLength": 88, "byteStride": 24 },
        { "buffer": 0, "byteOffset": 80, "byteLength": 32 },
    ]);
    document["accessors"][0]["byteOffset"] = json!(4);
    document["accessors"][1]["byteOffset"] = json!(8);
    document["buffers"][0]["byteLength"] = json!(112);
    assert_tetrahedron(&mesh(&glb(&document, &data)));
}

#[test]
fn sparse_accessors_replace_what_they_name_and_the_rest_stays_or_is_zero() {
    for code in [(5121, 1), (5123, 2), (5125, 4_usize)] {
        let mut data = data();
        data[12..48].fill(7); // corners 1 to 3
        data[48..50].copy_from_slice(&3_u16.to_le_bytes());
        let number = |x: u32| x.to_le_bytes()[..code.1].to_vec();
        let start = data.len();
        data.extend([1, 2, 3, 0].into_iter().flat_map(number));
        let values = data.len().next_multiple_of(4);
        data.resize(values, 0);
        data.extend(CORNERS[1..].as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        data.extend(0_u16.to_le_bytes());
        let mut document = document();
        document["buffers"][0]["byteLength"] = json!(data.len());
        let views = document["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": values - start }));
        views.push(json!({ "buffer": 0, "byteOffset": values, "byteLength": data.len() - values }));
        document["accessors"][0]["sparse"] = json!({
            "count": 3, "indices": { "bufferView": 2, "componentType": code.0 }, "values": { "bufferView": 3 },
        });
        document["accessors"][1]["sparse"] = json!({
            "count": 1,
            "indices": { "bufferView": 2, "componentType": code.0, "byteOffset": 3 * code.1 },
            "values": { "bufferView": 3, "byteOffset": 36 },
        });
        assert_tetrahedron(&mesh(&glb(&document, &data)));
        // Without a view, corner 0 is zero just so.
        document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
        assert_tetrahedron(&mesh(&glb(&document, &data)));
    }
}

/// Code, bytes, and the largest value of a type of quantized positions.
const QUANTIZED: [(u32, usize, f64); 4] = [(5120, 1, 127.0), (5121, 1, 255.0), (5122, 2, 32767.0), (5123, 2, 65535.0)];

#[test]
fn quantized_positions_are_whole_numbers_or_parts_of_one() {
    for (code, bytes, most) in QUANTIZED {
        for normalized in [false, true] {
            // The corners at 0 and at `most`, and for signed types one at the lowest number.
            let low = if code % 2 == 0 { -most - 1.0 } else { 0.0 };
            let corners = [[low, 0.0, 0.0], [most, 0.0, 0.0], [0.0, most, 0.0], [0.0, 0.0, most]];
            let element = |corner: &[f64; 3]| {
                let mut element: Vec<u8> =
                    corner.iter().flat_map(|x| (*x as i32).to_le_bytes()[..bytes].to_vec()).collect();
                element.resize(4 * bytes, 0xaa);
                element
            };
            let mut data: Vec<u8> = corners.iter().flat_map(element).collect();
            let positions = data.len();
            data.extend(FACES.as_flattened().iter().flat_map(|index| index.to_le_bytes()));
            let mut document = document();
            document["extensionsRequired"] =
                json!(["KHR_mesh_quantization", "KHR_materials_unlit", "KHR_texture_basisu"]);
            document["accessors"][0]["componentType"] = json!(code);
            document["accessors"][0]["normalized"] = json!(normalized);
            document["bufferViews"] = json!([
                { "buffer": 0, "byteLength": positions, "byteStride": 4 * bytes },
                { "buffer": 0, "byteOffset": positions, "byteLength": 24 },
            ]);
            document["buffers"][0]["byteLength"] = json!(data.len());
            let bounds = mesh(&glb(&document, &data)).bounds();
            let (low, high) = if normalized { (low.max(-most) / most, 1.0) } else { (low, most) };
            assert_eq!((bounds.min.x, bounds.max), (low as f32, Vec3::splat(high as f32)), "{code} {normalized}");
        }
    }
}

#[test]
fn what_is_left_out_of_the_geometry_is_noted_and_the_rest_is_not() {
    let mut document = document();
    assert_eq!(read_noted("a.glb", &glb(&document, &data())).unwrap().1, Vec::<String>::new());
    document["nodes"] =
        json!([{ "mesh": 0, "skin": 3, "camera": 9, "extensions": { "KHR_lights_punctual": { "light": 0 } } }]);
    let primitives = document["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives[0]["targets"] = json!([{ "POSITION": 99 }]);
    primitives[0]["material"] = json!(44);
    primitives[0]["attributes"]["NORMAL"] = json!(99);
    primitives.extend((0..4).map(|mode| json!({ "attributes": { "POSITION": 99 }, "mode": mode })));
    let (shape, notes) = read_noted("a.glb", &glb(&document, &data())).unwrap();
    let Shape::Mesh(mesh) = shape else { panic!("no mesh") };
    assert_tetrahedron(&mesh);
    let expected = [
        "primitives of points or lines are left out: 4",
        "skinned meshes stand in the pose they were bound in: 1",
        "meshes stand in their base shape, without morph targets: 1",
    ];
    assert_eq!(notes, expected);
}

#[test]
fn a_node_far_from_the_origin_takes_nothing_from_its_mesh() {
    // Large f32 near the origin would round these to eighths of a thousandth.
    let far = changed(|document| {
        document["nodes"] = json!([
            { "translation": [1e5, -2e5, 3e5], "children": [1] },
            { "translation": [0.125, 0.25, -0.5], "scale": [0.001, 0.001, 0.001], "mesh": 0 },
        ]);
    });
    let near = changed(|document| document["nodes"] = json!([{ "scale": [0.001, 0.001, 0.001], "mesh": 0 }]));
    let moved = DVec3::new(100_000.125, -199_999.75, 299_999.5);
    assert!((far.offset - moved).abs().max_element() < 0.002, "{}", far.offset);
    assert!(far.bounds().max.abs().max_element() < 0.002 && near.offset == DVec3::ZERO);
    for (corner, near) in corners(&far).iter().flatten().zip(corners(&near).iter().flatten()) {
        // f64 has 2^-34 for its last digit there.
        let found = corner.as_dvec3() + far.offset - moved;
        assert!((found - near.as_dvec3()).abs().max_element() < 1e-10, "{found} {near}");
    }
}

/// What is put at a place of the document, and what is said of it.
type Wrong = (&'static str, Value, &'static str);

/// One wrong value each, by its place in the document.
fn wrong_values() -> Vec<Wrong> {
    let many = |count: usize| json!(vec![0; count]);
    vec![
        ("/asset", json!({}), "asset: expected what the schema of glTF 2.0 asks for, found no `version`"),
        ("/asset/version", json!("1.0"), "asset.version: version `1.0` is not supported; export it as glTF 2.0"),
        ("/asset/version", json!("20"), "asset.version: version `20` is not supported"),
        ("/asset/version", json!(2.0), "asset.version: expected what the schema"),
        ("/asset/minVersion", json!("2.1"), "asset.minVersion: version `2.1` is not supported"),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "extensionsRequired[0]: the extension `KHR_draco",
        ),
        (
            "/extensionsRequired",
            json!(["KHR_mesh_quantization", "EXT_meshopt_compression"]),
            "extensionsRequired[1]: the",
        ),
        ("/extensionsRequired", json!(["EXT_mesh_gpu_instancing"]), "export it without this extension"),
        ("/extensionsRequired", json!(["X\u{1b}\n"]), "extensionsRequired[0]: the extension `X"),
        ("/scene", json!(1), "scene: expected the index of something that there is, found 1 of 1, counted from 0"),
        ("/scene", json!(-1), "scene: expected what the schema"),
        ("/scene", json!(0.5), "scene: expected what the schema"),
        ("/scenes", json!({}), "scenes: expected what the schema"),
        ("/scenes", json!([]), "scene: expected the index of something"),
        ("/scenes/0/nodes/0", json!(1), "scenes[0].nodes[0]: expected the index of something"),
        ("/scenes/0/nodes", json!([0, 0]), "scenes[0].nodes[1]: expected each node once in a tree, found 0 again"),
        ("/scenes/0/nodes", json!([]), "no triangles"),
        (
            "/nodes",
            json!([{ "children": [0] }]),
            "nodes[0].children[0]: expected each node once in a tree, found 0 again",
        ),
        (
            "/nodes",
            json!([{ "children": [1, 2] }, { "children": [2] }, {}]),
            "nodes[1].children[0]: expected each node once",
        ),
        (
            "/nodes",
            json!([{ "children": [1] }, { "children": [2] }, { "children": [0] }]),
            "nodes[2].children[0]: expected",
        ),
        (
            "/nodes",
            json!([{ "children": [4_000_000_000_u32] }]),
            "nodes[0].children[0]: expected the index of something",
        ),
        ("/nodes/0", json!("a"), "nodes[0]: expected what the schema"),
        ("/nodes/0/mesh", json!(1), "nodes[0].mesh: expected the index of something that there is, found 1 of 1"),
        ("/nodes/0/mesh", json!("0"), "nodes[0].mesh: expected what the schema"),
        ("/nodes/0/mesh", json!(1_u64 << 40), "nodes[0].mesh: expected what the schema"),
        ("/nodes/0/matrix", json!([1, 0, 0]), "nodes[0].matrix: expected what the schema"),
        (
            "/nodes/0/matrix",
            many(16),
            "nodes[0].matrix: expected 0, 0, 0, 1 as its last row, found [0.0, 0.0, 0.0, 0.0]",
        ),
        (
            "/nodes/0",
            json!({ "matrix": many(16), "scale": [1, 1, 1] }),
            "nodes[0].matrix: expected either a matrix or its parts",
        ),
        ("/nodes/0/rotation", json!([0, 0, 0, 0]), "nodes[0].rotation: expected a rotation of length 1"),
        ("/nodes/0/rotation", json!([1, 1, 0, 0]), "nodes[0].rotation: expected a rotation of length 1"),
        ("/nodes/0/scale", json!([1, 1]), "nodes[0].scale: expected what the schema"),
        ("/nodes/0/scale", json!([0, 0, 0]), "no triangles (4 of zero area were dropped)"),
        ("/nodes/0/scale", json!([1e30, 1e30, 1e30]), "reaches 1e30, the limit is 1e18"),
        ("/nodes/0/scale", json!([1e300, 1e300, 1e300]), "3 of 4 vertices are NaN, infinite or beyond"),
        ("/nodes/0/translation", json!([1e39, 0, 0]), "4 of 4 vertices are NaN, infinite or beyond"),
        ("/nodes/0/translation", json!([null, 0, 0]), "nodes[0].translation"),
        (
            "/nodes/0/extensions",
            json!({ "EXT_mesh_gpu_instancing": {} }),
            "nodes[0].extensions: the extension `EXT_mesh_gpu",
        ),
        ("/meshes/0", json!({}), "meshes[0]: expected what the schema of glTF 2.0 asks for, found no `primitives`"),
        ("/meshes/0/primitives", json!([]), "no triangles"),
        (
            "/meshes/0/primitives/0/attributes",
            json!({}),
            "meshes[0].primitives[0].attributes: expected positions of vertices",
        ),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(2),
            "meshes[0].primitives[0].attributes.POSITION: expected the",
        ),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(1), "accessors[1].type: expected `VEC3`, found `SCALAR`"),
        (
            "/meshes/0/primitives/0/indices",
            json!(2),
            "meshes[0].primitives[0].indices: expected the index of something",
        ),
        ("/meshes/0/primitives/0/indices", json!(0), "accessors[0].type: expected `SCALAR`, found `VEC3`"),
        ("/meshes/0/primitives/0/mode", json!(7), "meshes[0].primitives[0].mode: expected 0 to 6, found 7"),
        ("/meshes/0/primitives/0/mode", json!(1), "no triangles"),
        (
            "/meshes/0/primitives/0/extensions",
            json!({ "KHR_draco_mesh_compression": { "bufferView": 0 } }),
            "meshes[0].primitives[0].extensions: the extension `KHR_draco_mesh_compression` is not supported; export it without",
        ),
        ("/accessors/0/bufferView", json!(2), "accessors[0].bufferView: expected the index of something"),
        (
            "/accessors/0/bufferView",
            json!(1),
            "accessors[0].count: expected as many elements as its view holds, found 4 of 12",
        ),
        (
            "/accessors/0/byteOffset",
            json!(1),
            "accessors[0].byteOffset: expected a multiple of the size of a number, found 1 in",
        ),
        ("/accessors/0/byteOffset", json!(4), "accessors[0].count: expected as many elements as its view holds"),
        ("/accessors/0/byteOffset", json!(u64::MAX - 3), "accessors[0].count: expected as many"),
        ("/accessors/0/componentType", json!(5125), "accessors[0].componentType: expected 5126, or 5120 to 5123"),
        ("/accessors/0/componentType", json!(5130), "accessors[0].componentType: expected 5126"),
        ("/accessors/0/count", json!(5), "accessors[0].count: expected as many elements as its view holds"),
        ("/accessors/0/count", json!(u64::MAX), "accessors[0].count: expected as many elements as its view holds"),
        ("/accessors/0/count", json!(0), "accessors[0].count: expected 1 or more, found 0"),
        ("/accessors/0/count", json!(-4), "accessors[0].count: expected what the schema"),
        (
            "/accessors/0/count",
            json!(3),
            "accessors[1]: expected indices of vertices, and none that restarts a strip, found 3",
        ),
        ("/accessors/0/type", json!("VEC2"), "accessors[0].type: expected `VEC3`, found `VEC2`"),
        ("/accessors/0/type", json!(["VEC3"]), "accessors[0].type: expected what the schema"),
        (
            "/accessors/1/componentType",
            json!(5126),
            "accessors[1].componentType: expected 5121, 5123 or 5125, found 5126",
        ),
        ("/accessors/1/componentType", json!(5122), "accessors[1].componentType: expected 5121, 5123 or 5125"),
        ("/accessors/1/componentType", json!(5125), "accessors[1].count: expected as many elements"),
        ("/accessors/1/byteOffset", json!(3), "accessors[1].byteOffset: expected a multiple of the size of a number"),
        ("/accessors/1/count", json!(11), "meshes[0].primitives[0]: expected 3 corners or more, and a multiple of 3"),
        ("/accessors/1/count", json!(2), "meshes[0].primitives[0]: expected 3 corners or more"),
        ("/accessors/1/normalized", json!(1), "accessors[1].normalized: expected what the schema"),
        ("/bufferViews/0/buffer", json!(1), "bufferViews[0].buffer: expected the index of something"),
        (
            "/bufferViews/0/byteLength",
            json!(73),
            "bufferViews[0]: expected a part of its buffer, found 73 bytes from byte 0 of 72",
        ),
        ("/bufferViews/0/byteLength", json!(u64::MAX), "bufferViews[0]: expected a part of its buffer"),
        ("/bufferViews/0/byteLength", json!(0), "accessors[0].count: expected as many elements"),
        (
            "/bufferViews/1/byteOffset",
            json!(50),
            "bufferViews[1]: expected a part of its buffer, found 24 bytes from byte 50",
        ),
        ("/bufferViews/1/byteOffset", json!(u64::MAX), "bufferViews[1]: expected a part of its buffer"),
        ("/bufferViews/0/byteStride", json!(8), "bufferViews[0].byteStride: expected a multiple of 4 up to 252"),
        ("/bufferViews/0/byteStride", json!(13), "bufferViews[0].byteStride: expected a multiple of 4"),
        ("/bufferViews/0/byteStride", json!(256), "bufferViews[0].byteStride: expected a multiple of 4"),
        (
            "/bufferViews/0/byteStride",
            json!(16),
            "accessors[0].count: expected as many elements as its view holds, found 4 of 12 bytes, 16",
        ),
        (
            "/bufferViews/1/byteStride",
            json!(4),
            "bufferViews[1].byteStride: expected a multiple of 4 up to 252 that holds an element, and none",
        ),
        (
            "/bufferViews/1/extensions",
            json!({ "EXT_meshopt_compression": {} }),
            "bufferViews[1].extensions: the extension `EXT_meshopt",
        ),
        (
            "/bufferViews/1/extensions",
            json!({ "KHR_meshopt_compression": {} }),
            "bufferViews[1].extensions: the extension `KHR_meshopt",
        ),
        ("/buffers", json!([]), "bufferViews[0].buffer: expected the index of something that there is, found 0 of 0"),
        (
            "/buffers/0/byteLength",
            json!(77),
            "buffers[0].byteLength: expected a part of its data, found 77 of 72 bytes",
        ),
        ("/buffers/0/byteLength", json!(u64::MAX), "buffers[0].byteLength: expected a part of its data"),
        ("/buffers/0/uri", json!("data:,abc"), "buffers[0].uri: the data address `data:,abc` is not supported"),
        ("/buffers/0/uri", json!("data:;base64,a$cd"), "buffers[0].uri: expected data in base64"),
        (
            "/buffers/0/uri",
            json!("data:;base64,AAAA"),
            "buffers[0].byteLength: expected a part of its data, found 72 of 3",
        ),
        (
            "/buffers/0/uri",
            json!("data"),
            "buffers[0].uri: the data file `data` is not supported; put the file of the data",
        ),
    ]
}

/// Puts a value at a place, where nothing may be yet.
fn put(document: &mut Value, place: &str, value: Value) {
    let (parent, name) = place.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Array(entries) => entries[name.parse::<usize>().unwrap()] = value,
        Value::Object(fields) => drop(fields.insert(name.into(), value)),
        other => panic!("{other}"),
    }
}

#[test]
fn each_wrong_value_is_said_with_its_place() {
    let wrong = wrong_values();
    assert!(wrong.len() >= 60);
    for (place, value, said) in wrong {
        let mut document = document();
        put(&mut document, place, value.clone());
        let line = error(&glb(&document, &data()));
        assert!(line.contains(said), "{place} = {value}: {line}");
    }
}

#[test]
fn wrong_indices_and_sparse_replacements_are_said_with_their_place() {
    for (index, code, said) in [
        (
            4_u16,
            5123,
            "accessors[1]: expected indices of vertices, and none that restarts a strip, found 4 as number 7 (from 0), of 4",
        ),
        (u16::MAX, 5123, "found 65535 as number 7 (from 0), of 4 vertices"),
    ] {
        let mut data = data();
        data[48 + 14..][..2].copy_from_slice(&index.to_le_bytes());
        let mut document = document();
        document["accessors"][1]["componentType"] = json!(code);
        let line = error(&glb(&document, &data));
        assert!(line.contains(said), "{line}");
    }
    // 300 vertices, so that index 255 of 8 bits is one of them; but it restarts a strip.
    let mut data: Vec<u8> = (0..900).flat_map(|x| (x as f32 * x as f32).to_le_bytes()).collect();
    data.extend([0, 1, 255, 0]);
    let mut document = document();
    document["accessors"] = json!([
        { "bufferView": 0, "componentType": 5126, "count": 300, "type": "VEC3" },
        { "bufferView": 0, "byteOffset": 3600, "componentType": 5121, "count": 3, "type": "SCALAR" },
    ]);
    document["bufferViews"] = json!([{ "buffer": 0, "byteLength": 3604 }]);
    document["buffers"][0]["byteLength"] = json!(3604);
    assert!(error(&glb(&document, &data)).contains("found 255 as number 2 (from 0), of 300 vertices"));

    let sparse = |count: Value, indices: Value, values: Value| {
        let mut document = self::document();
        document["accessors"][0]["sparse"] = json!({ "count": count, "indices": indices, "values": values });
        error(&glb(&document, &self::data()))
    };
    let (indices, values) = (json!({ "bufferView": 1, "componentType": 5123 }), json!({ "bufferView": 0 }));
    for (count, indices, values, said) in [
        (
            json!(0),
            &indices,
            &values,
            "accessors[0].sparse.count: expected 1 or more, and at most `count`, found 0 of 4",
        ),
        (
            json!(5),
            &indices,
            &values,
            "accessors[0].sparse.count: expected 1 or more, and at most `count`, found 5 of 4",
        ),
        (json!(-1), &indices, &values, "accessors[0].sparse.count: expected what the schema"),
        (json!(4), &indices, &values, "accessors[0].sparse.indices: expected rising indices below `count`"),
        (
            json!(1),
            &json!({ "bufferView": 9, "componentType": 5123 }),
            &values,
            "sparse.indices.bufferView: expected the index",
        ),
        (
            json!(1),
            &json!({ "bufferView": 1, "componentType": 5126 }),
            &values,
            "sparse.indices.componentType: expected 5121",
        ),
        (
            json!(1),
            &json!({ "bufferView": 1 }),
            &values,
            "sparse.indices.componentType: expected 5121, 5123 or 5125, found none",
        ),
        (
            json!(1),
            &json!({ "bufferView": 1, "componentType": 5123, "byteOffset": 23 }),
            &values,
            "expected as many elements",
        ),
        (
            json!(1),
            &json!({ "bufferView": 0, "componentType": 5123, "byteOffset": 14 }),
            &values,
            "rising indices below `count`",
        ),
        (json!(1), &indices, &json!({ "bufferView": 2 }), "sparse.values.bufferView: expected the index"),
        (
            json!(4),
            &indices,
            &json!({ "bufferView": 1 }),
            "accessors[0].sparse.count: expected as many elements as its views",
        ),
        (
            json!(1),
            &indices,
            &json!({}),
            "accessors[0].sparse.values: expected what the schema of glTF 2.0 asks for, found no `bufferView`",
        ),
    ] {
        let line = sparse(count.clone(), indices.clone(), values.clone());
        assert!(line.contains(said), "{count} {indices} {values}: {line}");
    }
}

#[test]
fn text_that_is_no_document_is_said_with_its_line() {
    let good = gltf(document(), &data());
    for (text, said) in [
        ("{ \"asset\": ", "line 1: expected more JSON, found its end"),
        (
            "{ \"asset\": {\n\"version\" 2 } }",
            "line 2: expected JSON of at most 127 levels, found `\\\"version\\\" 2` up to line 2, column 11",
        ),
        ("{ \"asset\": 1e999 }", "line 1: expected JSON"),
        ("{ \"asset\": {} } x", "header"),
        ("{ \"asset\": { \"version\": \"2.0\" } } x", "line 1: expected JSON"),
        ("{}", "header: expected what the schema of glTF 2.0 asks for, found no `asset`"),
        ("[\"asset\"]", "expected what the schema"),
        ("{ \"asset\": { \"version\": \"2.0\", \"version\": \"2.0\" } }", "expected what the schema"),
        ("\"asset\"", "header: expected what the schema"),
        ("{ \"asset\": { \"version\": \"2.0\" }, \"nodes\": [], \"nodes\": [] }", "expected what the schema"),
        ("{ \"asset\": { \"version\": \"2.0\" } }", "no triangles"),
        (
            "{ \"asset\": { \"version\": \"2.0\" }, \"nodes\": [{ \"children\": [1] }, { \"children\": [0] }] }",
            "nodes: expected one that is no child of another",
        ),
    ] {
        let line = read("test.gltf", text.as_bytes()).unwrap_err().to_string();
        assert!(line.starts_with("test.gltf: ") && line.contains(said) && line.lines().count() == 1, "{text}: {line}");
    }
    let deep = format!("{{ \"asset\": {}{} }}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(error(deep.as_bytes()).contains("JSON of at most 127 levels"));
    let extras = format!("{{ \"asset\": {{ \"version\": \"2.0\", \"extras\": {} }} }}", "[".repeat(100_000));
    assert!(error(extras.as_bytes()).contains("JSON of at most 127 levels"));
    for cut in 8..good.len() {
        let _ = error(&good[..cut]);
    }
}

#[test]
fn a_binary_file_that_is_cut_or_whose_lengths_lie_is_refused() {
    let good = glb(&document(), &data());
    for cut in 4..good.len() {
        let _ = error(&good[..cut]);
        // And where its header knows of the cut.
        if cut >= 12 {
            let mut short = good[..cut].to_vec();
            short[8..12].copy_from_slice(&(cut as u32).to_le_bytes());
            let _ = error(&short);
        }
    }
    let json = u32::from_le_bytes(good[12..16].try_into().unwrap()) as usize;
    let second = 20 + json;
    for (at, bytes, said) in [
        (4, 1_u32.to_le_bytes(), "byte 4: version `1` is not supported; export it as glTF 2.0"),
        (4, 3_u32.to_le_bytes(), "byte 4: version `3` is not supported"),
        (8, 99_u32.to_le_bytes(), "byte 0: the header declares 99 bytes of data (the whole file), the file holds"),
        (8, [255; 4], "byte 0: the header declares 4294967295 bytes of data"),
        (12, 0_u32.to_le_bytes(), "line 1: expected more JSON"),
        (12, 2_u32.to_le_bytes(), "byte 12: expected the length of a chunk as a multiple of 4, found 2"),
        (12, [252, 255, 255, 255], "byte 20: the header declares 4294967292 bytes of data (a chunk), the file holds"),
        (16, *b"BIN\0", "byte 16: expected the chunk `JSON` first, found `BIN\\0`"),
        (16, [0xff; 4], "byte 16: expected the chunk `JSON` first"),
        (second, 76_u32.to_le_bytes(), "the header declares 76 bytes of data (a chunk), the file holds 72"),
        (second, 68_u32.to_le_bytes(), "buffers[0].byteLength: expected a part of its data, found 72 of 68"),
        (second, 71_u32.to_le_bytes(), "expected the length of a chunk as a multiple of 4, found 71"),
        (second + 4, *b"JSON", "buffers[0].uri: expected where its data is, found none, and no binary chunk"),
    ] {
        let mut bad = good.clone();
        bad[at..at + 4].copy_from_slice(&bytes);
        let line = error(&bad);
        assert!(line.contains(said), "{at}: {line}");
    }
    assert!(error(&glb(&document(), &[])).contains("buffers[0].uri: expected where its data is"));
    assert!(error(&[&good[..], b"more"].concat()).contains("the whole file"));
}

#[test]
fn positions_that_are_not_finite_are_counted() {
    let mut data = data();
    data[16..20].copy_from_slice(&f32::NAN.to_le_bytes());
    let line = error(&glb(&document(), &data));
    assert!(line.contains("1 of 4 vertices are NaN, infinite or beyond 32-bit floats, the first has index"), "{line}");
}

/// What a short file declares at most.
#[test]
fn what_a_document_only_declares_takes_neither_time_nor_memory() {
    let start = Instant::now();
    let huge = |change: fn(&mut Value)| {
        let mut document = document();
        change(&mut document);
        error(&glb(&document, &data()))
    };
    for (line, said) in [
        (
            // 4 billion vertices at zero.
            huge(|document| {
                document["accessors"][0] = json!({ "componentType": 5126, "count": 1_u64 << 32, "type": "VEC3" })
            }),
            "4294967296 elements of accessors without a view, the limit is 1048576",
        ),
        (
            huge(|document| {
                document["accessors"][1] =
                    json!({ "componentType": 5125, "count": 3_000_000_000_u64, "type": "SCALAR" })
            }),
            "3000000000 elements of accessors without a view, the limit is 1048576",
        ),
        (
            huge(|document| {
                document["accessors"][1] = json!({ "componentType": 5125, "count": 600_000, "type": "SCALAR" });
                let primitive = document["meshes"][0]["primitives"][0].clone();
                document["meshes"][0]["primitives"] = json!([primitive, primitive]);
            }),
            "1200000 elements of accessors without a view",
        ),
        (
            huge(|document| {
                document["accessors"][0] = json!({ "componentType": 5126, "count": 4, "type": "VEC3" });
            }),
            "no triangles (4 of zero area were dropped)",
        ),
        (
            // One node more than a tree of doublings would need for more triangles than there may be.
            huge(|document| document["nodes"] = json!([{ "mesh": 0, "children": vec![1; 100_000] }, { "mesh": 0 }])),
            "nodes[0].children[1]: expected each node once",
        ),
    ] {
        assert!(line.contains(said), "{said}: {line}");
    }
    let many = format!("{{ \"asset\": {{ \"version\": \"2.0\" }}, \"nodes\": [{}{{}}] }}", "{},".repeat(1 << 20));
    let line = error(many.as_bytes());
    assert!(line.contains("more than 1048576 entries in a list of the JSON, the limit is 1048576"), "{line}");
    assert!(start.elapsed().as_secs_f64() < 2.0, "{:?}", start.elapsed());
}

#[test]
fn a_mesh_shown_too_often_is_refused_before_there_are_too_many_triangles() {
    // 100 x 100 squares, shown 2501 times, are 20000 triangles more than 50 million.
    let side = 100_u32;
    let mut data: Vec<u8> = Vec::new();
    for corner in 0..(side + 1) * (side + 1) {
        let at = [corner % (side + 1), corner / (side + 1), 0].map(|x| x as f32);
        data.extend(at.iter().flat_map(|x| x.to_le_bytes()));
    }
    let positions = data.len();
    for square in 0..side * side {
        let a = square / side * (side + 1) + square % side;
        data.extend([a, a + 1, a + side + 1, a + 1, a + side + 2, a + side + 1].iter().flat_map(|x| x.to_le_bytes()));
    }
    let document = |shown: u32| {
        let mut document = document();
        document["nodes"] = (0..shown).map(|at| json!({ "mesh": 0, "translation": [0, 0, at] })).collect();
        document["scenes"][0]["nodes"] = (0..shown).collect();
        document["accessors"][0]["count"] = json!((side + 1) * (side + 1));
        document["accessors"][1] =
            json!({ "bufferView": 1, "componentType": 5125, "count": 6 * side * side, "type": "SCALAR" });
        document["bufferViews"] = json!([
            { "buffer": 0, "byteLength": positions },
            { "buffer": 0, "byteOffset": positions, "byteLength": data.len() - positions },
        ]);
        document["buffers"][0]["byteLength"] = json!(data.len());
        glb(&document, &data)
    };
    assert_eq!(mesh(&document(15)).triangles.len(), 300_000);
    // Not read here: 50 million triangles are the length of this test. Meshes of their own are refused as they are declared.
    let mut many = self::document();
    many["meshes"] =
        (0..2501).map(|_| json!({ "primitives": [{ "attributes": { "POSITION": 0 }, "mode": 5 }] })).collect();
    many["nodes"] = (0..2501).map(|mesh| json!({ "mesh": mesh })).collect();
    many["scenes"][0]["nodes"] = (0..2501).collect();
    many["accessors"][0]["count"] = json!(1 << 20);
    many["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert!(error(&glb(&many, &self::data())).contains("elements of accessors without a view"));
}

/// Whatever the bytes, what comes back is a mesh that can be trusted, or one line.
fn check(name: &str, bytes: &[u8]) -> Result<(), TestCaseError> {
    match read(name, bytes) {
        Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1, "{}", error),
        Ok(Shape::Mesh(mesh)) => {
            prop_assert!(!mesh.triangles.is_empty() && mesh.positions.iter().all(|p| p.is_finite()));
            prop_assert!(mesh.triangles.as_flattened().iter().all(|&corner| (corner as usize) < mesh.positions.len()));
        }
        Ok(other) => prop_assert!(false, "{other:?}"),
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_give_a_mesh_or_one_line(
        changes in prop::collection::vec((0.0..1.0, 0..3_u8, any::<u8>()), 1..6), binary in any::<bool>()
    ) {
        let mut bytes = if binary { glb(&document(), &data()) } else { gltf(document(), &data()) };
        for (place, kind, byte) in changes {
            let at = (place * bytes.len() as f64) as usize;
            match kind {
                0 => bytes[at] = b'0' + byte % 10,
                1 => bytes[at] ^= 1 << (byte % 8),
                _ => bytes[at] = byte,
            }
        }
        check("a.glb", &bytes)?;
    }

    #[test]
    fn numbers_anywhere_in_a_document_give_a_mesh_or_one_line(
        changes in prop::collection::vec((any::<prop::sample::Index>(), prop_oneof![0..80_u64, any::<u64>()]), 1..4)
    ) {
        let text = document().to_string();
        let mut words: Vec<String> = Vec::new(); // numbers, and what is between them
        for digit in text.chars() {
            match words.last_mut() {
                Some(word) if word.ends_with(|last: char| last.is_ascii_digit()) == digit.is_ascii_digit() => word.push(digit),
                _ => words.push(digit.into()),
            }
        }
        let numbers: Vec<usize> = (0..words.len()).filter(|at| words[*at].ends_with(|c: char| c.is_ascii_digit())).collect();
        for (at, value) in changes {
            words[numbers[at.index(numbers.len())]] = value.to_string();
        }
        let json = chunk(b"JSON", words.concat().into_bytes(), b' ');
        let chunks = [json, chunk(b"BIN\0", data(), 0)].concat();
        check("a.glb", &[b"glTF\x02\0\0\0", &(chunks.len() as u32 + 12).to_le_bytes()[..], &chunks].concat())?;
    }
}
