//! PLY: every encoding, order and type gives the mesh; errors are one line with the place.

use hypertexture_shape::{self, Mesh, Shape, ShapeError};
use std::time::Instant;

/// Encoding of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Encoding {
    Text,
    Little,
    Big,
}

const ENCODINGS: [(Encoding, &str); 3] =
    [(Encoding::Text, "ascii"), (Encoding::Little, "binary_little_endian"), (Encoding::Big, "binary_big_endian")];

/// Types by both names, with their size and whether they are floats.
const TYPES: [(&str, &str, usize, bool); 10] = [
    ("char", "int8", 1, false),
    ("uchar", "uint8", 1, false),
    ("short", "int16", 2, false),
    ("ushort", "uint16", 2, false),
    ("int", "int32", 4, false),
    ("uint", "uint32", 4, false),
    ("long", "int64", 8, false),
    ("ulong", "uint64", 8, false),
    ("float", "float32", 4, true),
    ("double", "float64", 8, true),
];

/// Encoded number.
fn number(encoding: Encoding, kind: &str, value: f64) -> Vec<u8> {
    let (_, _, bytes, is_float) = *TYPES.iter().find(|(old, new, ..)| [old, new].contains(&&kind)).unwrap();
    let mut little = match (encoding, bytes, is_float) {
        (Encoding::Text, ..) => return format!("{value} ").into_bytes(),
        (_, 4, true) => (value as f32).to_le_bytes().to_vec(),
        (_, _, true) => value.to_le_bytes().to_vec(),
        _ => (value as i64).to_le_bytes()[..bytes].to_vec(),
    };
    if encoding == Encoding::Big {
        little.reverse();
    }
    little
}

/// Box of six quads, with ignored properties and elements around and between.
fn cube(encoding: Encoding, name: &str, [coordinate, length, index]: [&str; 3]) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {name} 1.0\ncomment a box\nobj_info made by hand\nelement camera 2\nproperty short view\nproperty list \
         uchar float lens\nelement vertex 8\nproperty uchar red\nproperty {coordinate} z\nproperty list uchar int tags\n\
         property {coordinate} x\nproperty float nx\nproperty {coordinate} y\nelement face 6\nproperty uchar shade\nproperty \
         list {length} {index} vertex_indices\nproperty double weight\nend_header\n"
    )
    .into_bytes();
    let mut put = |kind: &str, value: f64| bytes.extend(number(encoding, kind, value));
    for view in 0..2 {
        put("short", -300.0);
        put("uchar", f64::from(view));
        (0..view).for_each(|_| put("float", 0.5));
    }
    for corner in 0..8 {
        let at = |bit: i32| f64::from(corner >> bit & 1) * 3.0;
        put("uchar", 200.0);
        put(coordinate, at(2));
        put("uchar", 1.0);
        put("int", -7.0);
        put(coordinate, at(0));
        put("float", f64::NAN);
        put(coordinate, at(1));
    }
    for face in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        put("uchar", 9.0);
        put(length, 4.0);
        face.iter().for_each(|&corner| put(index, f64::from(corner)));
        put("double", 1e300);
    }
    bytes
}

fn mesh(bytes: &[u8]) -> Mesh {
    match hypertexture_shape::read("test.ply", bytes) {
        Ok(Shape::Mesh(mesh)) => mesh,
        other => panic!("{other:?}"),
    }
}

fn error(bytes: &[u8]) -> String {
    let line = hypertexture_shape::read("test.ply", bytes).unwrap_err().to_string();
    assert!(line.starts_with("test.ply: ") && !line.contains('\n'), "{line}");
    line
}

#[test]
fn every_encoding_and_every_type_gives_the_same_box() {
    for (encoding, name) in ENCODINGS {
        for (old, new, _, is_float) in TYPES {
            for kind in [old, new] {
                let index = if is_float { "int" } else { kind };
                let length = if is_float { "uchar" } else { kind };
                let mesh = mesh(&cube(encoding, name, [kind, length, index]));
                assert_eq!((mesh.positions.len(), mesh.triangles.len()), (8, 12), "{name}, {kind}");
                assert_eq!((mesh.signed_volume(), mesh.open_edges()), (27.0, 0), "{name}, {kind}");
            }
        }
    }
}

#[test]
fn faces_may_come_first_and_lines_may_end_as_on_windows() {
    let text = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\nelement vertex 3\nproperty float \
                x\nproperty float y\nproperty float z\nend_header\n3 0 1 2\n0 0 0 1 0 0\n\n  0 1 0";
    let [unix, windows] = [text.to_string(), text.replace('\n', "\r\n")].map(|text| mesh(text.as_bytes()));
    assert_eq!((unix.triangles.as_slice(), unix.positions.len()), (&[[0, 1, 2]][..], 3));
    assert_eq!((unix.triangles, unix.positions), (windows.triangles, windows.positions));
}

#[test]
fn strips_turn_every_other_triangle_and_begin_anew() {
    // A square of two triangles, another one beside it, all seen from the same side.
    let text = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement tristrips \
                1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 0 0\n3 0 0\n2 1 0\n3 1 0\n\
                9 0 1 2 3 -1 4 5 6 7\n";
    let mesh = mesh(text.as_bytes());
    assert_eq!(mesh.triangles.len(), 4);
    for at in 0..4 {
        let [a, b, c] = mesh.corners(at);
        let normal = (b - a).cross(c - a);
        assert!(normal.z == 1.0 && normal.x == 0.0 && normal.y == 0.0, "{at}: {normal}");
    }
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let good = String::from_utf8(cube(Encoding::Text, "ascii", ["float", "uchar", "int"])).unwrap();
    for (from, to, said) in [
        ("format ascii 1.0\n", "", "header: expected `format ascii 1.0`"),
        ("ascii 1.0", "ascii 2.0", "line 2: expected a line of a PLY header"),
        ("ascii 1.0", "utf8 1.0", "line 2: expected `ascii`, `binary_little_endian`"),
        ("element vertex 8", "element vertex many", "line 8: expected `element NAME COUNT`"),
        ("element vertex 8", "element vertex 18446744073709551615", "the header declares"),
        ("element vertex 8", "element vertex 7", "expected"),
        ("element face 6", "element face 7", "expected more numbers, found the end of the file"),
        ("property float z", "property float depth", "numbers x, y and z"),
        ("property float z", "property half z", "line 10: expected `property TYPE NAME`"),
        ("vertex_indices", "corners", "a list `vertex_indices`"),
        ("end_header\n", "", "a line of a PLY header"),
        ("4 0 2 3 1", "4 0 2 3 8", "face 0 (from 0): expected the index of a vertex, found vertex 8 of 8"),
        ("4 0 2 3 1", "4 0 2 3 -1", "expected the index of a vertex, found -1"),
        ("4 0 2 3 1", "4 0 2 3 0.5", "expected the index of a vertex, found 0.5"),
        ("4 0 2 3 1", "4000000000 0 2 3 1", "expected a list that is in the file"),
        ("4 0 2 3 1", "-4 0 2 3 1", "expected a list that is in the file"),
        ("4 0 2 3 1", "two 0 2 3 1", "expected a number, found `two`"),
        ("200 0 1 -7 0 ", "200 inf 1 -7 0 ", "1 of 8 vertices are NaN, infinite"),
    ] {
        let bad = good.replacen(from, to, 1);
        assert_ne!(bad, good, "{from}");
        let line = error(bad.as_bytes());
        assert!(line.contains(said), "{from} -> {to}: {line}");
    }
    assert!(error(b"ply\nformat ascii 1.0\nend_header\n").contains("no triangles"));
    assert!(error(b"ply\nproperty float x\n").contains("line 2: expected an `element` before"));
}

#[test]
fn degenerate_faces_and_trailing_data_are_noted_and_skipped() {
    for (encoding, name) in ENCODINGS {
        let good = cube(encoding, name, ["float", "uchar", "int"]);
        let header = b"element face 6";
        let at = good.windows(header.len()).position(|window| window == header).unwrap();
        let mut bytes = good.clone();
        bytes[at + header.len() - 1] = b'8';
        for count in [0, 2] {
            for (kind, value) in [("uchar", 9.0), ("uchar", f64::from(count))] {
                bytes.extend(number(encoding, kind, value));
            }
            (0..count).for_each(|corner| bytes.extend(number(encoding, "int", f64::from(corner))));
            bytes.extend(number(encoding, "double", 1.0));
        }
        assert_eq!(mesh(&bytes).signed_volume(), 27.0, "{name}");
        let notes = |bytes: &[u8]| hypertexture_shape::read_noted("test.ply", bytes).unwrap().notes;
        assert_eq!(notes(&bytes), ["faces and strips of fewer than 3 corners are left out: 2"], "{name}");
        let tailed = [&good[..], b"more"].concat();
        let more = if encoding == Encoding::Text { " more" } else { "more" }.len();
        assert_eq!(notes(&tailed), [format!("bytes after the last element are left out: {more}")], "{name}");
        assert_eq!(notes(&good), [""; 0]);
    }
    assert_eq!(
        hypertexture_shape::read_noted(
            "a.ply",
            &[&cube(Encoding::Text, "ascii", ["float", "uchar", "int"])[..], b"\n \r\n"].concat()
        )
        .unwrap()
        .notes,
        [""; 0]
    );
}

#[test]
fn a_file_that_is_cut_anywhere_is_refused() {
    for (encoding, name) in ENCODINGS {
        let bytes = cube(encoding, name, ["float", "uchar", "int"]);
        // The last number is nothing of the surface, but it is declared; of a text its last digits may go.
        let last = if encoding == Encoding::Text { 302 } else { 1 };
        for cut in 4..bytes.len() - last {
            error(&bytes[..cut]);
        }
    }
}

#[test]
fn what_a_header_only_declares_takes_no_memory() {
    let huge = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty \
                float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n";
    assert!(matches!(
        hypertexture_shape::read("x.ply", huge.as_bytes()),
        Err(ShapeError::DataSize { declared: 48_000_000_000, .. })
    ));
    let nothing = "ply\nformat ascii 1.0\nelement nothing 18446744073709551615\nend_header\n";
    assert!(error(nothing.as_bytes()).contains("no triangles"));
    let list = "ply\nformat binary_little_endian 1.0\nelement other 1\nproperty list uint double values\nend_header\n";
    let bytes = [list.as_bytes(), &u32::MAX.to_le_bytes(), &[0; 64]].concat();
    assert!(error(&bytes).contains("expected a list that is in the file, found 4294967295 numbers of `values`"));
}

/// Grid of quads over a wave, and its number of triangles.
fn wave(side: u32) -> (Vec<u8>, usize) {
    let count = (side + 1) * (side + 1);
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        side * side
    )
    .into_bytes();
    for at in 0..count {
        let (x, y) = ((at % (side + 1)) as f32, (at / (side + 1)) as f32);
        bytes.extend([x, y, (0.1 * x).sin()].into_iter().flat_map(f32::to_le_bytes));
    }
    for at in 0..side * side {
        let corner = at / side * (side + 1) + at % side;
        bytes.push(4);
        bytes.extend([corner, corner + 1, corner + side + 2, corner + side + 1].into_iter().flat_map(u32::to_le_bytes));
    }
    (bytes, 2 * (side * side) as usize)
}

#[test]
fn three_hundred_thousand_triangles_are_read() {
    let (bytes, triangles) = wave(390);
    let start = Instant::now();
    let mesh = mesh(&bytes);
    println!("{triangles} triangles in {:.0} ms", start.elapsed().as_secs_f64() * 1e3);
    assert_eq!(mesh.triangles.len(), triangles);
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn a_real_mesh_is_the_same_as_obj_and_as_ply() {
    let folder = std::env::var("HYPERTEXTURE_DATA").expect("HYPERTEXTURE_DATA names the folder with the data");
    let Ok(Shape::Mesh(bunny)) = hypertexture_shape::open(&format!("{folder}/stanford_bunny.obj")) else {
        panic!("no mesh")
    };
    for (encoding, name) in ENCODINGS {
        let mut bytes = format!(
            "ply\nformat {name} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\n\
             property list uchar int vertex_indices\nend_header\n",
            bunny.positions.len(),
            bunny.triangles.len()
        )
        .into_bytes();
        let mut line = |numbers: &[(&str, f64)]| {
            numbers.iter().for_each(|(kind, value)| bytes.extend(number(encoding, kind, *value)));
            bytes.extend(if encoding == Encoding::Text { "\n" } else { "" }.as_bytes());
        };
        for position in &bunny.positions {
            line(&position.to_array().map(|value| ("float", f64::from(value))));
        }
        for [a, b, c] in bunny.triangles.iter().map(|triangle| triangle.map(f64::from)) {
            line(&[("uchar", 3.0), ("int", a), ("int", b), ("int", c)]);
        }
        let read = mesh(&bytes);
        assert!(read.positions == bunny.positions && read.triangles == bunny.triangles, "{name}");
    }
}
