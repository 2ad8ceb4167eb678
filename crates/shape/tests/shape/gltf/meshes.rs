//! Files that are read.

use super::*;
use hypertexture_shape::{Opened, open, read_noted};
use serde_json::Map;
use std::fs;

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_duck_stands_where_its_node_puts_it() {
    let folder = std::env::var("HYPERTEXTURE_DATA").expect("HYPERTEXTURE_DATA names the folder with the data");
    let Opened { shape, notes, .. } = Opened::of(&format!("{folder}/duck.glb")).unwrap();
    let Shape::Mesh(duck) = shape else { panic!("no mesh") };
    assert_eq!((duck.triangles.len(), duck.positions.len(), duck.open_edges(), notes.len()), (4212, 2399, 0, 0));
    let bounds = duck.bounds();
    assert!(bounds.min.distance(Vec3::new(-0.6930, 0.0993, -0.6133)) < 1e-4, "{bounds:?}");
    assert!(bounds.max.distance(Vec3::new(0.9618, 1.6397, 0.5393)) < 1e-4, "{bounds:?}");
    assert!((duck.signed_volume() - 1.1958).abs() < 5e-5, "{}", duck.signed_volume());
}

#[test]
fn embedded_chunked_and_external_data_are_equal() {
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
fn triangles_strips_and_fans_have_equal_orientation() {
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
fn nodes_place_meshes_and_mirrored_ones_keep_orientation() {
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
    let at = |change: fn(&mut Map<String, Value>)| {
        let mesh = changed(|document| {
            document["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0, "translation": [5, 0, 0] }, { "children": [1] }]);
            document["scenes"] = json!([{ "nodes": [0] }, { "nodes": [2] }]);
            change(document.as_object_mut().unwrap());
        });
        (mesh.bounds().min.x, mesh.bounds().max.x, mesh.triangles.len())
    };
    assert_eq!(at(|_| ()), (0.0, 1.0, 4));
    assert_eq!(at(|document| document["scene"] = json!(1)), (5.0, 6.0, 4));
    assert_eq!(at(|document| drop(document.remove("scene"))), (0.0, 1.0, 4));
    assert_eq!(at(|document| document.retain(|name, _| !name.starts_with("scene"))), (0.0, 6.0, 8));
}

#[test]
fn interleaved_vertices_are_found_in_their_places() {
    // 4 bytes before, and behind each position an invalid normal.
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
fn sparse_accessors_replace_only_the_named_elements() {
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
fn only_skipped_geometry_is_noted() {
    let mut document = document();
    assert_eq!(read_noted("a.glb", &glb(&document, &data())).unwrap().notes, Vec::<String>::new());
    document["nodes"] = json!([{ "mesh": 0, "skin": 3, "camera": 9, "extensions": { "KHR_lights_punctual": { "light": 0 } },
            "children": [1] }, { "mesh": 0, "children": [2], "extensions": { "KHR_node_visibility": { "visible": false } } },
            { "mesh": 99 }]);
    document["extensionsRequired"] = json!(["KHR_node_visibility"]);
    document["animations"] = json!([{ "channels": [], "samplers": [] }]);
    let primitives = document["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives[0]["targets"] = json!([{ "POSITION": 99 }]);
    primitives[0]["material"] = json!(44);
    primitives[0]["attributes"]["NORMAL"] = json!(99);
    primitives.extend((0..4).map(|mode| json!({ "attributes": { "POSITION": 99 }, "mode": mode })));
    primitives.push(json!({ "attributes": { "_TEMPERATURE": 0 } }));
    // A strip of the first two corners, and the two corners behind a triangle that has no area.
    primitives.push(json!({ "attributes": { "POSITION": 0 }, "indices": 2, "mode": 5 }));
    primitives.push(json!({ "attributes": { "POSITION": 0 }, "indices": 3 }));
    document["accessors"].as_array_mut().unwrap().extend(
        [2, 5].map(|count| json!({ "bufferView": 2, "componentType": 5121, "count": count, "type": "SCALAR" })),
    );
    document["bufferViews"].as_array_mut().unwrap().push(json!({ "buffer": 0, "byteLength": 8 }));
    let Opened { shape, notes, .. } = read_noted("a.glb", &glb(&document, &data())).unwrap();
    let Shape::Mesh(mesh) = shape else { panic!("no mesh") };
    assert_tetrahedron(&mesh);
    let expected = [
        "primitives of points or lines are left out: 4",
        "primitives without positions are left out: 1",
        "corners of incomplete triangles are left out: 4",
        "skins are not applied, their meshes keep the pose in which they were bound: 1",
        "morph targets are not applied, their meshes keep their base shape: 1",
        "hidden nodes are left out, with all below them: 1",
        "animations are not played, nodes stand where they are at rest: 1",
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
