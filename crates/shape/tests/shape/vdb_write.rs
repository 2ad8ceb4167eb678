//! Volumes written as OpenVDB: bytes, and exact round trips.

use glam::{EulerRot, Mat3, Quat, Vec3};
use hypertexture_shape::{Content, Shape, ShapeError, Volume, VolumeFormat, read};
use proptest::prelude::*;

fn written(volume: &Volume) -> Vec<u8> {
    let mut bytes = Vec::new();
    VolumeFormat::OpenVdb.write(volume, &mut bytes).unwrap();
    bytes
}

fn back(bytes: &[u8]) -> Volume {
    match read("a.vdb", bytes) {
        Ok(Shape::Volume(volume)) => volume,
        other => panic!("{other:?}"),
    }
}

fn assert_comes_back(volume: &Volume) {
    let found = back(&written(volume));
    let bits = |numbers: &[f32]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
    assert_eq!((found.size, found.content), (volume.size, volume.content));
    assert_eq!((found.origin, found.steps), (volume.origin, volume.steps));
    assert_eq!(bits(&found.values), bits(&volume.values));
}

/// Volume with spacings 0.5, 0.25 and 2 and the origin (1, -2, 3).
fn volume(size: [u32; 3], content: Content, value: impl Fn(u32) -> f32) -> Volume {
    let steps = Mat3::from_diagonal(Vec3::new(0.5, 0.25, 2.0));
    let values = (0..size.iter().product()).map(value).collect();
    Volume { size, origin: Vec3::new(1.0, -2.0, 3.0), steps, values, content }
}

#[test]
fn a_voxel_beside_the_background_is_written_as_openvdb_does() {
    let two = volume([1, 1, 2], Content::Scalar, |index| [4.0, -8.5][index as usize]);
    // The second voxel, at z = 1: place 1 of a leaf, all nodes of which begin at the origin.
    let text = |text: &str| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    let entry = |key: &str, kind: &str, value: &[u8]| {
        [text(key), text(kind), (value.len() as u32).to_le_bytes().to_vec(), value.to_vec()].concat()
    };
    let corner = |corner: [u32; 3]| corner.map(u32::to_le_bytes).concat();
    let first = |bytes: usize, byte: u8| [vec![byte], vec![0; bytes - 1]].concat();
    let numbers = |numbers: &[f64]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>();
    let head = [
        b" BDV\0\0\0\0\xe0\0\0\0\x0a\0\0\0\0\0\0\0\x01".to_vec(),
        b"00000000-0000-0000-0000-000000000000\0\0\0\0\x01\0\0\0".to_vec(),
        [text("density"), text("Tree_float_5_4_3"), text("")].concat(),
    ]
    .concat();
    let grid = [
        3u32.to_le_bytes().to_vec(),
        5u32.to_le_bytes().to_vec(),
        entry("class", "string", b"fog volume"),
        entry("hypertexture_min", "vec3i", &[0; 12]),
        entry("hypertexture_max", "vec3i", &corner([0, 0, 1])),
        entry("is_saved_as_half_float", "bool", &[0]),
        entry("name", "string", b"density"),
        text("ScaleTranslateMap"),
        numbers(&[1.0, -2.0, 3.0, 0.5, 0.25, 2.0, 0.5, 0.25, 2.0, 2.0, 4.0, 0.5, 4.0, 16.0, 0.25, 1.0, 2.0, 0.25]),
    ]
    .concat();
    let tree = [
        [1u32.to_le_bytes(), 4f32.to_le_bytes(), [0; 4], 1u32.to_le_bytes()].concat(),
        vec![0; 12],                                  // where the node of 4096 voxels begins
        [first(4096, 1), vec![0; 4096 + 9]].concat(), // its first child; nothing active, nothing stored
        [first(512, 1), vec![0; 512 + 9]].concat(),
        first(64, 2),
    ]
    .concat();
    let leaf = [first(64, 2), vec![0], (-4i64).to_le_bytes().to_vec(), (-8.5f32).to_le_bytes().to_vec()].concat();
    let start = head.len() + 24;
    let blocks = start + grid.len() + tree.len();
    let offsets = [start, blocks, blocks + leaf.len()].map(|offset| (offset as u64).to_le_bytes()).concat();
    assert_eq!(written(&two), [head, offsets, grid, tree, leaf].concat());
    assert_comes_back(&two);
}

#[test]
fn sizes_around_those_of_nodes_come_back() {
    for size in [[1, 1, 1], [7, 8, 9], [17, 1, 128], [129, 2, 3], [1, 4097, 2], [4100, 3, 1], [2, 1, 8200]] {
        for content in [Content::Scalar, Content::SignedDistance, Content::LevelSet] {
            assert_comes_back(&volume(size, content, |index| (index as f32 * 0.37).sin() * 100.0));
            // Some leaves and nodes are not there.
            assert_comes_back(&volume(size, content, |index| if index % 1999 == 1998 { -1.0 } else { 30.0 }));
        }
    }
}

#[test]
fn a_constant_volume_has_no_node_and_comes_back() {
    for (content, value) in
        [(Content::Scalar, 7.5), (Content::Scalar, -0.0), (Content::SignedDistance, 2.5), (Content::LevelSet, 1e6)]
    {
        let constant = volume([20, 30, 40], content, |_| value);
        assert_comes_back(&constant);
        assert!(written(&constant).len() < 700);
    }
    // A distance below a voxel everywhere cannot be a background.
    assert_comes_back(&volume([9, 9, 9], Content::SignedDistance, |_| -3.0));
    // The other zero is another value.
    assert_comes_back(&volume([9, 9, 9], Content::Scalar, |index| if index == 100 { -0.0 } else { 0.0 }));
}

#[test]
fn what_is_as_the_border_is_not_stored() {
    let inside = |index: u32| (index % 64).abs_diff(32) < 4 && (index / 64 % 64).abs_diff(32) < 4 && index / 4096 == 32;
    let fog = volume([64, 64, 64], Content::Scalar, |index| if inside(index) { index as f32 } else { 0.0 });
    assert_comes_back(&fog);
    assert!(written(&fog).len() < 16_000, "{}", written(&fog).len());
}

#[test]
fn a_grid_on_other_axes_comes_back() {
    let turned = Mat3::from_quat(Quat::from_euler(EulerRot::XYZ, 0.3, -0.9, 2.0));
    let sheared = Mat3::from_cols(Vec3::X, Vec3::new(0.4, 1.0, 0.0), Vec3::new(0.0, 0.3, -1.5));
    for steps in [turned, sheared, turned * sheared * 0.01] {
        for content in [Content::Scalar, Content::LevelSet] {
            assert_comes_back(&Volume { steps, ..volume([10, 9, 8], content, |index| index as f32) });
        }
    }
    // Backwards: the same voxels, in order.
    let steps = Mat3::from_diagonal(Vec3::new(0.5, -0.25, 2.0));
    let found = back(&written(&Volume { steps, ..volume([1, 3, 1], Content::Scalar, |index| index as f32) }));
    assert_eq!((found.origin, found.steps.y_axis), (Vec3::new(1.0, -2.5, 3.0), Vec3::Y * 0.25));
    assert_eq!(found.values, [2.0, 1.0, 0.0]);
}

#[test]
fn corners_that_do_not_fit_are_refused() {
    let good = written(&volume([9, 8, 7], Content::Scalar, |index| index as f32));
    let at = |key: &[u8]| good.windows(key.len()).position(|part| part == key).unwrap() + key.len() + 13;
    for (key, corner, said) in [
        (&b"hypertexture_max"[..], [7, 7, 6], "active voxels between the corners in the metadata"),
        (b"hypertexture_min", [1, 0, 0], "active voxels between the corners in the metadata"),
        (b"hypertexture_max", [-1, 7, 6], "active voxels between the corners in the metadata"),
        (b"hypertexture_max", [9000, 9000, 9000], "voxels in the box around the active ones, the limit is"),
        (b"hypertexture_max", [i32::MAX; 3], "voxels in the box around the active ones, the limit is"),
    ] {
        let mut bad = good.clone();
        bad[at(key)..at(key) + 12].copy_from_slice(&corner.map(i32::to_le_bytes).concat());
        let error: ShapeError = read("a.vdb", &bad).unwrap_err();
        let line = error.to_string();
        assert!(line.contains(said) && line.lines().count() == 1, "{said}: {line}");
    }
    for length in 0..good.len() {
        assert!(read("a.vdb", &good[..length]).is_err(), "{length}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_volume_comes_back(
        size in prop::array::uniform3(1..20_u32),
        values in prop::collection::vec(prop_oneof![3 => Just(1.0_f32), 1 => -1e30..1e30_f32, 1 => prop::num::f32::SUBNORMAL], 1..97),
        turn in prop::array::uniform3(-3.0..3.0_f32),
        content in prop_oneof![Just(Content::Scalar), Just(Content::LevelSet)],
    ) {
        let steps = Mat3::from_euler(EulerRot::XYZ, turn[0], turn[1], turn[2]) * 0.7;
        assert_comes_back(&Volume { steps, ..volume(size, content, |index| values[index as usize % values.len()]) });
    }
}
