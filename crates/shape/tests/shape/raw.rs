//! Raw files: read with a layout, refused without one.

use glam::Vec3;
use hypertexture_shape::{Content, RawLayout, SampleType, Shape, ShapeError, Volume, open, open_raw, read};
use std::fs;

const LAYOUT: RawLayout =
    RawLayout { size: [4, 5, 3], kind: SampleType::U8, big_endian: false, spacing: [0.5, 1.0, 2.0], skip: Some(0) };

struct Desk(tempfile::TempDir);

impl Desk {
    fn write(&self, bytes: &[u8]) -> String {
        let path = self.0.path().join("scan.raw");
        fs::write(&path, bytes).unwrap();
        path.display().to_string()
    }

    fn volume(&self, bytes: &[u8], layout: &RawLayout) -> Volume {
        match open_raw(&self.write(bytes), layout) {
            Ok(Shape::Volume(volume)) => volume,
            other => panic!("{:?}", other.err()),
        }
    }

    fn error(&self, bytes: &[u8], layout: &RawLayout) -> String {
        let path = self.write(bytes);
        let line = open_raw(&path, layout).unwrap_err().to_string();
        assert!(line.starts_with(&path) && !line.contains('\n') && line.len() < 400, "{line}");
        line
    }
}

fn desk() -> Desk {
    Desk(tempfile::tempdir().unwrap())
}

#[test]
fn every_type_and_order_gives_the_values_in_their_place() {
    let desk = desk();
    macro_rules! check {
        ($($name:literal $number:ty),*) => {$(
            let kind: SampleType = $name.parse().unwrap();
            assert_eq!((kind.to_string().as_str(), kind.bytes() as usize), ($name, size_of::<$number>()));
            let numbers = (0..60).map(|x| (x * 2) as $number);
            let little: Vec<u8> = numbers.clone().flat_map(|x| x.to_le_bytes()).collect();
            let big: Vec<u8> = numbers.flat_map(|x| x.to_be_bytes()).collect();
            for (big_endian, bytes) in [(false, little), (true, big)] {
                let layout = RawLayout { kind, big_endian, ..LAYOUT };
                let volume = desk.volume(&bytes, &layout);
                assert_eq!((volume.size, volume.origin, volume.spacing()), ([4, 5, 3], Vec3::ZERO, Vec3::new(0.5, 1.0, 2.0)));
                assert_eq!((volume.content, volume.is_aligned()), (Content::Scalar, true));
                assert_eq!(volume.values, (0..60).map(|x| (x * 2) as f32).collect::<Vec<_>>());
                assert_eq!(volume.sample(Vec3::new(0.5, 2.0, 4.0)), Some(2.0 * 49.0));
                // Bytes before the values.
                let longer = [&[7; 13], &bytes[..]].concat();
                for skip in [Some(13), None] {
                    assert_eq!(desk.volume(&longer, &RawLayout { skip, ..layout }).values, volume.values);
                }
            }
        )*};
    }
    check!("uint8" u8, "int8" i8, "uint16" u16, "int16" i16, "uint32" u32, "int32" i32, "uint64" u64, "int64" i64, "float32" f32, "float64" f64);
}

#[test]
fn names_of_types_are_told_where_one_is_wrong() {
    for wrong in ["", "UINT8", "u8", "uint128", "float16", "float", "uint8 "] {
        let line = wrong.parse::<SampleType>().unwrap_err().to_string();
        let known = "choose one of uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32, float64";
        assert_eq!(line, format!("no type is called `{wrong}`; {known}"));
    }
    assert!("x".repeat(1 << 20).parse::<SampleType>().unwrap_err().to_string().len() < 200);
}

#[test]
fn a_layout_that_the_file_does_not_fit_to_is_refused() {
    let desk = desk();
    let sized = |size| RawLayout { size, ..LAYOUT };
    let spaced = |spacing| RawLayout { spacing, ..LAYOUT };
    for (layout, said) in [
        (sized([0, 5, 3]), "layout: expected 3 sizes of at least 1, found `0 x 5 x 3`"),
        (sized([4, 5, 4]), "the header declares 80 bytes of data (4 x 5 x 4 voxels of 1 bytes), the file holds 60"),
        (sized([4, 5, 2]), "declares 40 bytes of data (4 x 5 x 2 voxels of 1 bytes), the file holds 60"),
        (sized([u32::MAX; 3]), "4294967295 x 4294967295 x 4294967295 voxels, the limit is 2147483648"),
        (sized([1 << 15, 1 << 15, 2]), "declares 2147483648 bytes"),
        (RawLayout { kind: SampleType::U16, ..LAYOUT }, "declares 120 bytes"),
        (RawLayout { skip: Some(1), ..LAYOUT }, "byte 1: the header declares 60 bytes"),
        (RawLayout { skip: Some(u64::MAX), ..LAYOUT }, "after 18446744073709551615 bytes), the file holds 60"),
        (RawLayout { skip: None, ..sized([4, 5, 4]) }, "declares 80 bytes"),
        (spaced([1.0, 0.0, 1.0]), "layout: expected distances between samples from 1.2e-38 to 1e18, found `1 0 1`"),
        (spaced([1.0, -1.0, 1.0]), "found `1 -1 1`"),
        (spaced([f64::NAN, 1.0, 1.0]), "found `NaN 1 1`"),
        (spaced([f64::INFINITY, 1.0, 1.0]), "found `inf 1 1`"),
        (spaced([1e-300, 1.0, 1.0]), "layout: expected distances"),
        (spaced([1e300, 1.0, 1.0]), "layout: expected distances"),
        (spaced([5e17, 1.0, 1.0]), "volume corners 1 (from 0) reaches 1.5e18"),
    ] {
        let line = desk.error(&[0; 60], &layout);
        assert!(line.contains(said), "{said}: {line}");
    }
    assert!(desk.error(&[], &LAYOUT).contains("the file holds 0"));
    let floats = RawLayout { kind: SampleType::F32, ..LAYOUT };
    let with = |odd: f32| (0..60).flat_map(|x| (if x == 7 { odd } else { 1.0 }).to_le_bytes()).collect::<Vec<u8>>();
    assert!(desk.error(&with(f32::INFINITY), &floats).contains("1 of 60 voxels are NaN, infinite"));
    assert_eq!(desk.volume(&with(f32::NAN), &floats).values, [1.0; 60]); // outside, as the lowest
    assert!(matches!(open_raw("none", &LAYOUT), Err(ShapeError::Missing { .. })));
    let folder = desk.0.path().display().to_string();
    assert!(matches!(open_raw(&folder, &LAYOUT), Err(ShapeError::NotAFile { .. })));
}

#[test]
fn a_missing_layout_names_flags_and_likely_sizes() {
    let remedy = "without a layout{}; `hypertexture convert` reads it with --dims X,Y,Z --type uint16 (uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32 or float64)";
    for (bytes, guess) in [
        (16 * 16 * 16, " (16 x 16 x 16 of uint8?)"),
        (2 * 17 * 17 * 17, " (17 x 17 x 17 of uint16?)"),
        (4 * 15 * 15 * 15, " (15 x 15 x 15 of float32?)"),
        (1001, ""),
        (1, ""),
    ] {
        let line = read("scan.raw", &vec![0; bytes]).unwrap_err().to_string();
        assert_eq!(line, format!("scan.raw: {bytes} bytes of raw values {}", remedy.replace("{}", guess)));
    }
    let path = desk().write(&[0; 27]);
    assert!(open(&path).is_err());
}
