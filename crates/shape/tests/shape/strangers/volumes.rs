//! NRRD, MetaImage and NIfTI.

use super::noted_volume;
use flate2::Compression;
use flate2::write::GzEncoder;
use glam::Vec3;
use hypertexture_shape::{Volume, read_noted};
use std::io::Write;

fn volume(name: &str, bytes: &[u8]) -> (Volume, String) {
    noted_volume(read_noted(name, bytes).unwrap_or_else(|error| panic!("{name}: {error}")))
}

fn data() -> Vec<u8> {
    (1..=60).collect()
}

fn values() -> Vec<f32> {
    (1..=60).map(|value: u8| f32::from(value)).collect()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// A NRRD of 4 x 5 x 3 bytes.
fn nrrd(header: &str, data: &[u8]) -> Vec<u8> {
    [format!("NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 5 3\n{header}\n\n").as_bytes(), data].concat()
}

/// A NIfTI of 4 x 5 x 3 bytes, whose header has further fields as offsets and bytes.
fn nifti(fields: &[(usize, &[u8])], data: &[u8]) -> Vec<u8> {
    let mut header = vec![0; 352];
    let sizes = [1.0f32, 0.5, 1.0, 2.0].map(f32::to_le_bytes).concat();
    let all: [(usize, &[u8]); 6] = [
        (0, &348i32.to_le_bytes()),
        (40, &[3, 0, 4, 0, 5, 0, 3, 0]),
        (70, &[2, 0, 8, 0]),
        (76, &sizes),
        (108, &352f32.to_le_bytes()),
        (344, b"n+1\0"),
    ];
    all.iter().chain(fields).for_each(|(at, bytes)| header[*at..at + bytes.len()].copy_from_slice(bytes));
    [&header, data].concat()
}

#[test]
fn bytes_after_the_data_are_left_out() {
    let long = [data(), vec![9, 9]].concat();
    let meta = |more: &str, data: &[u8]| {
        let header = "ObjectType = Image\nNDims = 3\nDimSize = 4 5 3\nElementType = MET_UCHAR\n";
        [header.as_bytes(), more.as_bytes(), b"ElementDataFile = LOCAL\n", data].concat()
    };
    let two = "bytes after the data that the header declares are left out: 2";
    let some = "bytes after the data that the header declares are left out: some";
    let text: String = (1..=61).map(|value| format!("{value} ")).collect();
    for (name, bytes, note) in [
        ("a.nrrd", nrrd("encoding: raw", &long), two),
        ("a.nrrd", nrrd("encoding: gzip", &gzip(&long)), some),
        (
            "a.nrrd",
            nrrd("encoding: ascii", text.as_bytes()),
            "numbers after the 60 that the header declares are left out",
        ),
        ("a.mha", meta("", &long), two),
        ("a.nii", nifti(&[], &long), two),
        ("a.nii.gz", gzip(&nifti(&[], &long)), some),
    ] {
        let (found, notes) = volume(name, &bytes);
        assert_eq!(found.values, values(), "{name}");
        assert!(notes.ends_with(note), "{name}: {notes}");
    }
    // A size too small is the same: the file is longer than declared.
    let (found, notes) = volume("a.nii", &nifti(&[(46, &[2, 0])], &data()));
    assert_eq!((found.values, notes), (values()[..40].to_vec(), two.replace('2', "20")));
    let short = read_noted("a.nii", &nifti(&[], &data()[..59])).unwrap_err().to_string();
    assert!(short.contains("declares 60 bytes") && short.contains("the file holds 59"), "{short}");
}

#[test]
fn nrrd_has_ends_repeated_keys_and_skips_of_packed_bytes() {
    let ends = "encoding: raw\naxis mins: 0 10 -3\naxis maxs: 8 20 3";
    let (found, notes) = volume("a.nrrd", &nrrd(ends, &data()));
    // Cells: 8 / 4, 10 / 5 and 6 / 3 wide, and the first samples in the middle of theirs.
    assert_eq!((found.spacing(), found.origin), (Vec3::splat(2.0), Vec3::new(1.0, 11.0, -2.0)));
    assert_eq!(notes, "its spacings follow from `axis mins` and `axis maxs`: 2 2 2");
    let nodes = format!("{ends}\ncenters: node node node");
    let (found, _) = volume("a.nrrd", &nrrd(&nodes, &data()));
    assert!((found.spacing() - Vec3::new(8.0 / 3.0, 2.5, 3.0)).abs().max_element() < 1e-6, "{:?}", found.spacing());
    assert_eq!(found.origin, Vec3::new(0.0, 10.0, -3.0));

    let twice = "encoding: raw\nmodality:=CT\nmodality:=MR";
    let (found, notes) = volume("a.nrrd", &nrrd(twice, &data()));
    assert_eq!((found.values, notes.as_str()), (values(), "the key `modality` is there twice: its last value counts"));

    let skipped = gzip(&[vec![77; 13], data()].concat());
    for skip in ["-1", "13"] {
        let (found, _) = volume("a.nrrd", &nrrd(&format!("encoding: gzip\nbyte skip: {skip}"), &skipped));
        assert_eq!(found.values, values(), "{skip}");
    }
}

#[test]
fn nifti_with_wrong_fields_is_read_by_the_others() {
    for (fields, note) in [
        (&[(72, &[32, 0][..])][..], "bitpix is 32: the 8 bits of its datatype, uint8, are read"),
        (
            &[(40, &[4, 0, 4, 0, 5, 0, 3, 0, 0, 0])],
            "it has sizes of 4 x 5 x 3 x 0: those of 0 beyond the third are read as 1",
        ),
        // An sform without directions, beside a qform without a turn.
        (&[(252, &[1, 0, 1, 0]), (268, &7f32.to_le_bytes())], "its sform has no directions: the qform is read"),
        (&[(254, &[1, 0])], "its sform has no directions: pixdim is read"),
    ] {
        let (found, notes) = volume("a.nii", &nifti(fields, &data()));
        assert_eq!((&found.values, found.spacing()), (&values(), Vec3::new(0.5, 1.0, 2.0)), "{note}");
        assert_eq!(notes, note);
    }
    let placed = volume("a.nii", &nifti(&[(252, &[1, 0, 1, 0]), (268, &7f32.to_le_bytes())], &data())).0;
    assert_eq!(placed.origin, Vec3::new(7.0, 0.0, 0.0));
    let early: &[(usize, &[u8])] = &[(108, &348f32.to_le_bytes())];
    let (found, notes) = volume("a.nii", &nifti(early, &data()));
    assert_eq!((found.values, notes.as_str()), (values(), "vox_offset is 348: its data is read from byte 352"));
    let mut without_flag = nifti(early, &data());
    without_flag.drain(348..352);
    let (found, notes) = volume("a.nii", &without_flag);
    assert_eq!((found.values, notes.as_str()), (values(), "vox_offset is 348: its data is read from byte 348"));
}
