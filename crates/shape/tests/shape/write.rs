//! Volumes written and read back bit for bit, on any grid.

use glam::{EulerRot, Mat3, Quat, Vec3};
use hypertexture_shape::{Content, Shape, Volume, VolumeFormat, read};
use proptest::prelude::*;
use std::path::Path;

const FORMATS: [(VolumeFormat, &str); 5] = [
    (VolumeFormat::Nrrd, "a.nrrd"),
    (VolumeFormat::MetaImage, "a.mha"),
    (VolumeFormat::Nifti, "a.nii"),
    (VolumeFormat::NiftiGzip, "a.nii.gz"),
    (VolumeFormat::OpenVdb, "a.vdb"),
];

fn written(format: VolumeFormat, volume: &Volume) -> Vec<u8> {
    let mut bytes = Vec::new();
    format.write(volume, &mut bytes).unwrap();
    bytes
}

fn back(name: &str, bytes: &[u8]) -> Volume {
    match read(name, bytes) {
        Ok(Shape::Volume(volume)) => volume,
        other => panic!("{name}: {:?}", other.err()),
    }
}

fn assert_same(a: &Volume, b: &Volume) {
    let bits = |numbers: &[f32]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
    assert_eq!((a.size, a.content), (b.size, b.content));
    assert_eq!((a.origin.to_array(), a.steps.to_cols_array()), (b.origin.to_array(), b.steps.to_cols_array()));
    assert_eq!(bits(&a.values), bits(&b.values));
}

fn volume(size: [u32; 3], steps: Mat3, content: Content) -> Volume {
    let count = size.iter().product::<u32>();
    let values = (0..count).map(|i| (i as f32 * 0.37).sin() / 3.0 - f32::MIN_POSITIVE * i as f32).collect();
    Volume { size, origin: Vec3::new(-1.0 / 3.0, 1e-20, 77.7), steps, values, content }
}

#[test]
fn the_end_of_a_name_tells_the_format() {
    for (name, format) in [
        ("a.nrrd", Some(VolumeFormat::Nrrd)),
        ("b/a.MHA", Some(VolumeFormat::MetaImage)),
        ("a.b.nii", Some(VolumeFormat::Nifti)),
        ("a.Nii.Gz", Some(VolumeFormat::NiftiGzip)),
        ("a.vdb", Some(VolumeFormat::OpenVdb)),
        ("a.npy", Some(VolumeFormat::Npy)),
        ("a.gz", None),
        ("a.mhd", None),
        ("nrrd", None),
        ("a.nrrd/b", None),
        ("", None),
    ] {
        assert_eq!(VolumeFormat::from_path(Path::new(name)), format, "{name}");
    }
}

#[test]
fn distances_and_scalars_come_back_as_such() {
    let spacing = Mat3::from_diagonal(Vec3::new(0.1, 1.0 / 7.0, 3e-3));
    let oblique = Mat3::from_quat(Quat::from_rotation_x(0.3)) * spacing;
    for (format, name) in FORMATS {
        for (steps, content) in
            [(spacing, Content::SignedDistance), (spacing, Content::Scalar), (oblique, Content::Scalar)]
        {
            let before = volume([3, 4, 5], steps, content);
            let bytes = written(format, &before);
            assert_same(&back(name, &bytes), &before);
            assert_same(&back("no_end", &bytes), &before);
        }
        let distances = volume([3, 4, 5], oblique, Content::SignedDistance);
        let line = read(name, &written(format, &distances)).unwrap_err().to_string();
        assert!(line.contains("a signed distance on a grid that is not along the axes of the world"), "{line}");
    }
}

#[test]
fn a_long_side_goes_into_nifti_2() {
    for (side, size) in [(32767, 348), (32768, 540)] {
        let before = volume([side, 1, 2], Mat3::IDENTITY, Content::SignedDistance);
        let bytes = written(VolumeFormat::Nifti, &before);
        assert_eq!(bytes[..4], i32::to_le_bytes(size));
        assert_same(&back("a.nii", &bytes), &before);
    }
}

/// Numbers of a NIfTI-1 header from byte `at` on.
fn numbers<const N: usize>(bytes: &[u8], at: usize) -> [f32; N] {
    std::array::from_fn(|i| f32::from_le_bytes(bytes[at + 4 * i..][..4].try_into().unwrap()))
}

#[test]
fn a_qform_is_written_where_it_says_what_the_sform_says() {
    let spacing = Mat3::from_diagonal(Vec3::new(0.5, 2.0, 3.0));
    let turn = Quat::from_euler(EulerRot::XYZ, 0.3, -0.2, 0.5);
    let mirror = Mat3::from_diagonal(Vec3::new(1.0, 1.0, -1.0));
    let of = |steps| written(VolumeFormat::Nifti, &volume([2, 3, 4], steps, Content::Scalar));
    for (side, steps) in [(1.0, Mat3::from_quat(turn) * spacing), (-1.0, Mat3::from_quat(turn) * mirror * spacing)] {
        let bytes = of(steps);
        assert_eq!((bytes[252], bytes[254]), (1, 1));
        let [found, x, y, z] = numbers(&bytes, 76);
        assert!(found == side && (Vec3::new(x, y, z) - Vec3::new(0.5, 2.0, 3.0)).abs().max_element() < 1e-6);
        assert!((Vec3::from(numbers(&bytes, 256)) - turn.xyz()).abs().max_element() < 1e-6);
        assert_eq!(numbers(&bytes, 268), [-1.0 / 3.0, 1e-20, 77.7]);
    }
    let sheared = of(Mat3::from_cols(Vec3::X, Vec3::new(0.3, 1.0, 0.0), Vec3::Z));
    assert_eq!((sheared[252], sheared[254]), (0, 1));
    assert_eq!(numbers(&sheared, 280), [1.0, 0.3, 0.0, -1.0 / 3.0]);
}

#[test]
fn a_numpy_array_has_its_header_and_z_slowest() {
    let volume = volume([3, 4, 5], Mat3::IDENTITY, Content::Scalar);
    let bytes = written(VolumeFormat::Npy, &volume);
    assert_eq!(bytes[..8], *b"\x93NUMPY\x01\0");
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
    assert!(header.starts_with("{'descr': '<f4', 'fortran_order': False, 'shape': (5, 4, 3), }"), "{header}");
    assert!(header.ends_with('\n') && (10 + length) % 64 == 0);
    let values: Vec<u8> = volume.values.iter().flat_map(|value| value.to_le_bytes()).collect();
    assert_eq!(bytes[10 + length..], values);
}

#[test]
fn a_volume_with_too_few_values_is_not_written() {
    let mut short = volume([3, 4, 5], Mat3::IDENTITY, Content::Scalar);
    short.values.pop();
    let all = FORMATS.map(|(format, _)| format);
    for format in all.into_iter().chain([VolumeFormat::Npy]) {
        let mut bytes = Vec::new();
        let error = format.write(&short, &mut bytes).unwrap_err();
        assert_eq!((error.kind(), bytes.len()), (std::io::ErrorKind::InvalidInput, 0));
        assert_eq!(error.to_string(), "a volume of 3 x 4 x 5 needs their product of values, it has 59");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_is_read_back_bit_for_bit(
        size in prop::array::uniform3(1..6_u32),
        values in prop::collection::vec(any::<u32>().prop_map(f32::from_bits), 125),
        origin in prop::array::uniform3(-1e3..1e3_f32),
        angles in prop::array::uniform3(-3.0..3.0_f32),
        spacing in prop::array::uniform3(0.2..5.0_f32),
        (shear, is_aligned, mirror) in (-0.5..0.5_f32, any::<bool>(), any::<bool>()),
        exponent in -20..20_i32,
    ) {
        let [a, b, c] = angles;
        let sheared = Mat3::from_cols(Vec3::X, Vec3::new(shear, 1.0, 0.0), Vec3::new(0.0, -shear, 1.0));
        let turn = if is_aligned { Mat3::IDENTITY } else { Mat3::from_euler(EulerRot::XYZ, a, b, c) * sheared };
        let side = if mirror && !is_aligned { -1.0 } else { 1.0 };
        let by = 2f32.powi(exponent);
        let steps = by * turn * Mat3::from_diagonal(Vec3::from(spacing) * Vec3::new(1.0, side, 1.0));
        let count = size.iter().product::<u32>() as usize;
        let values = values[..count].iter().map(|value| if value.is_finite() { *value } else { 0.5 }).collect();
        let content = if is_aligned { Content::SignedDistance } else { Content::Scalar };
        let before = Volume { size, origin: by * Vec3::from(origin), steps, values, content };
        for (format, name) in FORMATS {
            assert_same(&back(name, &written(format, &before)), &before);
        }
    }
}
