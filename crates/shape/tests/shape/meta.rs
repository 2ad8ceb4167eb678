//! MetaImage: data after the header or in data files; reading and refusals.

use crate::packed::zlib;
use glam::{Mat3, Vec3};
use hypertexture_shape::{Content, Opened, Shape, Volume, open, read};
use std::fs;

/// Name and encoder of a type.
type Type = (&'static str, fn(f32) -> Vec<u8>);

/// Types with encoders of numbers from 0 to 99, in little endian.
const TYPES: [Type; 12] = [
    ("MET_CHAR", |x| (x as i8 - 50).to_le_bytes().into()),
    ("MET_UCHAR", |x| (x as u8).to_le_bytes().into()),
    ("MET_SHORT", |x| (x as i16 * 300 - 5000).to_le_bytes().into()),
    ("MET_USHORT", |x| (x as u16 * 600).to_le_bytes().into()),
    ("MET_INT", |x| (x as i32 * 100_000 - 7).to_le_bytes().into()),
    ("MET_UINT", |x| (x as u32 * 100_000).to_le_bytes().into()),
    ("MET_LONG", |x| (x as i32 * -1000).to_le_bytes().into()),
    ("MET_ULONG", |x| (x as u32 * 1000).to_le_bytes().into()),
    ("MET_LONG_LONG", |x| (x as i64 * -(1 << 40)).to_le_bytes().into()),
    ("MET_ULONG_LONG", |x| (x as u64 * (1 << 50)).to_le_bytes().into()),
    ("MET_FLOAT", |x| (x * 0.37 - 1.0).to_le_bytes().into()),
    ("MET_DOUBLE", |x| f64::from(x * 0.5).to_le_bytes().into()),
];
const WORTH: [fn(f32) -> f32; 12] = [
    |x| x - 50.0,
    |x| x,
    |x| x * 300.0 - 5000.0,
    |x| x * 600.0,
    |x| x * 100_000.0 - 7.0,
    |x| x * 100_000.0,
    |x| x * -1000.0,
    |x| x * 1000.0,
    |x| x * -(40f32.exp2()),
    |x| x * 50f32.exp2(),
    |x| x * 0.37 - 1.0,
    |x| x * 0.5,
];

/// World axes in LPS, as in the header.
const MATRIX: &str = "-1 0 0 0 -1 0 0 0 1";
const HEADER: &str = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n\
                      TransformMatrix = -1 0 0 0 -1 0 0 0 1\nOffset = -1.5 2 0.25\nCenterOfRotation = 0 0 0\n\
                      AnatomicalOrientation = LPI\nElementSpacing = 0.5 1 2\nDimSize = 4 5 3\nElementType = MET_UCHAR\n\
                      ElementDataFile = LOCAL\n";

/// Directions of axes in LPS.
fn lps(directions: &str) -> String {
    let turned = directions.split(' ').enumerate().map(|(place, part)| match part.strip_prefix('-') {
        _ if place % 3 == 2 || part == "0" => part.to_string(),
        Some(part) => part.to_string(),
        None => format!("-{part}"),
    });
    turned.collect::<Vec<_>>().join(" ")
}

/// Numbers 0 to 59 of a type.
fn data(kind: usize, big_endian: bool) -> Vec<u8> {
    let one = |index: u32| {
        let mut bytes = TYPES[kind].1(index as f32);
        if big_endian {
            bytes.reverse();
        }
        bytes
    };
    (0..60).flat_map(one).collect()
}

fn volume(shape: Result<Shape, hypertexture_shape::ShapeError>) -> Volume {
    match shape {
        Ok(Shape::Volume(volume)) => volume,
        other => panic!("{other:?}"),
    }
}

fn error(header: &str, data: &[u8]) -> String {
    let line = read("test.mha", &[header.as_bytes(), data].concat()).unwrap_err().to_string();
    assert!(line.starts_with("test.mha: ") && !line.contains('\n'), "{line}");
    line
}

#[test]
fn every_type_order_and_packing_gives_the_values_in_their_place() {
    for (kind, (name, _)) in TYPES.iter().enumerate() {
        for big_endian in [false, true] {
            for packed in [false, true] {
                let header = HEADER
                    .replace("MET_UCHAR", name)
                    .replace("MSB = False", if big_endian { "MSB = True" } else { "MSB = False" })
                    .replace(
                        "CompressedData = False",
                        if packed { "CompressedData = True" } else { "CompressedData = False" },
                    );
                let data = data(kind, big_endian);
                let data = if packed { zlib(&data) } else { data };
                let read = volume(read("test.mha", &[header.as_bytes(), &data].concat()));
                let found = (read.size, read.origin, read.spacing(), read.content);
                assert_eq!(found, ([4, 5, 3], Vec3::new(1.5, -2.0, 0.25), Vec3::new(0.5, 1.0, 2.0), Content::Scalar));
                for (index, value) in read.values.iter().enumerate() {
                    assert_eq!(*value, WORTH[kind](index as f32), "{name}, {index}");
                }
            }
        }
    }
}

#[test]
fn an_axis_that_runs_backwards_is_turned() {
    let header = HEADER.replace(MATRIX, &lps("1 0 0 0 -1 0 0 0 1"));
    let read = volume(read("test.mha", &[header.as_bytes(), &data(1, false)].concat()));
    assert_eq!(read.origin, Vec3::new(1.5, -6.0, 0.25));
    // The first sample of the file is at its offset.
    assert_eq!(read.sample(Vec3::new(1.5, -2.0, 0.25)), Some(0.0));
    assert_eq!(read.sample(Vec3::new(2.0, -3.0, 0.25)), Some(5.0));
}

/// Volume of numbers 0 to 59 with these directions of axes.
fn turned(directions: &str) -> Volume {
    let header = HEADER.replace(MATRIX, &lps(directions));
    volume(read("test.mha", &[header.as_bytes(), &data(1, false)].concat()))
}

#[test]
fn an_oblique_grid_follows_its_directions() {
    // 0.6 0.8 0 is where the first axis goes: sample (1, 2, 1) is 0.5 of it, 2 of the second and 2 of the third away.
    let read = turned("0.6 0.8 0 -0.8 0.6 0 0 0 1");
    let columns = [Vec3::new(0.3, 0.4, 0.0), Vec3::new(-0.8, 0.6, 0.0), Vec3::new(0.0, 0.0, 2.0)];
    assert_eq!((read.size, read.origin), ([4, 5, 3], Vec3::new(1.5, -2.0, 0.25)));
    assert_eq!(read.steps, Mat3::from_cols(columns[0], columns[1], columns[2]));
    let place = Vec3::new(1.5 + 0.3 - 1.6, -2.0 + 0.4 + 1.2, 0.25 + 2.0);
    assert!(read.position([1, 2, 1]).distance(place) < 1e-6 && !read.is_aligned());
    assert!((read.sample(place).unwrap() - 29.0).abs() < 1e-5);
    assert_eq!(read.values[29], 29.0);
    // From the first to the last sample, the second axis goes to the left.
    let bounds = read.bounds();
    assert!((bounds.min - Vec3::new(1.5 - 3.2, -2.0, 0.25)).abs().max_element() < 1e-6, "{bounds:?}");
    assert!((bounds.max - Vec3::new(1.5 + 0.9, -2.0 + 1.2 + 2.4, 4.25)).abs().max_element() < 1e-6, "{bounds:?}");
    // Skewed, and seen in a mirror.
    let read = turned("1 0 0 0.5 -1 0 0.25 0 1");
    assert_eq!(read.steps, Mat3::from_cols(0.5 * Vec3::X, Vec3::new(0.5, -1.0, 0.0), Vec3::new(0.5, 0.0, 2.0)));
    assert!(read.steps.determinant() < 0.0);
}

#[test]
fn exchanged_axes_are_ordered_despite_rounding() {
    for directions in ["0 1 0 0 0 -1 1 0 0", "6.1e-17 1 0 0 -6.1e-17 -1 1 6.1e-17 3e-9"] {
        let read = turned(directions);
        assert_eq!((read.size, read.spacing(), read.is_aligned()), ([3, 4, 5], Vec3::new(2.0, 0.5, 1.0), true));
        // The second axis of the file runs down.
        assert_eq!(read.origin, Vec3::new(1.5, -2.0, 0.25 - 4.0));
        assert_eq!(read.sample(Vec3::new(1.5, -2.0, 0.25)), Some(0.0));
        // Sample (3, 2, 1) of the file.
        assert_eq!(read.sample(Vec3::new(1.5 + 2.0, -2.0 + 1.5, 0.25 - 2.0)), Some(31.0));
    }
    let tilted = turned("1 0 0 0 1 1e-6 0 0 1");
    assert!(!tilted.is_aligned());
}

#[test]
fn a_comment_marks_signed_distances_along_the_axes() {
    let marked = HEADER.replace("NDims", "Comment = hypertexture signed distance\nNDims");
    let read = volume(read("test.mha", &[marked.as_bytes(), &data(1, false)].concat()));
    assert_eq!(read.content, Content::SignedDistance);
    let oblique = marked.replace(MATRIX, "0.6 0.8 0 -0.8 0.6 0 0 0 1");
    let line = error(&oblique, &data(1, false));
    assert!(line.contains("a signed distance on a grid that is not along the axes of the world"), "{line}");
    assert!(line.contains("resample it onto these axes, or save it as a scalar volume"), "{line}");
}

#[test]
fn a_file_for_each_slice_is_read_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for (z, slice) in data(1, false).chunks(20).enumerate() {
        fs::write(at(&format!("s{:03}.raw", 7 - 2 * z)), slice).unwrap();
        fs::write(at(&format!("h{z}.raw")), [&[9; 11], slice].concat()).unwrap();
        fs::write(at(&format!("z {z}.zraw")), zlib(slice)).unwrap();
    }
    for (change, files) in [
        ("", "LIST\ns007.raw\n\n s005.raw\r\ns003.raw"),
        ("", "LIST 2D\ns007.raw\ns005.raw\ns003.raw\n"),
        ("", "s%03d.raw 7 3 -2"),
        ("HeaderSize = 11\n", "h%d.raw 0 2 1"),
        ("HeaderSize = -1\n", "LIST\nh0.raw\nh1.raw\nh2.raw\n"),
        ("CompressedData = True\n", "z %i.zraw 0 2 1"),
    ] {
        let header = HEADER.replace("LOCAL\n", files);
        let header = if change.starts_with('C') { header.replace("CompressedData = False\n", "") } else { header };
        fs::write(at("v.mhd"), header.replacen("NDims", &format!("{change}NDims"), 1)).unwrap();
        let values = volume(open(&at("v.mhd").display().to_string())).values;
        assert_eq!(values, (0..60).map(|i| i as f32).collect::<Vec<_>>(), "{files}");
    }
    // One of them is short.
    fs::write(at("s005.raw"), [0; 19]).unwrap();
    fs::write(at("v.mhd"), HEADER.replace("LOCAL\n", "s%03d.raw 3 7 2")).unwrap();
    let line = open(&at("v.mhd").display().to_string()).unwrap_err().to_string();
    assert!(line.contains("s005.raw: byte 0: the header declares 20 bytes of data (20 of 4 x 5 x 3 voxels"), "{line}");
}

#[test]
fn a_header_size_counts_from_the_start_of_its_file() {
    for size in [400, 401, -1] {
        let header = HEADER.replace("NDims", &format!("HeaderSize = {size}\nNDims"));
        let end = if size < 0 { 500 } else { size as usize };
        let before = vec![b' '; end - header.len()];
        let read = volume(read("a.mha", &[header.as_bytes(), &before, &data(1, false)].concat()));
        assert_eq!(read.values[59], 59.0);
    }
}

#[test]
fn data_beside_the_header_is_read_and_what_is_before_it_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let shown = |name: &str| at(name).display().to_string();
    fs::create_dir(at("deep")).unwrap();
    fs::write(at("deep/v.raw"), data(1, false)).unwrap();
    fs::write(at("v.zraw"), zlib(&data(1, false))).unwrap();
    fs::write(at("h.raw"), [&[9; 17][..], &data(1, false)].concat()).unwrap();
    let expected = volume(read("x.mha", &[HEADER.as_bytes(), &data(1, false)].concat()));
    for (change, file) in [
        ("", "deep/v.raw"),
        ("", "./deep/v.raw"),
        ("CompressedData = True\n", "v.zraw"),
        ("HeaderSize = 17\n", "h.raw"),
        ("HeaderSize = -1\n", "h.raw"),
    ] {
        let header = HEADER.replace("LOCAL", file);
        let header = if change.starts_with('C') { header.replace("CompressedData = False\n", "") } else { header };
        fs::write(at("v.mhd"), header.replacen("NDims", &format!("{change}NDims"), 1)).unwrap();
        let read = volume(open(&shown("v.mhd")));
        assert_eq!((read.size, read.origin, read.values), (expected.size, expected.origin, expected.values.clone()));
    }
    // A header of NRRD knows the same.
    for (change, file) in [("", "deep/v.raw"), ("byte skip: 17\n", "h.raw"), ("byte skip: -1\n", "h.raw")] {
        let header =
            format!("NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 5 3\nencoding: raw\n{change}data file: {file}\n\n");
        for header in [header.as_str(), header.trim_end()] {
            fs::write(at("v.nhdr"), header).unwrap();
            assert_eq!(volume(open(&shown("v.nhdr"))).values, expected.values);
        }
    }
    for (file, said) in [
        ("none.raw", "its data file"),
        ("../v.raw", "put the file of the data beside this one"),
        ("/etc/passwd", "put the file of the data beside this one"),
        ("deep", "is a directory"),
        ("a\u{0}b", "its data file"),
        (&"n".repeat(256), "the data file `nnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnn...` is not supported; put"),
        (&"n/".repeat(600), "put the file of the data beside this one"),
        (&"n/".repeat(500), "its data file"),
        ("LIST", "found `LIST` with 0 files for 3 slices"),
        ("LIST\ndeep/v.raw\n", "with 1 files for 3 slices"),
        ("LIST 1\na\nb\nc\n", "with 3 files for 3 slices"),
        ("LIST 4D\na\nb\nc\n", "with 3 files for 3 slices"),
        ("slice%03d.raw 1 4 1", "with 4 files for 3 slices"),
        ("slice%03d.raw 1 3 1", "its data file"),
        ("slice%03d.raw 1 3 -1", "its data file"),
    ] {
        fs::write(at("v.mhd"), HEADER.replace("LOCAL", file)).unwrap();
        let line = open(&shown("v.mhd")).unwrap_err().to_string();
        assert!(line.contains(said) && !line.contains('\n'), "{file}: {line}");
    }
    // Of a file that is longer than declared, the first values count.
    fs::write(at("v.mhd"), HEADER.replace("LOCAL", "h.raw")).unwrap();
    let opened = Opened::of(&shown("v.mhd")).unwrap();
    assert_eq!(opened.notes, ["bytes after the data that the header declares are left out: 17"]);
    assert!(error(&HEADER.replace("LOCAL", "v.raw"), &[]).contains("put the file of the data beside this one"));
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    for (from, to, said) in [
        ("= Image", "= Tube", "line 1: ObjectType `Tube` is not supported"),
        ("NDims = 3", "NDims = 2", "line 2: expected `NDims = 3`"),
        (
            "NDims = 3",
            "NDims = 4",
            "line 11: expected `DimSize` with a whole number of at least 1 for each dimension, found `4 5 3`",
        ),
        ("NDims = 3\n", "", "header: expected `NDims = 3`"),
        ("BinaryData = True", "BinaryData = False", "line 3: BinaryData `False` is not supported"),
        ("MSB = False", "MSB = maybe", "line 4: expected `True` or `False`"),
        (MATRIX, "1 0 0 1 0 0 0 0 1", "a grid whose unit axes have the determinant 0.0e0"),
        (MATRIX, "1 0 0 0 0 0 0 0 1", "line 6: expected distances between samples"),
        (MATRIX, "1 0 0", "line 6: expected 9 finite numbers"),
        ("-1.5 2 0.25", "1.5 inf 0.25", "line 7: expected 3 finite numbers"),
        ("-1.5 2 0.25", "1e9 0 0", "voxels from the origin is not supported"),
        ("0.5 1 2", "0.5 0 2", "line 10: expected distances between samples"),
        ("0.5 1 2", "0.5 1e19 2", "line 10: expected distances between samples"),
        ("4 5 3", "4 0 3", "line 11: expected `DimSize`"),
        ("4 5 3", "4 5", "line 11: expected `DimSize`"),
        ("4 5 3", "4000000000 4000000000 4000000000", "voxels, the limit is"),
        ("4 5 3", "4 5 4", "the header declares 80 bytes of data (4 x 5 x 4 voxels of 1 bytes), the file holds 60"),
        ("MET_UCHAR", "MET_UCHAR_ARRAY", "line 12: ElementType `MET_UCHAR_ARRAY` is not supported"),
        ("MET_UCHAR", "MET_FLOAT", "the header declares 240 bytes"),
        ("ElementType = MET_UCHAR\n", "", "header: expected `ElementType = MET_...`"),
        ("ElementDataFile = LOCAL\n", "", "`ElementDataFile = ...`, found the end of the file"),
        ("Offset", "NDims", "expected each key once"),
        ("CompressedData = False", "CompressedData = True", "compressed data damaged"),
        (
            "ElementSpacing",
            "ElementNumberOfChannels = 3\nElementSpacing",
            "ElementNumberOfChannels `3` is not supported",
        ),
        ("ElementSpacing", "HeaderSize = many\nElementSpacing", "expected a number of bytes before the data, or -1"),
        ("ElementSpacing", "HeaderSize = 20\nElementSpacing", "expected a number of bytes before the data, or -1"),
        ("ElementSpacing", "HeaderSize = -2\nElementSpacing", "expected a number of bytes before the data, or -1"),
        (
            "CompressedData = False",
            "CompressedData = True\nHeaderSize = -1",
            "HeaderSize `-1` is not supported; of compressed data, say how many bytes",
        ),
        ("Offset = ", "Offset ", "line 7: expected `Key = value`"),
    ] {
        let bad = HEADER.replacen(from, to, 1);
        assert_ne!(bad, HEADER, "{from}");
        let data = if to.is_empty() && from.starts_with("ElementDataFile") { Vec::new() } else { data(1, false) };
        let line = error(&bad, &data);
        assert!(line.contains(said), "{from} -> {to}: {line}");
    }
    let bomb = HEADER.replace("4 5 3", "1000 1000 1000").replace("CompressedData = False", "CompressedData = True");
    assert!(error(&bomb, &zlib(&[0; 1000])).contains("at most"));
    let infinite = HEADER.replace("MET_UCHAR", "MET_FLOAT");
    let mut values = data(10, false);
    values[16..20].copy_from_slice(&f32::INFINITY.to_le_bytes());
    assert!(error(&infinite, &values).contains("1 of 60 voxels are NaN"));
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_small_head_has_its_known_voxels() {
    let folder = std::env::var("HYPERTEXTURE_DATA").unwrap();
    let head = volume(open(&format!("{folder}/ct_head_unc_64.mhd")));
    assert_eq!((head.size, head.spacing(), head.origin), ([64, 64, 56], Vec3::splat(4.0), Vec3::new(1.5, 1.5, 1.0)));
    assert_eq!(head.range(), (0.0, 3167.0));
    let mean = head.values.iter().map(|value| f64::from(*value)).sum::<f64>() / head.values.len() as f64;
    assert!((mean - 380.979).abs() < 5e-4, "{mean}");
    for (iso, count) in [(500.0, 62_581), (1300.0, 14_116)] {
        assert_eq!(head.values.iter().filter(|&&value| value >= iso).count(), count);
    }
}
