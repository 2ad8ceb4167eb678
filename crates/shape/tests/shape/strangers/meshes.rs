//! PLY and STL, and colors through a conversion.

use super::{assert_close, light, noted_mesh};
use glam::Vec3;
use hypertexture_shape::{Looks, Mesh, MeshFormat, read_noted};

/// A triangle in PLY as text, with properties of the vertices and values after their places.
fn ply(properties: &str, values: &str) -> (Mesh, String) {
    let lines: String = ["0 0 0", "1 0 0", "0 1 0"].iter().map(|place| format!("{place} {values}\n")).collect();
    let text = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{properties}\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n{lines}3 0 1 2\n"
    );
    noted_mesh(read_noted("a.ply", text.as_bytes()).unwrap_or_else(|error| panic!("{error}")))
}

fn channels(kind: &str, names: [&str; 3]) -> String {
    names.map(|name| format!("property {kind} {name}\n")).concat()
}

#[test]
fn colors_of_ply_have_the_scale_of_their_values() {
    let (usual, full) = (["red", "green", "blue"], [light(128.0), light(64.0), 0.0]);
    let codes = "colors reach 128: read as codes of 0 to 255";
    for (kind, values, expected, note) in [
        ("uchar", "128 64 0", full, ""),
        ("int", "128 64 0", full, codes),
        ("uint", "128 64 0", full, codes),
        ("short", "128 64 0", full, codes),
        ("ushort", "128 64 0", full, codes),
        ("float", "128 64 0", full, codes),
        ("double", "128.0 64.0 0", full, codes),
        ("ushort", "32896 16448 0", full, "colors reach 32896: read as codes of 0 to 65535"),
        ("float", "0.5 0.25 0", [light(127.5), light(63.75), 0.0], ""),
    ] {
        let (mesh, notes) = ply(&channels(kind, usual), values);
        assert_close(mesh.colors[1], expected, kind);
        assert_eq!(notes, note, "{kind}");
    }
    for names in [["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]] {
        assert_close(ply(&channels("uchar", names), "128 64 0").0.colors[2], full, names[0]);
    }
}

#[test]
fn colors_of_faces_are_those_of_their_corners() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element face 2\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
        end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n";
    let (mesh, notes) = noted_mesh(read_noted("a.ply", text.as_bytes()).unwrap());
    let of = |triangle: usize| mesh.triangles[triangle].map(|corner| mesh.colors[corner as usize]);
    assert_eq!((of(0), of(1), notes.as_str()), ([[1.0, 0.0, 0.0]; 3], [[0.0, 0.0, 1.0]; 3], ""));
    assert_eq!(mesh.open_edges(), 4, "its corners are at the same places");
    // Faces of one color share their corners.
    let (mesh, _) = noted_mesh(read_noted("a.ply", text.replace("0 0 255", "255 0 0").as_bytes()).unwrap());
    assert_eq!(mesh.positions.len(), 4);
}

#[test]
fn a_conversion_keeps_the_colors_of_vertices() {
    let (mesh, _) = ply(&channels("uchar", ["red", "green", "blue"]), "128 64 0");
    for (format, name) in [(MeshFormat::Ply, "a.ply"), (MeshFormat::Obj, "a.obj"), (MeshFormat::Glb, "a.glb")] {
        let (looks, mut bytes) = (Looks { normals: Vec::new(), colors: mesh.vertex_colors() }, Vec::new());
        format.write_with(&mesh, Some(&looks), &mut bytes).unwrap();
        let (again, notes) = noted_mesh(read_noted(name, &bytes).unwrap());
        assert_close(again.colors[1], [light(128.0), light(64.0), 0.0], name);
        assert_eq!((again.positions.clone(), notes.as_str()), (mesh.positions.clone(), ""), "{name}");
        let text = String::from_utf8_lossy(&bytes);
        assert!(!["property float nx", "vn ", "NORMAL"].iter().any(|normal| text.contains(normal)), "{name}");
    }
}

#[test]
fn spaces_and_surplus_columns_of_ply_are_left_out() {
    let text = "ply  \nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0.5\n1 0 0 0.5\n0 1 0 0.5\n3 0 1 2 255 0\n";
    let (mesh, notes) = noted_mesh(read_noted("a.ply", text.as_bytes()).unwrap());
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(notes, "lines have more numbers than the header declares, which are left out: 4");
}

#[test]
fn lines_of_ply_with_several_elements_lose_none() {
    let head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    // All in a line, two elements in a line, broken anywhere, and a line for all faces.
    for body in [
        "0 0 0 1 0 0 1 1 0 0 1 0 3 0 1 2 3 0 2 3\n",
        "0 0 0 1 0 0\n1 1 0 0 1 0\n3 0 1 2 3 0 2 3\n",
        "0 0 0 1 0\n0 1\n\n1 0 0 1\n0 3 0\n1 2 3\n0 2 3",
        "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 3 0 2 3\n\n",
        "0 0 0\r\n1 0 0\r\n1 1 0\r\n0 1 0\r\n3 0 1 2\r\n3 0 2 3\r\n",
    ] {
        let text = format!("{head}{body}");
        let (mesh, notes) = noted_mesh(read_noted("a.ply", text.as_bytes()).unwrap_or_else(|e| panic!("{body}: {e}")));
        assert_eq!((mesh.triangles.as_slice(), notes.as_str()), (&[[0, 1, 2], [0, 2, 3]][..], ""), "{body}");
    }
    // Surplus numbers after the faces alone, also where they would make a list.
    let text = format!("{head}0 0 0\n1 0 0\n1 1 0\n\n0 1 0\n3 0 1 2 1 7\n3 0 2 3 1 7\n");
    let (mesh, notes) = noted_mesh(read_noted("a.ply", text.as_bytes()).unwrap());
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(notes, "lines have more numbers than the header declares, which are left out: 2");
    // A list that goes on in the next line may have lost its numbers.
    let text = format!("{head}0 0 0 5\n1 0 0 5\n1 1 0\n0 1 0\n3 0 1\n2\n3 0 2 3\n");
    let error = read_noted("a.ply", text.as_bytes()).unwrap_err().to_string();
    assert!(
        error.contains("line 14: expected a whole element in this line") && error.contains("found its end"),
        "{error}"
    );
}

#[test]
fn stl_may_have_any_lines_and_more_corners() {
    let square = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    let split = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nend loop\nend facet\n\
        facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nend solid a\n";
    let quad = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\n\
        endfacet\nendsolid\n";
    let one_line = split.replace('\n', " ");
    let no_name = split.replace("solid a\n", "solid\n").replace('\n', " ");
    for (text, note) in [
        (split, ""),
        (&one_line, ""),
        (&no_name, ""),
        (&split.to_uppercase(), ""),
        (&split.replace("outer loop\n", "outer loop "), ""),
        (quad, "facets of more than 3 corners are cut into triangles: 1"),
    ] {
        let (mesh, notes) =
            noted_mesh(read_noted("a.stl", text.as_bytes()).unwrap_or_else(|error| panic!("{text}: {error}")));
        assert_eq!((mesh.positions.as_slice(), mesh.triangles.len()), (&square[..], 2), "{text}");
        assert_eq!(notes, note, "{text}");
    }
}
