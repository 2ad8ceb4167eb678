//! NRRD: reading, refusals with their messages, and round trips.

use crate::packed::{bzip2, gzip, thread_seconds};
use glam::{Mat3, Vec3};
use hypertexture_shape::{Content, Found, Shape, ShapeError, Volume, VolumeFormat, open, read, read_noted};
use std::fs;

fn volume(bytes: &[u8]) -> Volume {
    match read("test.nrrd", bytes) {
        Ok(Shape::Volume(volume)) => volume,
        other => panic!("{other:?}"),
    }
}

fn error(bytes: &[u8]) -> ShapeError {
    read("test.nrrd", bytes).unwrap_err()
}

/// Values of a file, and the notes about it.
fn noted(bytes: &[u8]) -> (Vec<f32>, String) {
    let opened = read_noted("test.nrrd", bytes).unwrap();
    let Shape::Volume(volume) = opened.shape else { panic!("no volume") };
    (volume.values, opened.notes.join("; "))
}

/// Note about bytes after the data.
fn rest(count: &str) -> String {
    format!("bytes after the data that the header declares are left out: {count}")
}

fn file(header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = format!("NRRD0004\n# a comment\ndimension: 3\n{header}\n\n").into_bytes();
    bytes.extend_from_slice(data);
    bytes
}

/// 3 x 2 x 1 bytes 0 to 5.
fn small(extra: &str) -> Vec<u8> {
    file(
        format!("type: uchar\nsizes: 3 2 1\nencoding: raw\n{extra}").replace("\n\n", "\n").trim_end(),
        &[0, 1, 2, 3, 4, 5],
    )
}

fn a_distance() -> Volume {
    let values: Vec<f32> = (0..60).map(|i| (i as f32 * 0.37).sin() / 3.0 - f32::MIN_POSITIVE * i as f32).collect();
    let (origin, steps) = (Vec3::new(-1.0 / 3.0, 1e-20, 77.7), Mat3::from_diagonal(Vec3::new(0.1, 1.0 / 7.0, 3e-3)));
    Volume { size: [3, 4, 5], origin, steps, values, content: Content::SignedDistance }
}

fn written(volume: &Volume) -> Vec<u8> {
    let mut bytes = Vec::new();
    VolumeFormat::Nrrd.write(volume, &mut bytes).unwrap();
    bytes
}

#[test]
fn what_is_written_is_read_back_bit_for_bit() {
    for content in [Content::SignedDistance, Content::Scalar] {
        let before = Volume { content, ..a_distance() };
        let after = volume(&written(&before));
        assert_eq!(
            (after.size, after.origin, after.steps, after.content),
            (before.size, before.origin, before.steps, content)
        );
        assert!(before.values.iter().zip(&after.values).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
}

#[test]
fn a_volume_with_too_few_values_is_not_written() {
    let mut volume = a_distance();
    volume.values.pop();
    assert_eq!(VolumeFormat::Nrrd.write(&volume, Vec::new()).unwrap_err().kind(), std::io::ErrorKind::InvalidInput);
}

#[test]
fn every_type_and_byte_order_gives_the_same_values() {
    let expected = [-3.0, 0.0, 100.0, 2.0];
    macro_rules! check {
        ($number:ty, $values:expr, $($name:literal),*) => {
            for name in [$($name),*] {
                for (endian, bytes) in [
                    ("little", $values.iter().flat_map(|&v| (v as $number).to_le_bytes()).collect::<Vec<u8>>()),
                    ("big", $values.iter().flat_map(|&v| (v as $number).to_be_bytes()).collect()),
                ] {
                    for (encoding, data) in [
                        ("raw", bytes.clone()),
                        ("gzip", gzip(&bytes)),
                        ("gz", gzip(&bytes)),
                        ("bzip2", bzip2(&bytes)),
                        ("bz2", bzip2(&bytes)),
                        ("ascii", $values.map(|v| (v as $number).to_string()).join(" ").into()),
                        ("text", $values.map(|v| (v as $number).to_string()).join(", \n\t").into()),
                        ("txt", (" ".to_owned() + &$values.map(|v| (v as $number).to_string()).join("\r\n") + "\n").into()),
                    ] {
                        let header = format!("type: {name}\nsizes: 2 2 1\nendian: {endian}\nencoding: {encoding}");
                        assert_eq!(volume(&file(&header, &data)).values, $values, "{header}");
                    }
                }
            }
        };
    }
    let positive = expected.map(f32::abs);
    check!(i8, expected, "signed char", "int8", "int8_t");
    check!(u8, positive, "uchar", "unsigned char", "uint8", "uint8_t");
    check!(i16, expected, "short", "signed short int", "int16");
    check!(u16, positive, "ushort", "unsigned short", "uint16_t");
    check!(i32, expected, "int", "int32");
    check!(u32, positive, "uint", "unsigned int", "uint32");
    check!(i64, expected, "longlong", "long long int", "signed long long", "int64", "int64_t");
    check!(u64, positive, "ulonglong", "unsigned long long", "uint64", "uint64_t");
    check!(f32, expected, "float");
    check!(f64, expected, "double");
}

#[test]
fn x_runs_fastest_and_defaults_are_the_unit_grid_at_the_origin() {
    let volume = volume(&small(""));
    assert_eq!((volume.size, volume.origin, volume.spacing()), ([3, 2, 1], Vec3::ZERO, Vec3::ONE));
    assert_eq!(volume.sample(Vec3::new(2.0, 1.0, 0.0)), Some(5.0));
    assert_eq!(volume.content, Content::Scalar);
}

#[test]
fn spacings_axis_mins_and_directions_place_the_samples() {
    let placed = |extra: &str| {
        let volume = volume(&small(extra));
        (volume.origin, volume.spacing())
    };
    let spacing = Vec3::new(0.5, 2.0, 3.0);
    assert_eq!(placed("spacings: 0.5 2 3"), (Vec3::ZERO, spacing));
    assert_eq!(placed("spacings: 0.5 2 3\naxis mins: 1 -2 5"), (Vec3::new(1.0, -2.0, 5.0), spacing));
    let cells = "spacings: 0.5 2 3\naxismins: 1 -2 5\ncenters: cell cell node";
    assert_eq!(placed(cells), (Vec3::new(1.25, -1.0, 5.0), spacing));
    let space = "space directions: (0.5,0,0) (0, 2, 0) (0,0,3)\nspace origin: (4,5,-6)";
    assert_eq!(placed(space), (Vec3::new(4.0, 5.0, -6.0), spacing));
}

#[test]
fn a_backward_axis_is_turned_and_samples_keep_their_places() {
    let mirrored = volume(&small("space directions: (-0.5,0,0) (0,-2,0) (0,0,-3)\nspace origin: (4,5,-6)"));
    assert_eq!((mirrored.origin, mirrored.spacing()), (Vec3::new(3.0, 3.0, -6.0), Vec3::new(0.5, 2.0, 3.0)));
    assert_eq!(mirrored.values, [5.0, 4.0, 3.0, 2.0, 1.0, 0.0]);
    assert_eq!(mirrored.sample(Vec3::new(4.0, 5.0, -6.0)), Some(0.0));
}

#[test]
fn oblique_grids_follow_directions_and_axes_are_ordered() {
    let oblique = volume(&small("space directions: (0.3,0.4,0) (-0.8,0.6,0) (0.5,0,-2)\nspace origin: (4,5,-6)"));
    let columns = [Vec3::new(0.3, 0.4, 0.0), Vec3::new(-0.8, 0.6, 0.0), Vec3::new(0.5, 0.0, -2.0)];
    assert_eq!((oblique.origin, oblique.size), (Vec3::new(4.0, 5.0, -6.0), [3, 2, 1]));
    assert_eq!(oblique.steps, Mat3::from_cols(columns[0], columns[1], columns[2]));
    assert_eq!(oblique.values, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    assert!((oblique.sample(Vec3::new(4.0 + 0.6 - 0.8, 5.0 + 0.8 + 0.6, -6.0)).unwrap() - 5.0).abs() < 1e-5);
    // The first axis runs up, the second to the left.
    let exchanged = volume(&small("space directions: (0,0,0.5) (-2,0,0) (0,3,0)\nspace origin: (4,5,-6)"));
    assert_eq!((exchanged.size, exchanged.spacing()), ([2, 1, 3], Vec3::new(2.0, 3.0, 0.5)));
    assert_eq!((exchanged.origin, exchanged.is_aligned()), (Vec3::new(2.0, 5.0, -6.0), true));
    assert_eq!(exchanged.values, [3.0, 0.0, 4.0, 1.0, 5.0, 2.0]);
}

#[test]
fn line_and_byte_skips_apply_after_unpacking() {
    let with = |extra: &str, encoding: &str, data: &[u8]| {
        let header = format!("type: uchar\nsizes: 3 2 1\nencoding: {encoding}\n{extra}");
        volume(&file(&header, data)).values
    };
    let expected = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
    let data = [0, 1, 2, 3, 4, 5];
    assert_eq!(with("byte skip: 3", "raw", &[&b"abc"[..], &data].concat()), expected);
    assert_eq!(with("byte skip: -1", "raw", &[&b"abc"[..], &data].concat()), expected);
    assert_eq!(with("line skip: 2\nbyte skip: 1", "raw", &[&b"a\nb\r\nc"[..], &data].concat()), expected);
    let text = b"0 is what begins\nand this: 0,1 2\n3\t4, 5";
    assert_eq!(with("line skip: 1\nbyte skip: 10", "ascii", text), expected);
    for (encoding, pack) in [("gzip", gzip as fn(&[u8]) -> Vec<u8>), ("bzip2", bzip2)] {
        let packed = pack(&[&b"abcd"[..], &data].concat());
        assert_eq!(with("line skip: 1\nbyte skip: 4", encoding, &[&b"a\n"[..], &packed].concat()), expected);
        let header = format!("type: uchar\nsizes: 3 2 1\nencoding: {encoding}\nbyte skip: ");
        for (skip, said) in [
            ("5", "the file holds 5"),
            ("11", "the file holds 0"),
            ("268435457", "line 7: expected a number of bytes (at most 2^28 of compressed data), or -1"),
        ] {
            let line = error(&file(&format!("{header}{skip}"), &packed)).to_string();
            assert!(line.contains(said), "{encoding}, {skip}: {line}");
        }
    }
}

#[test]
fn text_numbers_fit_their_type_and_declared_count() {
    for (kind, text, said) in [
        ("uchar", "0 1 2 3 4", "expected as many numbers as the header says, found 5 of 6, and the end of the file"),
        ("uchar", "", "found 0 of 6, and the end of the file"),
        ("uchar", "0 1 2 3 4 256", "expected a number of the type that the header says, found `256`"),
        ("uchar", "0 1 2 3 4 -1", "found `-1`"),
        ("uchar", "0 1 2 3 4 5.5", "found `5.5`"),
        ("short", "0 1 2 3 4 x", "found `x`"),
        ("float", "0 1 2 3 4 0x10", "found `0x10`"),
        (
            "float",
            "0 1 2 nan -inf 1e39",
            "3 of 6 voxels are NaN, infinite or beyond 32-bit floats, the first has index 3",
        ),
        ("float", "0 1 2 3 4 \u{fffd}", "expected a number of the type"),
    ] {
        let line = error(&file(&format!("type: {kind}\nsizes: 3 2 1\nencoding: ascii"), text.as_bytes())).to_string();
        assert!(line.contains(said) && line.len() < 300, "{text}: {line}");
    }
    let header = "type: float\nsizes: 3 2 1\nencoding: ascii";
    assert!(error(&file(header, &[b'1'; 1 << 20])).to_string().contains("found `1111"));
    let text = b"1e-3 -2.5E2 +3 .5 16777217 1e-50";
    assert_eq!(volume(&file(header, text)).values, [1e-3, -250.0, 3.0, 0.5, 16_777_216.0, 0.0]);
}

#[test]
fn data_in_several_files_is_read_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let data: Vec<u8> = (0..120).collect();
    for (i, part) in data.chunks(20).enumerate() {
        fs::write(at(&format!("s{:02}.raw", 3 * i)), part).unwrap();
        fs::write(at(&format!("z{i}.gz")), gzip(&[b"ab", part].concat())).unwrap();
    }
    for (i, part) in data.chunks(60).enumerate() {
        fs::write(at(&format!("slab {i}.raw")), part).unwrap();
    }
    for (i, part) in data.chunks(4).enumerate() {
        fs::write(at(&format!("row{i:>4}.raw")), part).unwrap();
    }
    let error = |header: &str| {
        fs::write(at("v.nhdr"), header).unwrap();
        let line = open(&at("v.nhdr").display().to_string()).unwrap_err().to_string();
        assert!(!line.contains('\n'));
        line
    };
    let start = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 5 6\n";
    for files in [
        "encoding: raw\ndata file: s%02d.raw 0 15 3\n",
        "encoding: raw\ndatafile: LIST\ns00.raw\ns03.raw\ns06.raw\ns09.raw\ns12.raw\ns15.raw\n",
        "encoding: gzip\nbyte skip: 2\ndata file: z%d.gz 0 5 1 2\n",
        "encoding: raw\ndata file: slab %d.raw 0 1 1 3\n",
        "encoding: raw\ndata file: LIST 3\nslab 0.raw\nslab 1.raw",
        "encoding: raw\ndata file: row%4d.raw 0 29 1 1\n\n",
    ] {
        fs::write(at("v.nhdr"), [start, files].concat()).unwrap();
        let read = volume_of(&at("v.nhdr").display().to_string());
        assert_eq!(read.values, (0..120).map(|i| i as f32).collect::<Vec<_>>(), "{files}");
    }
    for (files, said) in [
        ("data file: s%02d.raw 0 12 3\n", "`s%02d.raw 0 12 3` with 5 files for 6 slices"),
        ("data file: s%02d.raw 0 15 3 4\n", "with 6 files for 6 slices"),
        ("data file: s%02d.raw 0 15 3 1\n", "with 6 files for 6 slices"),
        ("data file: slab %d.raw 0 3 1 3\n", "with 4 files for 6 slices"),
        ("data file: LIST\n", "line 6: expected a file, `LIST`"),
        ("data file: LIST 0\ns00.raw\n", "with 1 files"),
        ("data file: LIST\n/etc/passwd\na\nb\nc\nd\ne\n", "put the file of the data beside this one"),
        ("data file: ../%d.raw 0 5 1\n", "put the file of the data beside this one"),
        ("data file: t%02d.raw 0 15 3\n", "its data file"),
        ("data file: s%02d.raw 0 15 0\n", "its data file"),
        ("data file: s%2x.raw 0 15 3\n", "its data file"),
        ("data file: s%99999999999d.raw 0 5 1\n", "its data file"),
        ("data file: s%d.raw -9223372036854775808 9223372036854775807 3689348814741910323\n", "its data file"),
        ("data file: slab 0.raw\n", "declares 120 bytes"),
    ] {
        let line = error(&format!("{start}encoding: raw\n{files}"));
        assert!(line.contains(said), "{files}: {line}");
    }
}

#[test]
fn bzip2_data_stops_at_the_declared_size_or_reports_damage() {
    let header = "type: uchar\nsizes: 100 10 10\nencoding: bzip2";
    let values: Vec<u8> = (0..10_000_u32).map(|i| ((i * i) >> 7) as u8).collect();
    let good = bzip2(&values);
    assert_eq!(volume(&file(header, &good)).values[9_999], f32::from(values[9_999]));
    let two = [bzip2(&values[..4000]), bzip2(&values[4000..])].concat();
    assert_eq!(volume(&file(header, &two)).values[9_999], f32::from(values[9_999]));
    let mut changed = good.clone();
    changed[good.len() - 3] ^= 16; // in the sum that closes the stream
    for damaged in [&good[..good.len() / 2], &good[..good.len() - 1], &changed, b"not bzip2 data", &gzip(&values)] {
        let error = error(&file(header, damaged));
        assert!(matches!(error, ShapeError::Decompression { .. }), "{error}");
    }
    let start = thread_seconds();
    // Of a bomb no more than declared is unpacked.
    assert_eq!(noted(&file(header, &bzip2(&vec![0; 40 << 20]))), (vec![0.0; 10_000], rest("some")));
    let short = error(&file("type: uchar\nsizes: 1000 1000 1000\nencoding: bzip2", &good));
    assert!(matches!(short, ShapeError::DataSize { found: Found::Bytes(10_000), .. }), "{short}");
    assert!(thread_seconds() - start < 4.0);
}

fn volume_of(path: &str) -> Volume {
    match open(path) {
        Ok(Shape::Volume(volume)) => volume,
        other => panic!("{:?}", other.err()),
    }
}

#[test]
fn a_volume_too_far_from_the_origin_for_its_spacing_is_refused() {
    let message = error(&small("spacings: 1 0.001 1\naxis mins: 0 1000 0")).to_string();
    assert!(message.contains("1000001 voxels from the origin is not supported; move it nearer"), "{message}");
}

#[test]
fn the_corners_of_a_volume_at_the_limit_of_distance_have_values() {
    let volume = volume(&small("spacings: 0.3 0.7 1.1\naxis mins: 39000.1 -90000.7 140000.3"));
    let bounds = volume.bounds();
    assert_eq!((volume.sample(bounds.min), volume.sample(bounds.max)), (Some(0.0), Some(5.0)));
}

#[test]
fn header_errors_name_the_line_and_the_value() {
    for (extra, part) in [
        ("spacings: 1 0 1", "line 7: expected distances between samples from 1.2e-38 to 1e18, found `1 0 1`"),
        ("spacings: 1 inf 1", "line 7: expected 3 numbers, found `1 inf 1`"),
        ("spacings: 1 1e-60 1", "line 7: expected distances"),
        ("space directions: (1,0,0) none (0,0,1)", "line 7: expected 3 vectors of 3 numbers"),
        ("space directions: (1,0,0) (0,1) (0,0,1)", "line 7: expected vectors of 3 numbers"),
        ("space directions: (1,0,0) (0,1,0)", "line 7: expected 3 vectors of 3 numbers"),
        ("space origin: (1,2,3) (4,5,6)", "line 7: expected one vector"),
        ("data file: other.raw", "header: the data file `other.raw` is not supported; put the file of the data beside"),
        ("byte skip: -2", "line 7: expected a number of bytes (at most 2^28 of compressed data), or -1, found `-2`"),
        ("byte skip: 7", "the header declares 6 bytes of data (3 x 2 x 1 voxels of 1 bytes after 7 bytes)"),
        ("line skip: 2", "(3 x 2 x 1 voxels of 1 bytes after 2 lines), the file holds 0"),
        ("line skip: many", "line 7: expected a number of lines, found `many`"),
        ("space directions: (1,0,0) (2,0,0) (0,0,1)", "a grid whose unit axes have the determinant 0.0e0"),
        ("space directions: (1,0,0) (0,0,0) (0,0,1)", "line 7: expected distances between samples"),
        ("kinds: vector domain domain", "line 7: kinds `vector domain domain` is not supported"),
        ("no field at all", "line 7: expected `field: value`"),
        ("sizes: 3 2 1", "line 7: expected each field once"),
        ("hypertexture content:=density", "line 7: expected `hypertexture content:=signed distance`, found `density`"),
    ] {
        let message = error(&small(extra)).to_string();
        assert!(message.starts_with("test.nrrd: ") && message.contains(part), "{message}");
        assert_eq!(message.lines().count(), 1);
    }
    for (header, part) in [
        ("type: block\nsizes: 1 1 1\nencoding: raw\nendian: big", "type `block` is not supported; convert"),
        (
            "type: short\nsizes: 1 1 1\nencoding: raw",
            "header: expected `endian: little` or `endian: big`, found nothing",
        ),
        ("type: uchar\nsizes: 1 1 1\nencoding: zip", "encoding `zip` is not supported; save it as raw, gzip, bzip2"),
        (
            "type: uchar\nsizes: 1 1\nencoding: raw",
            "line 5: expected `sizes` with 3 whole numbers, or as many as `dimension` says, found `1 1`",
        ),
        ("type: uchar\nsizes: 1 -1 1\nencoding: raw", "found `1 -1 1`"),
        ("sizes: 1 1 1\nencoding: raw", "header: expected a `type` field, found nothing"),
    ] {
        let message = error(&file(header, &[0; 8])).to_string();
        assert!(message.contains(part), "{message}");
    }
    let message = error(b"NRRD0004\ndimension: 4\nsizes: 2 2 2 2\ntype: uchar\n\n").to_string();
    assert!(message.contains("line 2: dimension `4` is not supported; extract one volume"), "{message}");
    assert!(error(b"NRRD0004\ndimension: 3\n").to_string().contains("the end of the file"));
    assert!(error(b"NRRD0009\n").to_string().contains("line 1: expected `NRRD0001` to `NRRD0005`"));
}

#[test]
fn an_axis_without_samples_is_refused() {
    let error = error(&file("type: uchar\nsizes: 4 0 4\nencoding: raw", &[]));
    assert!(matches!(error, ShapeError::ZeroSize { line: 5, size: [4, 0, 4], .. }), "{error}");
}

#[test]
fn sizes_above_the_budget_are_refused_without_overflow() {
    for sizes in ["4294967296 4294967296 4294967296", "2048 2048 513", "18446744073709551615 1 1"] {
        let error = error(&file(&format!("type: uchar\nsizes: {sizes}\nencoding: raw"), &[]));
        assert!(matches!(error, ShapeError::TooLarge { limit: 0x8000_0000, .. }), "{error}");
    }
}

#[test]
fn short_raw_data_is_refused_and_long_data_noted() {
    let whole = small("");
    let start = whole.len() as u64 - 6;
    for len in [whole.len() - 6, whole.len() - 1] {
        let there = Found::Bytes(len as u64 - start);
        let error = error(&whole[..len]);
        assert!(
            matches!(error, ShapeError::DataSize { offset: o, declared: 6, found: f, .. } if (o, f) == (start, there)),
            "{error}"
        );
    }
    let longer = [whole, vec![9]].concat();
    assert_eq!(noted(&longer), ((0..6).map(|value| value as f32).collect(), rest("1")));
}

#[test]
fn too_little_compressed_data_is_refused_before_reading() {
    let error = error(&file("type: uchar\nsizes: 1000 1000 1000\nencoding: gzip", &gzip(&[0; 1000])));
    assert!(matches!(error, ShapeError::DataSize { declared: 1_000_000_000, found: Found::AtMost(_), .. }), "{error}");
}

#[test]
fn damaged_truncated_short_and_long_gzip_data_are_told_apart() {
    let header = "type: uchar\nsizes: 100 10 10\nencoding: gzip";
    let values: Vec<u8> = (0..10_000_u32).map(|i| ((i * i) >> 7) as u8).collect();
    let good = gzip(&values);
    assert_eq!(volume(&file(header, &good)).values[9_999], f32::from(values[9_999]));
    let mut checksum = good.clone();
    let last = checksum.len() - 6;
    checksum[last] ^= 1;
    for damaged in [
        &good[..good.len() / 2],
        &good[..good.len() - 1],
        &checksum,
        b"not gzip data",
        &[good.as_slice(), b"junk"].concat(),
    ] {
        let error = error(&file(header, damaged));
        assert!(matches!(error, ShapeError::Decompression { .. }), "{error}");
    }
    let short = error(&file(header, &gzip(&values[..9_000])));
    assert!(matches!(short, ShapeError::DataSize { declared: 10_000, found: Found::Bytes(9_000), .. }), "{short}");
    let (long, note) = noted(&file(header, &gzip(&[values.as_slice(), &[0]].concat())));
    assert_eq!((long.len(), long[9_999], note), (10_000, f32::from(values[9_999]), rest("some")));
}

#[test]
fn voxels_that_are_not_finite_are_counted() {
    let values = [0.0, f64::NAN, 1e39, 1.0];
    let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    let error = error(&file("type: double\nsizes: 2 2 1\nencoding: raw\nendian: little", &data));
    assert!(matches!(error, ShapeError::NotFinite { count: 2, total: 4, first: 1, .. }), "{error}");
}
