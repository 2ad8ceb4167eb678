//! glTF and GLB.

use super::{assert_close, folder, noted_mesh, painted};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;
use hypertexture_shape::{Mesh, ShapeError, read_noted};
use serde_json::{Value, json};

/// A tetrahedron with legs of 1 and a color of bytes at each vertex, under a node.
fn document() -> Value {
    let places = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f32]];
    let mut bytes: Vec<u8> = places.as_flattened().iter().flat_map(|part| part.to_le_bytes()).collect();
    bytes.extend([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3_u16].iter().flat_map(|corner| corner.to_le_bytes()));
    bytes.extend([[128, 64, 0, 255]; 4].as_flattened());
    json!({
        "asset": { "version": "2.0" },
        "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR" },
            { "bufferView": 2, "componentType": 5121, "count": 4, "type": "VEC4" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 24 },
            { "buffer": 0, "byteOffset": 72, "byteLength": 16 },
        ],
        "buffers": [{
            "byteLength": 88,
            "uri": format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes)),
        }],
    })
}

fn read(document: &Value) -> Result<(Mesh, String), ShapeError> {
    read_noted("a.gltf", document.to_string().as_bytes()).map(noted_mesh)
}

/// The volume of a document, and its notes.
fn volume(edit: impl Fn(&mut Value)) -> (f64, String) {
    let mut document = document();
    edit(&mut document);
    let (mesh, notes) = read(&document).unwrap_or_else(|error| panic!("{error}"));
    ((6e6 * mesh.signed_volume()).round() / 1e6, notes)
}

#[test]
fn matrices_and_rotations_may_be_rounded() {
    let mut matrix = [1.0, 0.0, 0.0, 1e-9, 0.0, 1.0, 0.0, -1e-7, 0.0, 0.0, 1.0, 0.0, 5.0, 0.0, 0.0, 1.000_000_1];
    assert_eq!(volume(|all| all["nodes"][0]["matrix"] = json!(matrix)), (1.0, String::new()));
    matrix[15] = 2.0;
    let mut wrong = document();
    wrong["nodes"][0]["matrix"] = json!(matrix);
    assert!(read(&wrong).unwrap_err().to_string().contains("nodes[0].matrix: expected 0, 0, 0, 1 as its last row"));
    let found = volume(|all| all["nodes"][0]["rotation"] = json!([0, 0, 0, 0]));
    assert_eq!(found, (1.0, "rotations of 0, 0, 0, 0 are read as none".into()));
}

#[test]
fn optional_compression_is_passed_over_beside_plain_data() {
    let draco = |all: &mut Value| {
        all["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
        all["meshes"][0]["primitives"][0]["extensions"] =
            json!({ "KHR_draco_mesh_compression": { "bufferView": 2, "attributes": { "POSITION": 0 } } });
    };
    let (found, notes) = volume(draco);
    assert_eq!(
        (found, notes.as_str()),
        (1.0, "`KHR_draco_mesh_compression` is optional: the plain data beside it is read")
    );
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let meshopt = |all: &mut Value| {
            all["bufferViews"][0]["extensions"] =
                json!({ name: { "buffer": 0, "byteLength": 9, "byteStride": 12, "count": 4 } });
        };
        let (found, notes) = volume(meshopt);
        assert!(found == 1.0 && notes.starts_with(&format!("`{name}` is optional")), "{notes}");
        // A buffer of a fallback that is not there, and a required extension.
        let (mut absent, mut required) = (document(), document());
        meshopt(&mut absent);
        absent["buffers"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "byteLength": 48, "extensions": { name: { "fallback": true } } }));
        absent["bufferViews"][0]["buffer"] = json!(1);
        meshopt(&mut required);
        required["extensionsRequired"] = json!([name]);
        for refused in [absent, required] {
            let error = read(&refused).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains("unpack it first"), "{error}");
        }
    }
    let mut without = document();
    draco(&mut without);
    without["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert!(read(&without).unwrap_err().to_string().contains("KHR_draco_mesh_compression"));
}

#[test]
fn required_extensions_may_be_unknown_where_nothing_uses_them() {
    let known = volume(|all| {
        all["extensionsRequired"] = json!(["EXT_mesh_features", "KHR_materials_unlit", "KHR_xmp_json_ld"]);
        all["meshes"][0]["primitives"][0]["extensions"] = json!({ "EXT_mesh_features": { "featureIds": [] } });
    });
    assert_eq!(known, (1.0, String::new()));
    let unused = volume(|all| all["extensionsRequired"] = json!(["ACME_new"]));
    assert_eq!(unused, (1.0, "the required extension `ACME_new` is unknown, and nothing in the file uses it".into()));
    let mut used = document();
    used["extensionsRequired"] = json!(["ACME_new"]);
    used["nodes"][0]["extensions"] = json!({ "ACME_new": {} });
    assert!(read(&used).unwrap_err().to_string().contains("extensionsRequired[0]: the extension `ACME_new`"));
}

#[test]
fn a_skinned_mesh_ignores_its_node() {
    let (mesh, notes) = {
        let mut all = document();
        all["nodes"] = json!([{ "mesh": 0, "skin": 0, "translation": [100, 0, 0], "scale": [5, 5, 5] }, {}]);
        all["skins"] = json!([{ "joints": [1] }]);
        read(&all).unwrap()
    };
    assert_eq!(mesh.bounds().max + mesh.offset.as_vec3(), Vec3::ONE);
    assert_eq!(notes, "skins are not applied, their meshes keep the pose in which they were bound: 1");
}

#[test]
fn parts_that_draw_nothing_are_left_out() {
    let empty = volume(|all| {
        all["accessors"].as_array_mut().unwrap().push(json!({ "componentType": 5123, "count": 0, "type": "SCALAR" }));
        let primitives = all["meshes"][0]["primitives"].as_array_mut().unwrap();
        primitives.push(json!({ "attributes": { "POSITION": 0 }, "indices": 3 }));
    });
    assert_eq!(empty, (1.0, "primitives without vertices or indices are left out: 1".into()));
    for mesh in [json!({}), json!({ "name": "x", "primitives": [] })] {
        assert_eq!(volume(|all| all["meshes"].as_array_mut().unwrap().push(mesh.clone())), (1.0, String::new()));
        let mut used = document();
        used["meshes"][0] = mesh.clone();
        assert!(read(&used).unwrap_err().to_string().contains("meshes[0]: expected 1 primitive or more"));
    }
}

#[test]
fn a_material_that_cuts_parts_away_is_noted() {
    let with = |mode: &str| {
        volume(|all| {
            all["materials"] = json!([{}, { "alphaMode": mode }]);
            all["meshes"][0]["primitives"][0]["material"] = json!(1);
        })
    };
    assert_eq!(with("OPAQUE"), (1.0, String::new()));
    assert_eq!(
        with("MASK"),
        (1.0, "cut-outs by alphaMode MASK are not applied, their primitives stay whole: 1".into())
    );
}

#[test]
fn json_may_end_in_zeros_and_lengths_may_be_unknown() {
    let mut json = document().to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4) + 4, 0);
    let glb = |declared: u32| {
        let chunk = [&(json.len() as u32).to_le_bytes()[..], b"JSON", &json].concat();
        [b"glTF\x02\0\0\0", &declared.to_le_bytes()[..], &chunk].concat()
    };
    let length = glb(0).len() as u32;
    for (declared, note) in [(length, ""), (0, "its length is declared as 0: the whole file is read")] {
        let (mesh, notes) = noted_mesh(read_noted("a.glb", &glb(declared)).unwrap());
        assert_eq!((mesh.triangles.len(), notes.as_str()), (4, note));
    }
    // A line break within base64.
    let broken = volume(|all| {
        let uri = all["buffers"][0]["uri"].as_str().unwrap().to_string();
        all["buffers"][0]["uri"] = json!(format!("{}\n{}", &uri[..60], &uri[60..]));
    });
    assert_eq!(broken.0, 1.0);
}

#[test]
fn bytes_that_are_not_normalized_are_colors_of_0_to_255() {
    for normalized in [false, true] {
        let mut all = document();
        all["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(2);
        all["accessors"][2]["normalized"] = json!(normalized);
        let (mesh, notes) = read(&all).unwrap();
        assert_close(mesh.colors[0], [128.0 / 255.0, 64.0 / 255.0, 0.0], "COLOR_0");
        let note = if normalized { "" } else { "COLOR_0 of whole numbers without `normalized` is read as 0 to 255" };
        assert_eq!(notes, note);
    }
}

#[test]
fn specular_glossiness_has_a_color() {
    let color = |materials: Value| {
        let mut all = document();
        all["materials"] = json!([materials]);
        all["meshes"][0]["primitives"][0]["material"] = json!(0);
        let desk = folder(&[("a.gltf", all.to_string().as_bytes())]);
        let (mesh, _) = painted(&desk.path().join("a.gltf"));
        mesh.vertex_colors().first().copied()
    };
    let diffuse = json!({ "KHR_materials_pbrSpecularGlossiness": { "diffuseFactor": [0.5, 0.25, 0, 1] } });
    assert_eq!(color(json!({ "extensions": diffuse })), Some([0.5, 0.25, 0.0]));
    let both = json!({ "extensions": diffuse, "pbrMetallicRoughness": { "baseColorFactor": [0, 1, 0, 1] } });
    assert_eq!(color(both), Some([0.0, 1.0, 0.0]));
}

#[test]
fn data_of_other_machines_are_found_beside_the_file() {
    let mut all = document();
    let uri = all["buffers"][0]["uri"].as_str().unwrap().rsplit(',').next().unwrap().to_string();
    let bytes = STANDARD.decode(uri).unwrap();
    for name in ["file:///C:/Users/nobody/a.bin", r"C:\models\a.bin", "/home/nobody/a.bin", "../a.bin", "buffers/A.BIN"]
    {
        all["buffers"][0]["uri"] = json!(name);
        let desk = folder(&[("a.gltf", all.to_string().as_bytes()), ("a.bin", &bytes)]);
        let (mesh, notes) = painted(&desk.path().join("a.gltf"));
        assert_eq!(mesh.triangles.len(), 4, "{name}");
        assert!(notes.ends_with("is read from `a.bin` beside it"), "{notes}");
    }
}
