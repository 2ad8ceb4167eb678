//! Sparse fog volumes written as OpenVDB: read back by the reader of this crate. The program's tests read them by OpenVDB.

use glam::{DVec3, Vec3};
use half::f16;
use hypertexture_shape::{Fog, FogGrid, FogLeaf, Opened, Shape, Volume, read};

/// Value of a voxel: 0 in two of three.
fn value([x, y, z]: [u32; 3]) -> f32 {
    if (x + y + z).is_multiple_of(3) { 0.1 + 0.01 * x as f32 + 0.001 * y as f32 + 1e-4 * z as f32 } else { 0.0 }
}

/// Leaves on both sides of a border between nodes of 128^3 voxels, in disorder.
const CORNERS: [[u32; 3]; 4] = [[128, 0, 8], [120, 0, 0], [0, 0, 0], [120, 8, 0]];

fn fog(is_half: bool) -> Vec<u8> {
    let grids = vec![FogGrid { name: "heat", channels: 3 }, FogGrid { name: "density", channels: 1 }];
    let mut fog = Fog { origin: DVec3::new(-1.0, 2.0, 0.5), step: 0.25, is_half, grids, leaves: Vec::new() };
    for corner in CORNERS {
        let at = |index: u32| [corner[0] + (index >> 6), corner[1] + (index >> 3 & 7), corner[2] + (index & 7)];
        let all: Vec<f32> = (0..512).map(|index| value(at(index))).collect();
        let active: Vec<bool> = all.iter().map(|value| *value > 0.0).collect();
        let values: Vec<f32> = all.into_iter().filter(|value| *value > 0.0).collect();
        let vectors = values.iter().flat_map(|value| [*value, 0.0, -1.0]).collect();
        fog.leaves.push(FogLeaf::new(corner, &active, &[vectors, values], is_half).unwrap());
    }
    let mut bytes = Vec::new();
    fog.write(|_| true, &mut bytes).unwrap();
    bytes
}

fn volume(bytes: &[u8]) -> Volume {
    match read("a.vdb", bytes) {
        Ok(Shape::Volume(volume)) => volume,
        other => panic!("{other:?}"),
    }
}

#[test]
fn leaves_come_back_at_their_places_in_32_and_in_16_bits() {
    for is_half in [false, true] {
        let found = volume(&fog(is_half));
        // The box of the active voxels with a margin of one: the first and the last are at 0 and at 135, 15, 15.
        assert_eq!((found.size, found.origin), ([138, 18, 18], Vec3::new(-1.25, 1.75, 0.25)));
        for (index, found) in found.values.iter().enumerate() {
            let index = index as u32;
            let at = [index % 138, index / 138 % 18, index / 138 / 18].map(|part| i64::from(part) - 1);
            let within = |corner: &[u32; 3]| (0..3).all(|axis| (0..8).contains(&(at[axis] - i64::from(corner[axis]))));
            let expected = if CORNERS.iter().any(within) { value(at.map(|part| part as u32)) } else { 0.0 };
            let expected = if is_half { f16::from_f32(expected).to_f32() } else { expected };
            assert_eq!(*found, expected, "{at:?}");
        }
    }
}

#[test]
fn every_grid_is_listed_and_half_as_large_in_halves() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fog.vdb");
    let [whole, halves] = [false, true].map(fog);
    assert!(halves.len() < whole.len());
    std::fs::write(&path, whole).unwrap();
    let grids = Opened::with_grid(path.to_str().unwrap(), Some("density")).unwrap().grids;
    assert_eq!(grids, ["`heat` (`Tree_vec3s_5_4_3`)", "`density` (fog volume, floats)"]);
}
