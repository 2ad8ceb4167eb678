//! Volumes and meshes for other programs, read by OpenVDB where Python has it.

use crate::program::{run, unexpected};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A ball whose density falls from 1 at a radius of 0.75 to 0 at 1.35.
const BALL: &str = "[object]\ninput = \"sphere\"\ninner_iso = -0.25\nouter_iso = 0.35\n\
     [effect]\nclassify = \"soft\"\nsoftness = \"linear\"\nmedium = \"transfer\"\n";

/// Standard output of what must succeed.
fn good(folder: &Path, arguments: &str) -> String {
    let output = run(folder, arguments);
    assert!(output.status.success(), "`{arguments}`: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The grids of a file by OpenVDB; `None`, with a message, without it.
fn grids(folder: &Path, file: &str) -> Option<Value> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/fog.py");
    let named = std::env::var("HYPERTEXTURE_PYTHON");
    for python in named.iter().map(String::as_str).chain(["python3", "/usr/bin/python3"]) {
        let Ok(output) = Command::new(python).arg(script).arg(folder.join(file)).output() else { continue };
        if output.status.code() != Some(77) {
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            return Some(serde_json::from_slice(&output.stdout).unwrap());
        }
    }
    eprintln!("skipped: no Python with openvdb (apt-get install python3-openvdb)");
    None
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn openvdb_reads_the_grids_their_places_and_their_values() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("ball.toml"), BALL).unwrap();
    for flags in ["", "--half"] {
        let said: Value =
            serde_json::from_str(&good(folder, &format!("volume ball.toml --grid 40 {flags} --json -o b.vdb")))
                .unwrap();
        let made = &said["volumes"][0];
        let Some(all) = grids(folder, "b.vdb") else { return };
        let names: Vec<&String> = all.as_object().unwrap().keys().collect();
        assert_eq!(names, ["color", "density", "extinction", "temperature"]);
        let step = made["voxel"].as_f64().unwrap();
        assert!((step - 2.7 / 37.0).abs() < 1e-6, "{step}"); // a voxel is outside at each end
        let close = if flags.is_empty() { 2e-5 } else { 6e-4 };
        for (name, grid) in all.as_object().unwrap() {
            let kind = if name == "color" { "vec3s" } else { "float" };
            assert_eq!(
                (&grid["type"], &grid["class"], &grid["half"]),
                (&kind.into(), &"fog volume".into(), &(!flags.is_empty()).into()),
                "{name}"
            );
            assert_eq!(grid["metadata"]["file_voxel_count"], grid["active"], "{name}");
            let origin = grid["origin"].as_array().unwrap().iter().map(|part| part.as_f64().unwrap());
            let origin: Vec<f64> = origin.collect();
            assert!(grid["step"].as_array().unwrap().iter().all(|side| (side.as_f64().unwrap() - step).abs() < 1e-9));
            let values = grid["values"].as_array().unwrap();
            assert_eq!(grid["active"], values.len());
            // The voxels within the radius, in their volume.
            let expected = 4.0 / 3.0 * std::f64::consts::PI * (1.35 / step).powi(3);
            assert!((values.len() as f64 / expected - 1.0).abs() < 0.02, "{} {expected}", values.len());
            for item in values {
                let world = [0, 1, 2].map(|axis| origin[axis] + step * item[axis].as_f64().unwrap());
                let radius = world.iter().map(|part| part * part).sum::<f64>().sqrt();
                let density = ((1.35 - radius) / 0.6).clamp(0.0, 1.0);
                if name == "extinction" {
                    // The rate is 40, and hard matter has the optical depth of 16 in a voxel.
                    let expected = (-40.0 * (1.0 - density).ln()).min(16.0 / step);
                    let near = 1e-3 * expected + close * 40.0 / (1.0 - density).max(1e-3);
                    assert!((item[3].as_f64().unwrap() - expected).abs() < near, "{item} {expected}");
                    continue;
                }
                let (value, close) = match &item[3] {
                    Value::Array(color) => (color[1].as_f64().unwrap(), 5e-3),
                    value => (value.as_f64().unwrap(), if name == "density" { close } else { 5e-3 }),
                };
                // Hard matter has the color of its surface.
                assert!(
                    (value - density).abs() < close || density >= 1.0 && name != "density",
                    "{name} {item} {density}"
                );
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_extinction_is_that_of_the_medium() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // Opacity rates of 8 and 140; hair covers by 0.2 over its length (glsl/medium/hair.glsl).
    for (scene, expected) in [
        ("torus --effect fire", 8.0),
        ("torus --effect fire --set flame_opacity=0.1", 0.8),
        ("torus --effect fur --set hair_length=0.1", 280.0),
        ("torus --effect fur --set hair_length=0.5", 56.0),
    ] {
        let text = good(folder, &format!("volume {scene} --grid 24 --json -o v.vdb"));
        let said: Value = serde_json::from_str(&text).unwrap();
        let found = said["volumes"][0]["extinction"].as_f64().unwrap();
        assert!((found / expected - 1.0).abs() < 2e-3, "{scene}: {found}");
    }
    let text = good(folder, "volume burning_bush --grid 32 -o v.vdb");
    assert!(text.contains("times -ln(1 - density) per world unit, by the place"), "{text}");
    assert!(text.contains("albedo of hair, solid; emission, times the extinction, of flame"), "{text}");
    assert!(text.contains("where y points up: turn it in Blender by 90 degrees about x"), "{text}");
    let text = good(folder, "volume phantom --iso 0.1 --up z --grid 16 -o v.vdb");
    assert!(text.contains("where z points up: as in Blender"), "{text}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn small_bodies_are_named_and_dropped() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let bodies = |said: &str| said.split(" triangles, ").nth(1).unwrap().split(' ').next().unwrap().to_string();
    let all = good(folder, "mesh furry_teapot --grid 64 -o a.stl");
    assert!(all.contains("below 0.1% of the volume of the largest") && bodies(&all) != "1", "{all}");
    assert!(all.contains("mm, as slicers read it; --scale-to 60mm"), "{all}");
    let one = good(folder, "mesh furry_teapot --grid 64 --smallest 0.1% -o b.ply");
    assert!(one.contains("smaller ones were dropped") && !one.contains("print  "), "{one}");
    assert!(fs::metadata(folder.join("b.ply")).unwrap().len() > 1000);
    let none = run(folder, "mesh furry_teapot --grid 16 --smallest 1e9 -o c.stl");
    assert!(none.status.code() == Some(2) && unexpected(&none).contains("none would be left; lower it"), "{none:?}");
    assert!(!folder.join("c.stl").exists());
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_folder_of_the_name_of_a_scene_hides_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for _ in 0..2 {
        good(folder, "export noisy_sphere -o noisy_sphere");
    }
    for rest in ["mesh noisy_sphere --grid 16 -o m.stl", "volume noisy_sphere --grid 16 -o v.vdb"] {
        good(folder, rest);
    }
    let other = run(folder, "render ./noisy_sphere -o p.png");
    assert!(other.status.code() == Some(2) && unexpected(&other).contains("is a directory"), "{other:?}");
}

#[test]
fn a_conversion_keeps_colors_and_says_what_it_leaves_out() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("a.obj"), "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n").unwrap();
    for (end, part) in [("ply", "property uchar red"), ("obj", "v 0 1 0 0 0 "), ("glb", "COLOR_0")] {
        let said = good(folder, &format!("convert a.obj -o b.{end}"));
        let bytes = fs::read(folder.join(format!("b.{end}"))).unwrap();
        assert!(
            said.contains("with colors of vertices") && String::from_utf8_lossy(&bytes).contains(part),
            "{end}: {said}"
        );
    }
    assert!(good(folder, "convert a.obj -o b.stl").contains("STL has no colors"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn frames_of_volumes_and_meshes_are_numbered_and_move() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let said = good(folder, "volume torus --effect fire --grid 24 --frames 3..4 --fps 2 -o f_##.vdb");
    assert!(said.contains("density, extinction, color, temperature, vel: 32-bit floats"), "{said}");
    let [a, b] = ["f_03.vdb", "f_04.vdb"].map(|name| fs::read(folder.join(name)).unwrap());
    assert!(a != b, "nothing moves");
    if let Some(all) = grids(folder, "f_03.vdb") {
        // The flames rise by 0.6 object units a second, and the torus is as wide as two.
        let speeds = all["vel"]["values"].as_array().unwrap().iter().map(|item| item[3][1].as_f64().unwrap());
        assert!(speeds.clone().count() > 100 && speeds.into_iter().all(|speed| (speed - 0.6).abs() < 1e-6));
    }
    for (end, both) in [("ply", "property uchar red"), ("obj", "vn "), ("glb", "COLOR_0")] {
        good(folder, &format!("mesh noisy_sphere --grid 16 --frames 1..2 -o m.{end}"));
        let bytes = fs::read(folder.join(format!("m_0001.{end}"))).unwrap();
        assert!(String::from_utf8_lossy(&bytes).contains(both), "{end}");
        assert!(folder.join(format!("m_0002.{end}")).exists());
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn dense_formats_hold_the_same_density() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("ball.toml"), BALL).unwrap();
    for end in ["nrrd", "npy"] {
        let said = good(folder, &format!("volume ball.toml --grid 24 -o d.{end}"));
        assert_eq!(said.contains("\nplace      not in the file: origin ["), end == "npy", "{said}");
    }
    let about: Value = serde_json::from_str(&good(folder, "info d.nrrd --json")).unwrap();
    assert!(about.to_string().contains("[24,24,24]"), "{about}");
    let bytes = fs::read(folder.join("d.npy")).unwrap();
    assert_eq!(bytes.len(), 128 + 4 * 24 * 24 * 24);
    let value = |[x, y, z]: [usize; 3]| {
        let at = 128 + 4 * ((z * 24 + y) * 24 + x);
        f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
    };
    // Beside the middle, and along x at 6 voxels of 2.7 / 21 from it.
    assert_eq!((value([11, 11, 12]), value([0, 12, 12])), (1.0, 0.0));
    let radius = (2.7_f32 / 21.0) * (6.5_f32 * 6.5 + 0.5).sqrt();
    assert!((value([18, 12, 11]) - (1.35 - radius) / 0.6).abs() < 1e-5);
}

#[test]
fn an_array_of_numpy_lacks_its_place_with_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("v.raw"), "abcdefgh").unwrap();
    let spaced = "convert v.raw --dims 2,2,2 --type uint8 --spacing 0.5,0.5,2";
    let own = "\nplace      not in the file: origin [0.0, 0.0, 0.0], spacing [0.5, 0.5, 2.0], world units\n";
    assert!(good(folder, &format!("{spaced} -o a.npy")).contains(own));
    assert!(good(folder, "field torus --resolution 32 -o c.npy").contains("\nplace      not in the file: origin ["));
    for arguments in [format!("{spaced} -o a.nrrd"), "convert v.raw --dims 2,2,2 --type uint8 -o b.npy".into()] {
        let said = good(folder, &arguments);
        assert!(!said.contains("place "), "{arguments}: {said}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn bad_requests_get_one_line_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (arguments, said) in [
        ("volume sphere -o a.mha", "end the name in .vdb, .nrrd or .npy"),
        ("volume sphere --half -o a.npy", "--half: a.npy holds 32-bit floats; write a .vdb"),
        ("volume sphere --grid 4000 -o a.vdb", "--grid 4000: not in 8 to 2048"),
        ("volume sphere --effect lit --dmf scaled --set density_factor=0 --grid 16 -o a.vdb", "has a density above 0"),
        ("volume cube --effect lit --grid 2048 -o a.npy", "32768 MiB"),
        ("volume sphere --frames 2..1 -o a.vdb", "A..B"),
        ("volume sphere --fps 2 -o a.vdb", "--frames"),
    ] {
        let output = run(folder, arguments);
        let line = unexpected(&output);
        assert_eq!((output.status.code(), line.lines().count()), (Some(2), 1), "{arguments}: {line}");
        assert!(line.contains(said), "{arguments}: {line}");
        assert!(!folder.join("a.vdb").exists() && !folder.join("a.npy").exists(), "{arguments}");
    }
}
