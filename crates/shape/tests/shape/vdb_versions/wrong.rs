//! Refused files with the expected messages.

use super::reads::voxels;
use super::*;

#[test]
fn whatever_is_wrong_is_told_in_one_line() {
    let good = file(PLAIN, "level set");
    assert_truth(&volume(read("test.vdb", &good.bytes)), 0, PLAIN);
    let wrong = |file: &File, name: &str, skip: usize, bytes: &[u8], said: &str| {
        let mut bad = file.bytes.clone();
        let at = file.at[name] + skip;
        assert_ne!(&bad[at..at + bytes.len()], bytes, "{name}");
        bad[at..at + bytes.len()].copy_from_slice(bytes);
        let line = error(&bad);
        assert!(line.contains(said), "{name}: {line}");
    };
    let (nan, many) = (f32::NAN.to_le_bytes(), [255, 255, 255, 127]);
    let cases: [(&str, usize, &[u8], &str); 39] = [
        ("magic", 1, b"X", "expected ` BDV`, the mark of OpenVDB"),
        ("version", 0, &[219, 0, 0, 0], "byte 8: version 219 is not supported; versions 220 to 225 are read"),
        ("version", 0, &[226, 0, 0, 0], "version 226"),
        ("metadata of the file", 0, &many, "expected a name of at most 4096 bytes"),
        ("metadata of the file", 0, &[0; 4], "expected a name of at most 4096 bytes"),
        ("creator", 0, &many, "expected a name of at most 4096 bytes, found 2147483647 bytes"),
        ("grids", 0, &[0; 4], "a file of no grids is not supported"),
        ("name", 0, &many, "a name of at most 4096 bytes"),
        ("type", 4, b"Tree_bool_9_9_9_", "`a grid[2]` (`Tree_bool_9_9_9_`)"),
        ("type", 18, b"_6", "`Tree_float_5_4_6`"),
        ("blocks", 0, &[1], "expected the offset of the leaves of a grid"),
        ("blocks", 7, &[128], "expected the offset of the leaves of a grid"),
        ("end", 0, &[1], "expected the offset of the end of a grid"),
        ("flags", 0, &[8], "compression 8 is not supported"),
        ("flags", 0, &[ZIP as u8 | 2], "expected"),
        ("flags", 0, &[BLOSC as u8 | 2], "expected"),
        ("metadata", 0, &many, "the header declares 1071644672 bytes of data (metadata), the file holds"),
        ("metadata", 0, &[3], "the transform"),
        ("class", 19, &[10], "expected"),
        ("class", 23, b"LEVEL SET", "(class `LEVEL SET`)"),
        ("is_saved_as_half_float", 38, &[1], "expected `is_saved_as_half_float` as the type of the grid says it"),
        ("anything", 34, &many, "the header declares 2147483647 bytes of data (metadata)"),
        ("map", 4, b"uniformScaleMap", "the transform `uniformScaleMap` is not supported"),
        ("map", 0, &many, "a name of at most 4096 bytes"),
        ("scale", 0, &[0; 8], "expected distances between samples"),
        ("scale", 0, &f64::NAN.to_le_bytes(), "expected distances between samples"),
        ("scale", 0, &1e300_f64.to_le_bytes(), "expected distances between samples"),
        ("scale", 0, &1e-300_f64.to_le_bytes(), "expected distances between samples"),
        ("buffers", 0, &[2], "expected a tree with 1 buffer, found 2"),
        ("tiles", 0, &many, "expected"),
        ("children", 0, &many, "expected multiples of 4096 up to 2^30, each once"),
        ("children", 0, &[0; 4], "expected the offset of the leaves of a grid"),
        ("tile", 0, &[1], "expected multiples of 4096 up to 2^30, each once, as origins"),
        (
            "tile",
            0,
            &[0; 4],
            "expected multiples of 4096 up to 2^30, each once, as origins of the root's children, found `[0, 0, 0]`",
        ),
        ("tile activity", 0, &[1], "voxels in the box around the active ones, the limit is"),
        ("values of 32", 0, &[7], "expected a code of a node from 0 to 6, found 7"),
        ("values of 16", 0, &[255], "expected a code of a node from 0 to 6, found 255"),
        ("mask of 16", 511, &[255], "expected"),
        ("mask of a leaf", 0, &[0], "expected the same mask of a leaf as in the tree"),
    ];
    for (name, skip, bytes, said) in cases {
        wrong(&good, name, skip, bytes, said);
    }
    for (name, skip) in [("background", 0), ("tile value", 0), ("values", 1)] {
        let mut bytes = good.bytes.clone();
        bytes[good.at[name] + skip..][..4].copy_from_slice(&nan);
        let notes = read_noted("test.vdb", &bytes).unwrap().notes.join("; ");
        assert!(notes.contains("of 23400 voxels are NaN or infinite: they are outside"), "{name}: {notes}");
    }
    let blosc = file(Kind { flags: BLOSC | MASK, ..PLAIN }, "level set");
    let zip = file(Kind { flags: ZIP | MASK, ..PLAIN }, "level set");
    for (file, skip, bytes, said) in [
        (&blosc, 7, &[64][..], "the length of the values of a node"),
        (&blosc, 7, &[128], "the length of the values of a node"),
        (&blosc, 8, &[9], "Blosc version 9 is not supported"),
        (&blosc, 10, &[0x34], "Blosc shuffle of bits is not supported"),
        (&blosc, 10, &[0x31], "compressed data damaged after 0 good bytes"),
        (&blosc, 12, &[9], "compressed data damaged after 0 good bytes: its Blosc header is of another length"),
        (&zip, 7, &[64], "the length of the values of a node"),
        (&zip, 0, &[0; 8], "the length of the values of a node"),
        (&zip, 8, &[0; 8], "compressed data damaged"),
    ] {
        wrong(file, "length", skip, bytes, said);
    }
    // Values of a node that become more or fewer than there are places.
    for (places, said) in
        [(4, "the header declares 1364 bytes of data (values of a node), the file holds 16"), (600, "more")]
    {
        let mut bad = zip.clone();
        let at = bad.at["length"];
        bad.bytes.truncate(at);
        bad.packed(ZIP, &vec![0; 4 * places]);
        let line = error(&bad.bytes);
        assert!(line.contains(said), "{line}");
    }
    let doubles = file(Kind { is_double: true, ..PLAIN }, "fog volume");
    wrong(
        &doubles,
        "values",
        1,
        &1e300_f64.to_le_bytes(),
        "1 of 23400 voxels are NaN, infinite or beyond 32-bit floats",
    );
    let empty = error(&voxels(&[]));
    assert!(empty.contains("without active voxels is not supported"), "{empty}");
    assert!(error(&voxels(&[[0; 3]; 2])).contains("each once"));
}

#[test]
fn a_file_that_is_cut_off_anywhere_is_told_so() {
    for kind in [PLAIN, Kind { flags: ZIP | MASK, is_half: true, ..PLAIN }, Kind { flags: BLOSC | MASK, ..PLAIN }] {
        let good = file(kind, "level set");
        // In the masks one place is like the next.
        let end = good.bytes.len();
        let dense = |at: usize| at < good.at["mask of 32"] + 50 || at > good.at["active of 16"] && at.is_multiple_of(5);
        for length in (1..end).filter(|at| dense(*at) || at.is_multiple_of(499)) {
            error(&good.bytes[..length]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_give_a_volume_or_one_line(
        changes in prop::collection::vec((0.0..1.0, any::<u8>()), 1..6), seed in 0..5_usize, is_late in any::<bool>()
    ) {
        let flags = [MASK, 0, ZIP | MASK, BLOSC | MASK, ZIP][seed];
        let good = file(Kind { flags, code: 4, version: [224, 221][usize::from(seed == 4)], ..PLAIN }, "level set");
        let mut bytes = good.bytes;
        // Nearly all bytes between are zeros.
        let (start, end) = if is_late { (good.at["mask of 16"], bytes.len()) } else { (0, good.at["mask of 32"]) };
        for (place, byte) in changes {
            bytes[start + (place * (end - start) as f64) as usize] = byte;
        }
        match read("a.vdb", &bytes) {
            Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1, "{}", error),
            Ok(Shape::Volume(volume)) => {
                let voxels: u64 = volume.size.iter().map(|&n| u64::from(n)).product();
                prop_assert_eq!(voxels, volume.values.len() as u64);
                prop_assert!(volume.values.iter().all(|value| value.is_finite()) && voxels <= 1 << 26);
            }
            other => prop_assert!(false, "{other:?}"),
        }
    }
}
