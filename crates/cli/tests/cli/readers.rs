//! Written files in the readers of other programs: surface and samples are as intended.
//!
//! HYPERTEXTURE_PYTHON names a Python with trimesh, SimpleITK, nibabel, pynrrd, numpy, scipy and networkx; without one that
//! has them, it is said and nothing is compared.

use crate::program::run;
use serde_json::Value;
use std::f64::consts::PI;
use std::path::Path;
use std::process::Command;

const VOLUMES: [&str; 6] = ["nrrd", "mha", "nii", "nii.gz", "npy", "vdb"];
const MESHES: [&str; 4] = ["stl", "ply", "obj", "glb"];

/// Output of the readers for the files in a folder; `None`, with a message, if the readers are missing.
fn told(folder: &Path) -> Option<Vec<Value>> {
    let python = std::env::var("HYPERTEXTURE_PYTHON").unwrap_or("python3".into());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/readers.py");
    let output = match Command::new(&python).arg(script).arg(folder).output() {
        Ok(output) => output,
        Err(error) => {
            eprintln!("skipped: {python}: {error}");
            return None;
        }
    };
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.code() == Some(77) {
        eprintln!("skipped: {said}");
        return None;
    }
    assert!(output.status.success(), "{said}");
    let lines = String::from_utf8(output.stdout).unwrap();
    Some(lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect())
}

/// Asserts that numbers, or lists of them, are alike to a part of the largest.
fn assert_near(found: &Value, expected: &Value, part: f64, what: &str) {
    fn numbers(value: &Value) -> Vec<f64> {
        match value {
            Value::Array(all) => all.iter().flat_map(numbers).collect(),
            other => vec![other.as_f64().unwrap_or(f64::NAN)],
        }
    }
    let (found, expected) = (numbers(found), numbers(expected));
    let most = expected.iter().fold(0.0_f64, |most, number| most.max(number.abs()));
    assert_eq!(found.len(), expected.len(), "{what}");
    assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= part * most), "{what}: {found:?} {expected:?}");
}

#[test]
fn other_programs_read_what_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let good = |arguments: &str| {
        let output = run(folder, arguments);
        assert!(output.status.success(), "`{arguments}`: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    for end in VOLUMES {
        good(&format!("convert phantom -o phantom.{end}"));
        good(&format!("field torus --resolution 40 -o torus.{end}"));
    }
    for end in MESHES {
        good(&format!("mesh noisy_sphere --grid 48 -o stone.{end}"));
        good(&format!("mesh torus --grid 64 -o ring.{end}"));
    }
    let Some(all) = told(folder) else { return };
    let of = |stem: &str| -> Vec<&Value> {
        all.iter().filter(|one| one["file"].as_str().unwrap().starts_with(&format!("{stem}."))).collect()
    };

    for stem in ["stone", "ring"] {
        let meshes = of(stem);
        assert_eq!(meshes.len(), MESHES.len(), "{stem}");
        for mesh in &meshes {
            let name = mesh["file"].as_str().unwrap();
            assert!(mesh["watertight"] == true && mesh["winding_consistent"] == true, "{name}: {mesh}");
            assert_eq!(mesh["triangles"], meshes[0]["triangles"], "{name}");
            for key in ["volume", "low", "high"] {
                assert_near(&mesh[key], &meshes[0][key], 1e-5, &format!("{name}, {key}"));
            }
        }
    }
    let ring = of("ring")[0];
    assert_near(&ring["volume"], &(2.0 * PI * PI * 0.7 * 0.3 * 0.3).into(), 0.01, "Pappus");
    assert_near(&ring["high"], &serde_json::json!([1.0, 0.3, 1.0]), 2e-3, "the box of the torus");

    for stem in ["phantom", "torus"] {
        let own: Value = serde_json::from_str(&good(&format!("info {stem}.nrrd --json"))).unwrap();
        let volumes = of(stem);
        assert!(volumes.len() >= VOLUMES.len(), "{stem}");
        for volume in &volumes {
            let name = format!("{} by {}", volume["file"], volume["reader"]);
            if volume["reader"] == "openvdb" {
                continue; // of its active voxels alone
            }
            assert_eq!(volume["size"], own["voxels"], "{name}");
            assert_near(&volume["min"], &own["values"][0], 1e-6, &name);
            assert_near(&volume["max"], &own["values"][1], 1e-6, &name);
            assert_near(&volume["sum"], &volumes[0]["sum"], 1e-6, &name);
            assert_near(&volume["moments"], &volumes[0]["moments"], 1e-6, &name);
            if !volume["steps"].is_null() {
                assert_near(&volume["steps"], &own["steps"], 1e-5, &name);
                assert_near(&volume["origin"], &own["box"][0], 1e-5, &name);
            }
        }
    }
}
