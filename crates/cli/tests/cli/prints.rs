//! Objects with a size in millimeters.

use super::desk::{Desk, refused};
use hypertexture::shape::{Mesh, Opened, Shape, Unit};
use std::path::Path;

fn opened(path: &Path) -> (Mesh, Opened) {
    let opened = Opened::of(path.to_str().unwrap()).unwrap();
    match &opened.shape {
        Shape::Mesh(mesh) => (mesh.clone(), opened),
        _ => panic!("no mesh"),
    }
}

#[test]
fn a_mesh_is_written_as_long_as_it_shall_be() {
    let desk = Desk::new();
    let length = |name: &str| opened(&desk.file(name)).0.bounds().size().max_element();
    let out = desk.good("mesh torus --grid 40 --scale-to 60mm -o a.3mf");
    assert!(out.contains("by --scale-to"), "{out}");
    let (_, file) = opened(&desk.file("a.3mf"));
    assert_eq!((file.unit, file.names), (Some(Unit::Millimeter), vec!["torus".to_string()]));
    assert!((length("a.3mf") - 60.0).abs() < 0.1, "{}", length("a.3mf"));
    desk.good("mesh torus --grid 40 --scale-to 60mm -o a.glb");
    assert!((length("a.glb") - 0.06).abs() < 1e-4, "{}", length("a.glb"));
    desk.good("mesh a.glb --grid 40 --resolution 48 -o b.stl");
    assert!((length("b.stl") - 60.0).abs() < 2.0, "{}", length("b.stl"));
    let told = desk.good("info a.glb");
    assert!(told.contains("mm, the unit of the file is m"), "{told}");
    assert!(desk.good("info b.stl").contains("the file has no unit: taken as mm"));
    assert!(desk.good("info torus").contains("--scale-to 60mm"));
}

#[test]
fn lengths_in_millimeters_give_the_mesh_of_object_units() {
    let desk = Desk::new();
    desk.write(
        "s.toml",
        "preset = \"noisy_sphere\"\n[object]\nscale_to = \"60mm\"\n[parameters]\namplitude = \"1.2mm\"\n",
    );
    for (arguments, file) in [
        ("noisy_sphere --scale-to 6cm --set amplitude=1.2mm", "a.3mf"),
        ("noisy_sphere --scale-to 60 --set amplitude=0.04", "b.3mf"),
        ("s.toml", "c.3mf"),
        ("s.toml --scale-to 30mm --set amplitude=600um", "d.3mf"),
    ] {
        desk.good(&format!("mesh {arguments} --grid 32 -o {file}"));
    }
    let [a, b, c, d] = ["a.3mf", "b.3mf", "c.3mf", "d.3mf"].map(|name| opened(&desk.file(name)).0.positions);
    assert!(a == b && a == c);
    let halves = a.iter().zip(&d).map(|(a, d)| (0.5 * *a - *d).length()).fold(0.0, f32::max);
    assert!(a.len() == d.len() && halves < 1e-5, "{halves}");
}

#[test]
fn lengths_without_a_size_are_refused() {
    refused(
        |desk| desk.write("s.toml", "[object]\niso = \"2mm\"\n"),
        &[
            ("mesh noisy_sphere --set amplitude=1.2mm -o a.3mf", &["amplitude = 1.2mm", "no unit", "--scale-to 60mm"]),
            ("render torus --shell 1mm -o a.png", &["object.shell = 1mm", "--scale-to 60mm"]),
            ("render torus --scale-to 60mm --iso 1mm -o a.png", &["iso"]),
            ("mesh noisy_sphere --scale-to 60mm --set frequency=1mm -o a.3mf", &["frequency is not a length"]),
            ("mesh noisy_sphere --scale-to 60mm --set amplitude=90mm -o a.3mf", &["amplitude = 3", "must be from"]),
            ("mesh noisy_sphere --scale-to=-5mm -o a.3mf", &["object.scale_to = -5", "must be from"]),
            ("mesh noisy_sphere --scale-to 5parsec -o a.3mf", &["scale_to", "must be a number"]),
            ("render s.toml -o a.png", &["s.toml:2", "object.iso is not a length"]),
            ("mesh torus --unit furlong -o a.3mf", &["--unit", "furlong"]),
        ],
    );
}

#[test]
fn a_mesh_within_a_tolerance_says_what_is_proven() {
    let desk = Desk::new();
    let out = desk.good("mesh noisy_sphere --scale-to 60mm --tolerance 0.6mm -o a.3mf");
    assert!(out.contains("surface    within 0.6 mm of ") && out.contains("lost"), "{out}");
    assert!(out.contains("1 body; watertight") && out.contains(" cm3") && out.contains("overhang   "), "{out}");
    let (mesh, _) = opened(&desk.file("a.3mf"));
    let facts = desk.good("mesh noisy_sphere --scale-to 60mm --triangles 1000 --json -o b.stl");
    let facts: serde_json::Value = serde_json::from_str(&facts).unwrap();
    let triangles = facts["triangles"].as_u64().unwrap();
    assert!((990..=1000).contains(&triangles) && facts["unit"] == "mm", "{facts}");
    assert!(facts["surface"]["self_intersections"].is_u64() && facts["watertight"] == true, "{facts}");
    let (volume, of_other) = (facts["volume"].as_f64().unwrap(), mesh.signed_volume());
    assert!((volume / of_other - 1.0).abs() < 0.05, "{volume} {of_other}");
}

#[test]
fn bodies_are_apart_in_a_file_that_has_them() {
    let desk = Desk::new();
    desk.good("mesh ensemble --resolution 32 --tolerance 0.05 --bodies apart --smallest 1% -o a.3mf");
    let (mesh, file) = opened(&desk.file("a.3mf"));
    assert_eq!(file.names.len(), mesh.bodies().len(), "{:?}", file.names);
    assert!(file.names[0].starts_with("ensemble"), "{:?}", file.names);
}

#[test]
fn tolerances_that_cannot_be_held_are_refused() {
    refused(
        |_| (),
        &[
            ("mesh sphere --tolerance 0.1mm -o a.3mf", &["--tolerance 0.1mm", "no unit", "--scale-to 60mm"]),
            ("mesh sphere --tolerance 0 -o a.3mf", &["--tolerance", "a length above 0"]),
            ("mesh sphere --scale-to 60mm --tolerance 1um -o a.3mf", &["--tolerance 0.001 mm: not from", "mm"]),
            ("mesh sphere --tolerance 1 -o a.3mf", &["--tolerance 1: not from"]),
            ("mesh sphere --triangles 9 -o a.3mf", &["--triangles 9: not in 100 to 10000000"]),
            ("mesh sphere --triangles 900 --grid 64 -o a.3mf", &["--grid", "cannot be used with"]),
            ("mesh sphere --bodies apart -o a.stl", &["--bodies apart: only .3mf has bodies"]),
        ],
    );
}
