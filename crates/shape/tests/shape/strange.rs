//! Variations of text files: byte order marks, line ends, comments, and paths that end in a backslash.

use hypertexture_shape::{Facts, Mesh, Shape, read, read_noted};

/// A box of 2 x 1 x 0.5, with `face` before the corners of each face.
fn cuboid(face: &str) -> String {
    let vertices = "v 0 0 0\nv 2 0 0\nv 0 1 0\nv 2 1 0\nv 0 0 .5\nv 2 0 .5\nv 0 1 .5\nv 2 1 .5\n";
    let faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"];
    vertices.to_owned() + &faces.map(|corners| format!("{face} {corners}\n")).concat()
}

fn mesh(name: &str, bytes: &[u8]) -> Mesh {
    match read(name, bytes) {
        Ok(Shape::Mesh(mesh)) => mesh,
        other => panic!("{name}: {other:?}"),
    }
}

/// The volume of a closed mesh in OBJ, to 1e-9.
fn volume(text: &str) -> f64 {
    let mesh = mesh("test.obj", text.as_bytes());
    assert_eq!(mesh.open_edges(), 0, "{text}");
    (mesh.signed_volume() * 1e9).round() / 1e9
}

/// Text files of all formats, each of one triangle or two samples.
const TEXTS: [(&str, &str); 6] = [
    ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    ("a.stl", "solid a\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n"),
    (
        "a.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
         property list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    ),
    (
        "a.gltf",
        r#"{"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36,
        "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#,
    ),
    ("a.nrrd", "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 1 1\nencoding: ascii\nspacings: 1 1 1\n\n3 5\n"),
    (
        "a.mha",
        "ObjectType = Image\nNDims = 3\nDimSize = 2 1 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n\u{3}\u{5}",
    ),
];

/// Corners or values of a file.
fn held(name: &str, bytes: &[u8]) -> Vec<f32> {
    match read_noted(name, bytes).unwrap_or_else(|error| panic!("{error}")).shape {
        Shape::Mesh(mesh) => {
            (0..mesh.triangles.len()).flat_map(|at| mesh.corners(at)).flat_map(|p| p.to_array()).collect()
        }
        Shape::Volume(volume) => volume.values,
        Shape::Solid(_) => panic!("{name}"),
    }
}

#[test]
fn a_byte_order_mark_is_no_part_of_any_text() {
    for (name, text) in TEXTS {
        let expected: &[f32] = match name {
            "a.nrrd" | "a.mha" => &[3.0, 5.0],
            _ => &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        };
        let unnamed = (name != "a.obj").then_some("no_extension");
        for name in [Some(name), unnamed].into_iter().flatten() {
            assert_eq!(held(name, text.as_bytes()), expected, "{name}");
            assert_eq!(held(name, format!("\u{feff}{text}").as_bytes()), expected, "{name}");
        }
        let utf_16: Vec<u8> = format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect();
        let line = read(name, &utf_16).unwrap_err().to_string();
        assert!(line.starts_with(&format!("{name}: byte 0: expected text in UTF-8, found text in UTF-16;")), "{line}");
    }
    // A first vertex that was lost without a word.
    assert_eq!(volume(&format!("\u{feff}{}", cuboid("f"))), 1.0);
}

#[test]
fn lines_end_as_on_any_system() {
    for (name, text) in TEXTS {
        let expected = held(name, text.as_bytes());
        for end in ["\r", "\r\n"] {
            assert_eq!(held(name, text.replace('\n', end).as_bytes()), expected, "{name} {end:?}");
        }
    }
    // One return within a comment ends no line.
    assert_eq!(volume(&format!("# made\rby hand\n{}", cuboid("f"))), 1.0);
    let line = read("a.obj", cuboid("f").replace("2 4 8 6", "2 4 x 6").replace('\n', "\r").as_bytes()).unwrap_err();
    assert!(line.to_string().starts_with("a.obj: line 14: expected a vertex index"), "{line}");
}

#[test]
fn a_backslash_continues_numbers_not_comments_or_names() {
    for before in ["# C:\\parts\\", "g C:\\parts\\", "mtllib C:\\parts\\", "usemtl a\\ ", "o a \\", "v 0 0 0 # \\"] {
        assert_eq!(volume(&cuboid("f").replacen("f 1 3", &format!("{before}\nf 1 3"), 1)), 1.0, "{before}");
    }
    for joined in ["f 1 3 \\\n4 2", "f 1 3 \\ \n4 2", "f 1 3 \\\t\r\n4 2", "f\\\n1 3 4 \\ # one\n2", "\\\nf 1 3 4 2"] {
        assert_eq!(volume(&cuboid("f").replacen("f 1 3 4 2", joined, 1)), 1.0, "{joined:?}");
    }
    assert_eq!(volume(&cuboid("f").replacen("v 2 0 0", "v 2 \\ \n 0 0", 1)), 1.0);
}

#[test]
fn one_bad_face_is_left_out_with_a_line_and_outlines_are_faces() {
    let noted = |text: String| {
        assert_eq!(volume(&text), 1.0);
        read_noted("a.obj", text.as_bytes()).unwrap().notes
    };
    assert_eq!(noted(cuboid("f")), [""; 0]);
    assert_eq!(noted(cuboid("fo")), [""; 0]);
    for bad in ["f 1", "f", "f 1/1 2/2"] {
        let said = "faces of fewer than 3 corners are left out: 2, the first in line 15";
        assert_eq!(noted(format!("{}{bad}\n{bad}\n", cuboid("f"))), [said]);
    }
}

/// Line of `info` about an OBJ mesh.
fn fact(text: &str, about: &str) -> String {
    let file = tempfile::NamedTempFile::with_suffix(".obj").unwrap();
    std::fs::write(file.path(), text).unwrap();
    let facts = Facts::of(file.path().to_str().unwrap(), None).unwrap();
    facts.lines.into_iter().find(|line| line.name == about).unwrap().words
}

#[test]
fn volumes_are_those_of_the_solid_in_digits_that_count() {
    let faces = |text: &str| {
        text.lines().filter(|line| line.starts_with('f')).map(|line| format!("{line}\n")).collect::<String>()
    };
    let turned = |text: &str| {
        let turn =
            |line: &str| line.split(' ').skip(1).collect::<Vec<_>>().into_iter().rev().collect::<Vec<_>>().join(" ");
        faces(text).lines().map(|line| format!("f {}\n", turn(line))).collect::<String>()
    };
    let plain = cuboid("f");
    let twice = plain.clone() + &faces(&plain)[..20];
    let some_turned = plain.replace("f 1 3 4 2", "f 2 4 3 1").replace("f 1 5 7 3", "f 3 7 5 1");
    let both_ways = plain.clone() + &turned(&plain);
    let small = plain.replace("f", "#").replace("v 0 0 0", "v 0 0 0\nv .01 0 0\nv 0 .01 0\nv 0 0 .06")
        + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    for (text, volume, surface) in [
        (&plain, "1 cubic", "closed"),
        (&twice, "1 cubic", "closed; 4 triangles repeat others and count once"),
        (&some_turned, "1 cubic", "closed, but at "),
        (&small, "1e-6 cubic", "closed"),
        (&both_ways, "0 cubic", "it encloses nothing"),
        (&plain.replace(".5", "0"), "0 cubic", "it encloses nothing"),
    ] {
        assert!(fact(text, "volume").starts_with(volume), "{}", fact(text, "volume"));
        assert!(fact(text, "surface").starts_with(surface), "{}", fact(text, "surface"));
    }
    let tiny = "v 0 0 0\nv 2e-15 0 0\nv 0 1e-15 0\nv 0 0 5e-16\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    assert_eq!(fact(tiny, "box"), "(0, 0, 0) to (2e-15, 1e-15, 5e-16), 2e-15 x 1e-15 x 5e-16 world units");
    assert!(fact(tiny, "volume").starts_with("1.66667e-46 cubic"), "{}", fact(tiny, "volume"));
    let sheet = "v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n";
    assert!(fact(sheet, "surface").starts_with("open: 3 edges have one triangle; it encloses nothing"));
}
