//! The parsers, each of any bytes: what it says does not matter, but it comes back, and what it gives can be trusted.

use blake3::Hash;
use glam::{DVec3, Mat3, Vec3};
use hypertexture::output::shard::{self, Shard, Whole};
use hypertexture::output::{Depth, Provenance, encode_png};
use hypertexture::render::{Frame, Measurements};
use hypertexture::scene::{self, Scene};
use hypertexture::shader::{Formula, Library, Slots, shipped};
use hypertexture::shape::{self, Content, Groom, Mesh, MeshFormat, Shape, Volume, VolumeFormat};
use hypertexture_measure::cases::library;
use std::path::PathBuf;
use std::sync::OnceLock;

/// A parser.
pub struct Target {
    pub name: &'static str,
    /// Accepted inputs.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Function under test.
    pub run: fn(&[u8]),
}

pub const TARGETS: [Target; 18] = [
    Target { name: "obj", seeds: || vec![OBJ.into()], run: |bytes| painted("a.obj", bytes) },
    Target { name: "stl", seeds: || vec![STL.into(), binary_stl()], run: |bytes| mesh(shape::read("a.stl", bytes)) },
    Target { name: "ply", seeds: || vec![PLY.into(), binary_ply()], run: |bytes| mesh(shape::read("a.ply", bytes)) },
    Target { name: "nrrd", seeds: || vec![NRRD.into(), ASCII.into()], run: |bytes| mesh(shape::read("a.nrrd", bytes)) },
    Target { name: "meta", seeds: || vec![META.into()], run: |bytes| mesh(shape::read("a.mha", bytes)) },
    Target {
        name: "nifti",
        seeds: || vec![nifti(false, b"n+1\0"), nifti(true, b"n+1\0"), nifti(false, b"ni1\0")],
        run: |bytes| mesh(shape::read("a.nii", bytes)),
    },
    Target { name: "gltf", seeds: || vec![GLTF.into(), glb()], run: |bytes| painted("a.gltf", bytes) },
    Target { name: "3mf", seeds: || vec![THREE_MF.into(), three_mf()], run: three_mf_of },
    Target { name: "vdb", seeds: || vec![vdb()], run: |bytes| mesh(shape::read("a.vdb", bytes)) },
    Target { name: "dicom", seeds: || vec![dicom()], run: |bytes| mesh(shape::read("a.dcm", bytes)) },
    Target { name: "texture", seeds: || vec![picture()], run: texture },
    Target { name: "groom", seeds: || vec![a_groom()], run: groom },
    Target { name: "scene", seeds: || vec![SCENE.into(), PRESET.into()], run: scene_of },
    Target { name: "value", seeds: || ["[1, 2.5, 3]", "\"#ffe0c0\"", "true"].map(Vec::from).into(), run: value },
    Target { name: "header", seeds: || vec![HEADER.into()], run: header },
    Target { name: "formula", seeds: || vec!["main | (ball & !cube) - rest".into()], run: formula },
    Target { name: "provenance", seeds: || vec![provenance().to_text().into()], run: provenance_of },
    Target { name: "shard", seeds: || vec![a_shard()], run: shard_of },
];

const OBJ: &str = "# a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1 1.0\nvn 0 0 1\nvt 0 0\no b\ng c\ns off\nf 1 2 3\nf 1/1 2/1 4/1\nf 1//1 3//1 4//1\nf -3 -2 -1 1\n";
const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
const PLY: &str = "ply\nformat ascii 1.0\ncomment a\nelement vertex 4\nproperty float x\nproperty double y\nproperty short z\nproperty list uchar int tags\nelement face 2\nproperty list uchar int vertex_indices\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0 0\n1 0 0 1 7\n0 1 0 0\n0 0 1 0\n3 0 1 2\n4 0 1 2 3\n8 0 1 2 3 -1 1 2 3\n";
const NRRD: &str =
    "NRRD0004\n# a\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 0.5\nencoding: raw\nkey:=value\n\n01234567";
const META: &str = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\nTransformMatrix = 1 0 0 0 1 0 0 0 -1\nOffset = 0 0 1\nElementSpacing = 1 1 0.5\nDimSize = 2 2 2\nElementType = MET_UCHAR\nHeaderSize = 0\nElementDataFile = LOCAL\n01234567";
const ASCII: &str = "NRRD0005\ntype: float\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: ascii\n\n0 1 2 3 4 5 6 7\n";
const SCENE: &str = "about = \"a\"\ncombine = \"main | b\"\n[object]\ninput = \"torus\"\nstretch = [1, 2, 1]\n[effect]\ndmf = [\"fur\"]\n[camera]\nclip = [1, 0, 0, 0.5]\n[transfer]\nstops = [{ at = 0.0, color = \"#000000\", density = 0.0, index = 1.0 }]\n[parts.b.object]\ninput = \"sphere\"\n[modules.dmf]\n";
const HEADER: &str = "// A.\n// Source: -\n// @param a = 0.5 in [0, 1]: A.\n// @color b = #102030: B.\n// @outer a\n// @move +y 0.5 * a + 1\n// @grow a\n// @drift a * 0.5\n// @bound 1\n// @needs normal\n// @groom length color\n// @exact procedural never\n// @loops 2\n// @places 1\n// @octaves 4\n// @period memory\n// @outside empty\n// @segments c\n#include \"hash.glsl\"\n#include <noise>\nfloat a_(float density, Sample s) { return density; }\n";
const RELATIONSHIPS: &str = "<Relationships><Relationship Target='/a' Type='http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel'/></Relationships>";
const THREE_MF: &str = "<?xml version='1.0'?><model unit='inch' requiredextensions='p' xmlns:p='/production/'><resources><basematerials id='3'><base name='a' displaycolor='#FF8000'/></basematerials><m:colorgroup id='4'><m:color color='#01020304'/></m:colorgroup><object id='1' name='a &amp; b'><mesh><vertices><vertex x='0' y='0' z='0'/><vertex x='1' y='0' z='0'/><vertex x='0' y='1' z='1e-3'/></vertices><triangles><triangle v1='0' v2='1' v3='2' pid='3' p1='0'/><triangle v1='0' v2='2' v3='1' pid='4' p1='0' p2='0' p3='0'/></triangles></mesh></object><object id='2'><components><component objectid='1' p:path='/a' transform='1 0 0 0 1 0 0 0 1 5 0 0'/></components></object></resources><build><item objectid='2'/></build></model>";
const PRESET: &str = "preset = \"fur\"\n[parameters]\nfineness = 60\n";

const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"children":[1],"scale":[1,-1,1]},{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,2,0,0,1]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":5,"material":0}]}],"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1]}}],"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":0}}}],"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":1,"byteLength":1}],"buffers":[{"byteLength":48,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/"}]}"#;

/// A groom whose every voxel differs.
fn a_groom() -> Vec<u8> {
    let (mut groom, mut bytes) = (Groom::unpainted("a", 32), Vec::new());
    (0..64).for_each(|index| groom.set(index, [index as f32 / 32.0; 9]));
    groom.write(&mut bytes).unwrap_or_else(|error| panic!("{error}"));
    bytes
}

fn groom(bytes: &[u8]) {
    if let Ok(groom) = Groom::from_bytes("a.nrrd", bytes) {
        assert!((0..groom.voxels()).all(|index| groom.at(index).iter().all(|value| value.abs() <= 2.0)));
    }
}

/// A tetrahedron.
fn glb() -> Vec<u8> {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let mut bytes = Vec::new();
    let mesh = Mesh { positions, triangles, offset: DVec3::new(1e6, 0.0, 0.0), ..Mesh::default() };
    MeshFormat::Glb.write(&mesh, &mut bytes).expect("memory takes all bytes");
    bytes
}

/// A tetrahedron.
fn three_mf() -> Vec<u8> {
    let mut bytes = Vec::new();
    if let Ok(Shape::Mesh(mesh)) = shape::read("a.glb", &glb()) {
        MeshFormat::ThreeMf.write(&mesh, &mut bytes).expect("memory takes all bytes");
    }
    bytes
}

/// A package, or the model of one.
fn three_mf_of(bytes: &[u8]) {
    if bytes.starts_with(b"PK") {
        return mesh(shape::read("a.3mf", bytes));
    }
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, content) in [("_rels/.rels", RELATIONSHIPS.as_bytes()), ("a", bytes)] {
        zip.start_file(name, zip::write::SimpleFileOptions::default()).expect("memory takes all bytes");
        std::io::Write::write_all(&mut zip, content).expect("memory takes all bytes");
    }
    mesh(shape::read("a.3mf", &zip.finish().expect("memory takes all bytes").into_inner()));
}

/// Two leaves.
fn vdb() -> Vec<u8> {
    let values = (0..60).map(|index| index as f32 % 7.0).collect();
    let (origin, steps, content) = (Vec3::splat(6.0), Mat3::IDENTITY, Content::Scalar);
    let volume = Volume { size: [3, 4, 5], origin, steps, values, content };
    let mut bytes = Vec::new();
    VolumeFormat::OpenVdb.write(&volume, &mut bytes).expect("memory takes all bytes");
    bytes
}

/// Two frames of 2 x 2 pixels of 16 bits.
fn dicom() -> Vec<u8> {
    let mut bytes = [&[0; 128][..], b"DICM"].concat();
    let mut put = |group: u16, number: u16, kind: &[u8; 2], value: &[u8]| {
        bytes.extend([group.to_le_bytes(), number.to_le_bytes(), *kind].concat());
        match kind {
            b"OW" => bytes.extend([&[0; 2][..], &(value.len() as u32).to_le_bytes()].concat()),
            _ => bytes.extend((value.len() as u16).to_le_bytes()),
        }
        bytes.extend(value);
    };
    put(2, 0, b"UL", &28_u32.to_le_bytes());
    put(2, 0x10, b"UI", b"1.2.840.10008.1.2.1\0");
    put(8, 0x60, b"CS", b"CT");
    put(0x18, 0x50, b"DS", b"2 ");
    put(0x28, 2, b"US", &[1, 0]);
    put(0x28, 4, b"CS", b"MONOCHROME2 ");
    put(0x28, 8, b"IS", b"2 ");
    put(0x28, 0x10, b"US", &[2, 0]);
    put(0x28, 0x11, b"US", &[2, 0]);
    put(0x28, 0x30, b"DS", b"1\\0.5 ");
    for (number, value) in [(0x100, 16), (0x101, 12), (0x102, 11), (0x103, 0)] {
        put(0x28, number, b"US", &[value, 0]);
    }
    put(0x28, 0x1052, b"DS", b"-1024 ");
    put(0x28, 0x1053, b"DS", b"1 ");
    put(0x7fe0, 0x10, b"OW", &[7; 16]);
    bytes
}

/// One triangle.
fn binary_ply() -> Vec<u8> {
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float \
                  z\nelement face 1\nproperty list uchar uint vertex_index\nend_header\n";
    let mut bytes = header.as_bytes().to_vec();
    bytes.extend([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0f32].iter().flat_map(|x| x.to_le_bytes()));
    bytes.push(3);
    bytes.extend([0u32, 1, 2].iter().flat_map(|x| x.to_le_bytes()));
    bytes
}

/// One triangle.
fn binary_stl() -> Vec<u8> {
    let mut bytes = [vec![0; 80], 1u32.to_le_bytes().to_vec()].concat();
    bytes.extend([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0f32].iter().flat_map(|x| x.to_le_bytes()));
    bytes.extend([0; 2]);
    bytes
}

/// NIfTI-1, 2 x 2 x 2 of 16 bits, by a qform and, where it is packed as well, by a sform.
fn nifti(packed: bool, magic: &[u8; 4]) -> Vec<u8> {
    let mut bytes = vec![0; 352];
    let mut put = |at: usize, part: &[u8]| bytes[at..at + part.len()].copy_from_slice(part);
    put(0, &348i32.to_le_bytes());
    for (at, number) in [(40, 3i16), (42, 2), (44, 2), (46, 2), (70, 4), (72, 16), (252, 1), (254, i16::from(packed))] {
        put(at, &number.to_le_bytes());
    }
    for (at, number) in [(76, 1f32), (80, 1.0), (84, 1.0), (88, 0.5), (108, 352.0), (112, 2.0), (116, -1.0), (256, 0.5)]
    {
        put(at, &number.to_le_bytes());
    }
    for (at, number) in [(280, 1f32), (300, -1.0), (320, 0.5)] {
        put(at, &number.to_le_bytes());
    }
    put(344, magic);
    bytes.extend(0..16);
    if !packed {
        return bytes;
    }
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut encoder, &bytes).expect("memory takes all bytes");
    encoder.finish().expect("memory takes all bytes")
}

fn provenance() -> Provenance {
    Provenance::of(&Scene::default(), "a device", &Measurements::default()).expect("a formula has no files")
}

fn a_shard() -> Vec<u8> {
    let size = [2, 2];
    let whole = Whole {
        identity: Hash::from_bytes([7; 32]),
        size,
        background: None,
        depth: Depth::Eight,
        provenance: provenance(),
    };
    let frame = Frame { size, pixels: vec![[0.25; 4]; 4], measurements: Default::default() };
    shard::encode(&whole, Shard::new(0, 1).expect("one of one"), &frame)
}

fn text(bytes: &[u8]) -> Option<String> {
    String::from_utf8(bytes.to_vec()).ok()
}

/// A picture in PNG.
fn picture() -> Vec<u8> {
    let frame = Frame { size: [2, 2], pixels: vec![[0.25, 0.5, 0.75, 1.0]; 4], measurements: Default::default() };
    encode_png(&frame, None, Depth::Eight, &provenance()).unwrap_or_else(|error| panic!("{error}"))
}

/// A triangle with this texture, as GLB.
fn texture(bytes: &[u8]) {
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}}]}}],"materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],"textures":[{{"source":0}}],"images":[{{"bufferView":1}}],"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"}}],"bufferViews":[{{"buffer":1,"byteLength":36}},{{"buffer":0,"byteLength":{}}}],"buffers":[{{"byteLength":{0}}},{{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}]}}"#,
        bytes.len()
    )
    .into_bytes();
    let mut binary = bytes.to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &binary)].concat();
    painted("a.glb", &[b"glTF\x02\0\0\0", &(chunks.len() as u32 + 12).to_le_bytes()[..], &chunks].concat());
}

/// A mesh that was read with its materials has finite colors.
fn painted(name: &str, bytes: &[u8]) {
    mesh(shape::read(name, bytes));
    match shape::read_painted(name, bytes) {
        Ok(Shape::Mesh(mesh)) => {
            let size = mesh.bounds().size().max_element();
            let points = mesh.colored_points(size).take(100);
            points.for_each(|(_, color)| assert!(color.iter().all(|part| part.is_finite())));
        }
        Ok(_) => unreachable!("a file of meshes"),
        Err(error) => one_line(&error.to_string()),
    }
}

/// An object that was read is finite and in range.
fn mesh(read: Result<Shape, shape::ShapeError>) {
    match read {
        Ok(Shape::Mesh(mesh)) => {
            assert!(mesh.positions.iter().all(|position| position.is_finite()));
            assert!(mesh.triangles.as_flattened().iter().all(|corner| (*corner as usize) < mesh.positions.len()));
        }
        Ok(Shape::Volume(volume)) => {
            let count: u64 = volume.size.iter().map(|side| u64::from(*side)).product();
            assert_eq!(volume.values.len() as u64, count);
            assert!(volume.values.iter().all(|value| value.is_finite()));
            assert!(volume.spacing().min_element() > 0.0 && volume.origin.is_finite());
        }
        Ok(Shape::Solid(_)) => unreachable!("a file is no formula"),
        Err(error) => one_line(&error.to_string()),
    }
}

fn one_line(line: &str) {
    assert!(!line.contains('\n'), "{line}");
}

/// A scene that is read is checked, and comes back as it was from its own text.
fn scene_of(bytes: &[u8]) {
    let Some(text) = text(bytes) else { return };
    static LIBRARY: OnceLock<Library> = OnceLock::new();
    match scene::parse(&text, "a.toml") {
        Ok(scene) => match scene.check(LIBRARY.get_or_init(library)) {
            Ok(_) => {
                let again = scene::parse(&scene::to_text(&scene), "again");
                assert_eq!(again.as_ref().ok(), Some(&scene), "{again:?}");
            }
            Err(error) => one_line(&error.to_string()),
        },
        Err(error) => one_line(&error.to_string()),
    }
}

fn value(bytes: &[u8]) {
    let Some(text) = text(bytes) else { return };
    for field in ["camera.zoom", "object.stretch", "light.color", "effect.dmf", "quality.msaa", "camera.clip"] {
        if let Err(error) = Scene::default().set_field(field, &text) {
            assert!(!error.to_string().contains("panicked"));
        }
    }
}

fn formula(bytes: &[u8]) {
    if let Some(Err(error)) = text(bytes).map(|text| Formula::parse(&text)) {
        assert!(!error.to_string().is_empty());
    }
}

fn provenance_of(bytes: &[u8]) {
    if let Some(Err(error)) = text(bytes).map(|text| Provenance::from_text(&text)) {
        one_line(&error.to_string());
    }
}

/// Headers, and what they include, as a module of a slot.
fn header(bytes: &[u8]) {
    let Some(text) = text(bytes) else { return };
    let library = shipped().with_module("dmf", "a", &text);
    let slots: Slots = [("noise", "procedural"), ("weights", "quintic"), ("wrap", "repeat")]
        .map(|(slot, module)| (slot.to_string(), vec![module.to_string()]))
        .into();
    if let Err(error) = library.declarations(&["dmf/a.glsl"], &slots) {
        assert!(!error.to_string().contains('\n') || text.contains('\r'), "{error}");
    }
}

/// A shard, in a file of its own.
fn shard_of(bytes: &[u8]) {
    thread_local!(static FOLDER: tempfile::TempDir = tempfile::tempdir().expect("a folder for files that vanish"));
    let path: PathBuf = FOLDER.with(|folder| folder.path().join("a.shard"));
    std::fs::write(&path, bytes).expect("a file in that folder");
    if let Err(error) = shard::merge(&[path]) {
        one_line(&error.to_string());
    }
}
