//! Odd files that other programs write and read: each is read with a line about the assumption.

mod dicom;
mod gltf;
mod meshes;
mod obj;
mod vdb;
mod volumes;

use hypertexture_shape::{Mesh, Opened, Shape, Volume, open_painted};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A folder with files; paths may have folders.
fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    folder
}

/// A mesh and the notes about its file, which are joined.
fn noted_mesh(opened: Opened) -> (Mesh, String) {
    let Shape::Mesh(mesh) = opened.shape else { panic!("no mesh") };
    (mesh, opened.notes.join("; "))
}

fn noted_volume(opened: Opened) -> (Volume, String) {
    let Shape::Volume(volume) = opened.shape else { panic!("no volume") };
    (volume, opened.notes.join("; "))
}

/// A mesh with its materials, and the notes.
fn painted(path: &Path) -> (Mesh, String) {
    let path = path.to_str().unwrap();
    open_painted(path).unwrap_or_else(|error| panic!("{error}"));
    noted_mesh(Opened::with_paint(path, None).unwrap())
}

/// Linear light of a code of sRGB, by the standard IEC 61966-2-1.
fn light(code: f64) -> f32 {
    let part = code / 255.0;
    (if part <= 0.040_45 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }) as f32
}

fn assert_close(found: [f32; 3], expected: [f32; 3], what: &str) {
    let is_near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 2e-4);
    assert!(is_near, "{what}: {found:?} for {expected:?}");
}
