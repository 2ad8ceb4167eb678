//! Refused files with the expected messages.

use super::*;

/// Value at a place in the document, and the expected message.
type Wrong = (&'static str, Value, &'static str);

/// One wrong value each, by its place in the document.
fn wrong_values() -> Vec<Wrong> {
    let many = |count: usize| json!(vec![0; count]);
    vec![
        ("/asset", json!({}), "asset: expected a value of the glTF 2.0 schema, found no `version`"),
        ("/asset/version", json!("1.0"), "asset.version: version `1.0` is not supported; export it as glTF 2.0"),
        ("/asset/version", json!("20"), "asset.version: version `20` is not supported"),
        ("/asset/version", json!(2.0), "asset.version: expected a value of the glTF"),
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
        // It may be used under an escape.
        ("/extensionsRequired", json!(["X\u{1b}\n"]), "extensionsRequired[0]: the extension `X"),
        ("/scene", json!(1), "scene: expected the index of an existing entry, found 1 of 1, counted from 0"),
        ("/scene", json!(-1), "scene: expected a value of the glTF"),
        ("/scene", json!(0.5), "scene: expected a value of the glTF"),
        ("/scenes", json!({}), "scenes: expected a value of the glTF"),
        ("/scenes", json!([]), "scene: expected the index of"),
        ("/scenes/0/nodes/0", json!(1), "scenes[0].nodes[0]: expected the index of"),
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
        ("/nodes", json!([{ "children": [4_000_000_000_u32] }]), "nodes[0].children[0]: expected the index of"),
        ("/nodes/0", json!("a"), "nodes[0]: expected a value of the glTF"),
        ("/nodes/0/mesh", json!(1), "nodes[0].mesh: expected the index of an existing entry, found 1 of 1"),
        ("/nodes/0/mesh", json!("0"), "nodes[0].mesh: expected a value of the glTF"),
        ("/nodes/0/mesh", json!(1_u64 << 40), "nodes[0].mesh: expected a value of the glTF"),
        ("/nodes/0/matrix", json!([1, 0, 0]), "nodes[0].matrix: expected a value of the glTF"),
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
        ("/nodes/0/rotation", json!([0, 0, 0, 0.5]), "nodes[0].rotation: expected a rotation of length 1"),
        ("/nodes/0/rotation", json!([1, 1, 0, 0]), "nodes[0].rotation: expected a rotation of length 1"),
        ("/nodes/0/scale", json!([1, 1]), "nodes[0].scale: expected a value of the glTF"),
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
        ("/meshes/0", json!({}), "meshes[0]: expected 1 primitive or more, found no `primitives`"),
        ("/meshes/0/primitives", json!([]), "meshes[0]: expected 1 primitive or more"),
        ("/meshes/0/primitives/0/attributes", json!({}), "no triangles (primitives without positions are left out: 1)"),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(2),
            "meshes[0].primitives[0].attributes.POSITION: expected the",
        ),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(1), "accessors[1].type: expected `VEC3`, found `SCALAR`"),
        ("/meshes/0/primitives/0/indices", json!(2), "meshes[0].primitives[0].indices: expected the index of"),
        ("/meshes/0/primitives/0/indices", json!(0), "accessors[0].type: expected `SCALAR`, found `VEC3`"),
        ("/meshes/0/primitives/0/mode", json!(7), "meshes[0].primitives[0].mode: expected 0 to 6, found 7"),
        ("/meshes/0/primitives/0/mode", json!(1), "no triangles"),
        ("/accessors/0/bufferView", json!(2), "accessors[0].bufferView: expected the index of"),
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
        ("/accessors/0/count", json!(0), "no triangles (primitives without vertices or indices are left out: 1)"),
        ("/accessors/0/count", json!(-4), "accessors[0].count: expected a value of the glTF"),
        (
            "/accessors/0/count",
            json!(3),
            "accessors[1]: expected indices of vertices, and none that restarts a strip, found 3",
        ),
        ("/accessors/0/type", json!("VEC2"), "accessors[0].type: expected `VEC3`, found `VEC2`"),
        ("/accessors/0/type", json!(["VEC3"]), "accessors[0].type: expected a value of the glTF"),
        (
            "/accessors/1/componentType",
            json!(5126),
            "accessors[1].componentType: expected 5121, 5123 or 5125, found 5126",
        ),
        ("/accessors/1/componentType", json!(5122), "accessors[1].componentType: expected 5121, 5123 or 5125"),
        ("/accessors/1/componentType", json!(5125), "accessors[1].count: expected as many elements"),
        ("/accessors/1/byteOffset", json!(3), "accessors[1].byteOffset: expected a multiple of the size of a number"),
        ("/accessors/1/count", json!(2), "no triangles (corners of incomplete triangles are left out: 2)"),
        ("/accessors/1/normalized", json!(1), "accessors[1].normalized: expected a value of the glTF"),
        ("/bufferViews/0/buffer", json!(1), "bufferViews[0].buffer: expected the index of"),
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
        ("/buffers", json!([]), "bufferViews[0].buffer: expected the index of an existing entry, found 0 of 0"),
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

/// Inserts a value at a place, which may be new.
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
fn wrong_indices_and_sparse_values_are_located() {
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
        (json!(-1), &indices, &values, "accessors[0].sparse.count: expected a value of the glTF"),
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
            "accessors[0].sparse.values: expected a value of the glTF 2.0 schema, found no `bufferView`",
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
        ("{ \"asset\": {\n\"version\" 2 } }", "line 2: expected JSON, found `\"version\" 2` up to line 2, column 11"),
        ("{ \"asset\": 1e999 }", "line 1: expected JSON"),
        ("{ \"asset\": {} }", "asset: expected a value of the glTF 2.0 schema, found no `version`"),
        ("{ \"asset\": { \"version\": \"2.0\" } } x", "line 1: expected JSON"),
        ("{}", "header: expected a value of the glTF 2.0 schema, found no `asset`"),
        ("[\"asset\"]", "expected a value of the glTF"),
        ("{ \"asset\": { \"version\": \"2.0\", \"version\": \"2.0\" } }", "expected a value of the glTF"),
        ("\"asset\"", "header: expected a value of the glTF"),
        ("{ \"asset\": { \"version\": \"2.0\" }, \"nodes\": [], \"nodes\": [] }", "expected a value of the glTF"),
        ("{ \"asset\": { \"version\": \"2.0\" } }", "no triangles"),
        (
            "{ \"asset\": { \"version\": \"2.0\" }, \"nodes\": [{ \"children\": [1] }, { \"children\": [0] }] }",
            "nodes: expected a node without a parent",
        ),
    ] {
        let line = read("test.gltf", text.as_bytes()).unwrap_err().to_string();
        assert!(line.starts_with("test.gltf: ") && line.contains(said) && line.lines().count() == 1, "{text}: {line}");
    }
    // Ignored values may nest at any depth.
    let (open, close) = ("[".repeat(1_000_000), "]".repeat(1_000_000));
    let head = "{ \"asset\": { \"version\": \"2.0\" }, ";
    assert!(error(format!("{head}\"extras\": {open}{close} }}").as_bytes()).contains("no triangles"));
    assert!(error(format!("{head}\"extras\": {open} }}").as_bytes()).contains("line 1: expected JSON, found"));
    assert!(error(format!("{head}\"extras\": {open}").as_bytes()).contains("line 1: expected more JSON"));
    assert!(error(format!("{head}\"nodes\": {open}{close} }}").as_bytes()).contains("expected a value of the glTF"));
    for cut in 8..good.len() {
        let _ = error(&good[..cut]);
    }
}

#[test]
fn positions_that_are_not_finite_are_counted() {
    let mut data = data();
    data[16..20].copy_from_slice(&f32::NAN.to_le_bytes());
    let line = error(&glb(&document(), &data));
    assert!(line.contains("1 of 4 vertices are NaN, infinite or beyond 32-bit floats, the first has index"), "{line}");
}
