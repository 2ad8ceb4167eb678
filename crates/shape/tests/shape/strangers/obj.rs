//! OBJ and MTL.

use super::{assert_close, folder, light, noted_mesh, painted};
use glam::Vec3;
use hypertexture_shape::{Mesh, read_noted};

/// A square of two triangles at z = 0.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0.25 0.5\nvt 0.75 0.5\n";

/// PNG of 2 x 1 pixels: red, then blue.
fn red_and_blue() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&[255, 0, 0, 0, 0, 255]).unwrap();
    writer.finish().unwrap();
    bytes
}

/// Mean color of the points of a triangle.
fn color(mesh: &Mesh, triangle: usize) -> Option<[f32; 3]> {
    let own = Mesh { triangles: vec![mesh.triangles[triangle]], ..mesh.clone() };
    let colors: Vec<Vec3> = own.colored_points(10.0).map(|(_, color)| Vec3::from(color)).collect();
    (!colors.is_empty()).then(|| (colors.iter().sum::<Vec3>() / colors.len() as f32).to_array())
}

#[test]
fn a_mark_and_line_ends_of_an_mtl_change_nothing() {
    let plain = "newmtl A\nKd 0 1 0\nmap_Kd rb.png\nnewmtl B\nKd 1 0 0\n";
    let obj = format!("mtllib a.mtl\n{SQUARE}usemtl A\nf 1/2 2/2 3/2\nusemtl B\nf 1 3 4\n");
    let png = red_and_blue();
    for mtl in
        [format!("\u{feff}{plain}"), plain.replace('\n', "\r"), plain.replace('\n', "\r\n"), plain.trim_end().into()]
    {
        for obj in [obj.clone(), obj.replace('\n', "\r")] {
            let desk = folder(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes()), ("rb.png", &png)]);
            let (mesh, notes) = painted(&desk.path().join("a.obj"));
            assert_close(color(&mesh, 0).unwrap(), [0.0, 0.0, 1.0], &mtl);
            assert_close(color(&mesh, 1).unwrap(), [1.0, 0.0, 0.0], &mtl);
            assert_eq!(notes, "", "{mtl:?}");
        }
    }
    // A single line that ends in CR, and a typo before a longer text.
    let desk = folder(&[("a.obj", obj.as_bytes()), ("a.mtl", b"newmtl B\rKd 1 0 0\r")]);
    assert_close(color(&painted(&desk.path().join("a.obj")).0, 1).unwrap(), [1.0, 0.0, 0.0], "two lines");
}

#[test]
fn textures_of_other_machines_are_found_beside_the_file() {
    let png = red_and_blue();
    for name in [
        r"C:\Users\nobody\My Textures\rb.png",
        "/home/nobody/tex/rb.png",
        r"..\..\tex\rb.png",
        "textures/rb.png",
        "RB.PNG",
        "\"rb.png\"",
        "\"D:/art/rb.png\"",
        "rb.png -s 1 1 1",
        r"-o 0 0 0 \\server\share\rb.png",
    ] {
        let mtl = format!("newmtl A\nmap_Kd {name}\n");
        let obj = format!("mtllib /somewhere/else/a.mtl\n{SQUARE}usemtl A\nf 1/1 2/1 3/1\nf 1/2 3/2 4/2\n");
        let desk = folder(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes()), ("rb.png", &png)]);
        let (mesh, notes) = painted(&desk.path().join("a.obj"));
        assert_close(color(&mesh, 0).unwrap(), [1.0, 0.0, 0.0], name);
        assert_close(color(&mesh, 1).unwrap(), [0.0, 0.0, 1.0], name);
        assert!(notes.contains("`/somewhere/else/a.mtl` is read from `a.mtl` beside it"), "{notes}");
        assert_eq!(
            notes.contains("is read from `rb.png` beside it"),
            !name.starts_with("rb") && name != "\"rb.png\"",
            "{notes}"
        );
    }
    let desk = folder(&[
        ("a.obj", format!("mtllib a.mtl\n{SQUARE}usemtl A\nf 1/1 2/1 3/1\n").as_bytes()),
        (
            "a.mtl",
            br"newmtl A
map_Kd C:\nowhere.png
",
        ),
    ]);
    let error = hypertexture_shape::open_painted(desk.path().join("a.obj").to_str().unwrap()).unwrap_err().to_string();
    assert!(
        error
            .contains("material `A`: the data file `C:/nowhere.png` is not supported; put the file of the data beside"),
        "{error}"
    );
}

#[test]
fn faces_without_texture_coordinates_have_their_plain_color() {
    let png = red_and_blue();
    // The third face has coordinates at two corners only.
    let obj = format!("mtllib a.mtl\n{SQUARE}v 2 2 0\nusemtl A\nf 1/2 2/2 3/2\nf 1 3 4\nf 3/1 5/1 4\n");
    for (kd, expected) in [("Kd 0 1 0\n", Some([0.0, 1.0, 0.0])), ("", None)] {
        let mtl = format!("newmtl A\n{kd}map_Kd rb.png\n");
        let desk = folder(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes()), ("rb.png", &png)]);
        let (mesh, notes) = painted(&desk.path().join("a.obj"));
        assert_close(color(&mesh, 0).unwrap(), [0.0, 0.0, 1.0], "with coordinates");
        for bare in [1, 2] {
            match (color(&mesh, bare), expected) {
                (Some(found), Some(expected)) => assert_close(found, expected, "without coordinates"),
                (found, expected) => assert_eq!(found, expected),
            }
        }
        let how = if expected.is_some() { "have its color `Kd`" } else { "stay unpainted" };
        assert!(
            notes
                .contains(&format!("faces of material `A` without texture coordinates {how}; the first is in line 11")),
            "{notes}"
        );
    }
}

#[test]
fn bytes_after_a_vertex_are_colors() {
    let with = |colors: [&str; 3]| {
        let places = ["0 0 0", "1 0 0", "0 1 0"];
        let lines = places.iter().zip(colors).map(|(place, color)| format!("v {place} {color}\n"));
        noted_mesh(read_noted("a.obj", (lines.collect::<String>() + "f 1 2 3\n").as_bytes()).unwrap())
    };
    let half = light(128.0);
    for (colors, first, note) in [
        (["128 64 0"; 3], [half, light(64.0), 0.0], "colors reach 128: read as codes of 0 to 255"),
        (["0.5 0.25 0"; 3], [light(127.5), light(63.75), 0.0], ""),
        (["32896 0 65535"; 3], [half, 0.0, 1.0], "colors reach 65535: read as codes of 0 to 65535"),
        (["1.0001 0 0"; 3], [1.0, 0.0, 0.0], ""),
        (["1.5 0.5 0"; 3], [1.0, light(127.5), 0.0], "colors reach 1.5: values above 1 count as 1"),
        (
            ["1 0.5 0.25 0"; 3],
            [light(127.5), light(63.75), 0.0],
            "vertices of 7 numbers are read as a position, a weight, then a color",
        ),
        (
            ["0.5 0.25 0 1"; 3],
            [light(127.5), light(63.75), 0.0],
            "vertices of 7 numbers are read as a position, a color, then an opacity",
        ),
        (
            ["1 0 0 0.5", "1 0.5 0 1", "1 0 0 0.5"],
            [0.0, 0.0, light(127.5)],
            "vertices of 7 numbers are read as a position, a weight, then a color",
        ),
    ] {
        let (mesh, notes) = with(colors);
        assert_close(mesh.colors[0], first, colors[0]);
        assert_eq!(notes, note);
    }
    // Red with an opacity, or blue with a weight.
    let (mesh, notes) = with(["1 0 0 1"; 3]);
    assert!(!mesh.is_colored() && notes.contains("both fit, so their colors are left out: write 6 numbers"), "{notes}");
}
