//! Invalid DICOM files and folders, with the expected messages.

use crate::dicom::files::{CT, Desk, File, ITEM, LITTLE, OPEN, PIXELS, WAYS, Way, at, frames, series, volume};
use crate::packed::thread_seconds;
use hypertexture_shape::{open, read};
use std::fs;

/// Error of a series with a modified file.
fn bad() -> Vec<(Vec<u8>, &'static str)> {
    let mut all: Vec<(Vec<u8>, &'static str)> = Vec::new();
    let texts: &[(u32, &[u8; 2], &str, &str)] = &[
        (0x0020_0032, b"DS", "1\\2", "ImagePositionPatient of 3 numbers, found `1\\\\2`"),
        (0x0020_0032, b"DS", "1\\2\\3\\4", "ImagePositionPatient of 3 numbers"),
        (0x0020_0032, b"DS", "1\\x\\3", "ImagePositionPatient of 3 numbers"),
        (0x0020_0032, b"DS", "1\\nan\\3", "ImagePositionPatient of 3 numbers"),
        (0x0020_0032, b"DS", "1\\1e999\\3", "ImagePositionPatient of 3 numbers"),
        (0x0020_0032, b"DS", "", "ImagePositionPatient of 3 numbers, found ``"),
        (0x0020_0032, b"DS", "10\\-20\\9.3", "expected slices at even distances, none missing"),
        (0x0020_0032, b"DS", "10\\-20\\9", "one slice at each place, found `a` and `b.dcm` both at 9.0 mm"),
        (0x0020_0032, b"DS", "11\\-20\\7", "straight line at even distances, found `b.dcm` 1.0 mm off it"),
        (0x0020_0032, b"DS", "10\\-20\\1e30", "expected slices at even distances"),
        (0x0020_0037, b"DS", "1\\0\\0\\0\\1", "ImageOrientationPatient of 6 numbers"),
        (0x0020_0037, b"DS", "1\\0\\0\\0\\0\\1", "the same orientation of all slices"),
        (0x0020_0037, b"DS", "1\\0\\0\\1\\0\\0", "two directions at right angles"),
        (0x0020_0037, b"DS", "1\\0\\0\\0\\2\\0", "two directions at right angles"),
        (0x0020_0037, b"DS", "0\\0\\0\\0\\0\\0", "two directions at right angles"),
        (0x0028_0030, b"DS", "1", "PixelSpacing of 2 numbers"),
        (0x0028_0030, b"DS", "0.75\\0.5", "the same PixelSpacing in all slices"),
        (0x0028_0030, b"DS", "0\\1", "a PixelSpacing above 0"),
        (0x0028_0030, b"DS", "-1\\1", "a PixelSpacing above 0"),
        (0x0028_1053, b"DS", "0", "RescaleSlope that is not 0"),
        (0x0028_1053, b"DS", "1\\1", "RescaleSlope of one number"),
        (0x0028_1053, b"DS", "inf", "RescaleSlope of one number"),
        (0x0028_1053, b"DS", "1e300", "12 of 36 voxels are NaN, infinite"),
        (0x0028_1052, b"DS", "two", "RescaleIntercept of one number, found `two`"),
        (0x0028_0004, b"CS", "MONOCHROME1", "PhotometricInterpretation `MONOCHROME1` is not supported"),
        (0x0028_0004, b"CS", "RGB", "PhotometricInterpretation `RGB` is not supported"),
        (0x0028_0004, b"CS", "PALETTE COLOR", "`PALETTE COLOR` is not supported"),
        (0x0028_0008, b"IS", "2", "found 24 for 4 x 3 x 2 pixels of 16 bits"),
        (0x0028_0008, b"IS", "0", "0 frames, 0 of them"),
        (0x0028_0008, b"IS", "1e300", "frames, 0 of them"),
        (0x0028_0010, b"CS", "four", "a number of 16 bits, found (0028,0010) of 4 bytes"),
    ];
    let with = |edit: &dyn Fn(&mut File)| {
        let mut file = File::slice(LITTLE, 1, at(1));
        edit(&mut file);
        file.bytes()
    };
    all.extend(texts.iter().map(|&(tag, kind, text, said)| (with(&|file| file.text(tag, kind, text)), said)));
    let shorts: &[(u32, u16, &str)] = &[
        (0x0028_0002, 3, "SamplesPerPixel 3 is not supported"),
        (0x0028_0010, 4, "found 24 for 4 x 4 x 1 pixels of 16 bits"),
        (0x0028_0011, 65_535, "found 24 for 65535 x 3 x 1 pixels"),
        (0x0028_0100, 8, "BitsStored and HighBit inside of BitsAllocated"),
        (0x0028_0100, 32, "found 24 for 4 x 3 x 1 pixels of 32 bits"),
        (0x0028_0100, 1, "BitsAllocated 1 is not supported"),
        (0x0028_0100, 12, "BitsAllocated 12 is not supported"),
        (0x0028_0101, 0, "found 0 bits up to bit 15 of 16"),
        (0x0028_0101, 17, "found 17 bits up to bit 15 of 16"),
        (0x0028_0102, 16, "found 16 bits up to bit 16 of 16"),
        (0x0028_0102, 65_535, "up to bit 65535 of 16"),
    ];
    all.extend(shorts.iter().map(|&(tag, number, said)| (with(&|file| file.short(tag, number)), said)));
    let missing = [
        (0x0020_0032, "an ImagePositionPatient, found none in `b.dcm`"),
        (0x0020_0037, "an ImageOrientationPatient, found none in `b.dcm`"),
        (0x0028_0030, "a PixelSpacing, found none in `b.dcm`"),
        (0x0028_0100, "BitsAllocated 0 is not supported"),
        (0x0028_0004, "PhotometricInterpretation `` is not supported"),
        (PIXELS, "expected Rows, Columns and pixels (7FE0,0010), found no picture"),
        (0x0028_0010, "expected Rows, Columns and pixels"),
    ];
    all.extend(missing.map(|(tag, said)| (with(&|file| drop(file.elements.remove(&tag))), said)));
    let other_size = with(&|file| {
        file.short(0x0028_0010, 2);
        file.pixels((16, 16, 15, true), &[1; 8]);
    });
    all.push((other_size, "as many rows and columns in all slices, found 4 x 2 and 4 x 3 in `b.dcm`"));
    let table = |file: &mut File| file.sequence(0x0028_3000, &[LITTLE.element(0x0028_3003, b"LO", b"x")], true);
    all.push((with(&table), "an image with a ModalityLUTSequence is not supported"));
    all.push((with(&|file| file.set(0x7fe0_0008, b"OF", &[0; 48])), "an image of floats is not supported"));
    let deep = |levels: usize| {
        move |file: &mut File| {
            let level = [LITTLE.head(0x0008_2112, b"SQ", OPEN), LITTLE.head(ITEM, b"  ", OPEN)].concat();
            file.elements.insert(0x0008_2112, level.repeat(levels));
        }
    };
    all.push((with(&deep(17)), "at most 16 sequences inside each other, found more"));
    all.push((with(&deep(100_000)), "at most 16 sequences inside each other, found more"));
    for (bytes, said) in [
        (LITTLE.head(ITEM, b"  ", 0), "items in sequences, and their ends after them"),
        (LITTLE.head(0xfffe_e0dd, b"  ", 0), "items in sequences, and their ends after them"),
        (LITTLE.head(0x0029_0010, b"l\xff", 0), "the two letters of a type"),
        (LITTLE.head(0x0029_0010, b"OB", 1 << 30), "the header declares 1073741824 bytes of data"),
        (LITTLE.head(0x0028_0030, b"UN", 5000), "a value of at most 1024 bytes, found (0028,0030) of 5000 bytes"),
        (
            [LITTLE.head(0x0029_0010, b"SQ", OPEN), LITTLE.head(0x0029_0011, b"SH", 0)].concat(),
            "an item in a sequence, found (0029,0011)",
        ),
        (
            [LITTLE.head(0x5200_9229, b"SQ", 9), LITTLE.head(ITEM, b"  ", 20)].concat(),
            "elements that end where their sequence ends",
        ),
    ] {
        all.push((with(&|file| drop(file.elements.insert(0x0029_0010, bytes.clone()))), said));
    }
    for (uid, said) in [
        (
            "1.2.840.10008.1.2.4.90",
            "the transfer syntax JPEG 2000 (`1.2.840.10008.1.2.4.90`) is not supported; unpack it with `gdcmconv --raw`",
        ),
        ("1.2.840.10008.1.2.4.80", "the transfer syntax JPEG-LS"),
        ("1.2.840.10008.1.2.4.201", "the transfer syntax HTJ2K"),
        ("1.2.840.10008.1.2.4.103", "the transfer syntax MPEG"),
        ("1.2.840.10008.1.2.1.99", "compressed data damaged"),
        ("1.2.3", "the transfer syntax unknown (`1.2.3`)"),
    ] {
        let elements = File::slice(LITTLE, 1, at(1)).bytes().split_off(LITTLE.header(CT).len());
        all.push(([Way { uid, ..LITTLE }.header(CT), elements].concat(), said));
    }
    all.push((LITTLE.header("1.2.840.10008.1.3.10"), "the DICOMDIR is not supported; it only names files"));
    let good = File::slice(LITTLE, 1, at(1)).bytes();
    all.push((
        [&good[..132], &good[144..]].concat(),
        "a header that begins with its length (0002,0000), found (0002,0001)",
    ));
    all.push((good[4..].to_vec(), "a DICOM file without the mark `DICM` is not supported"));
    all.push((b"DICM".repeat(40), "a header that begins with its length"));
    let mut bent = good.clone();
    bent[140..144].copy_from_slice(&[14, 0, 0, 0]);
    all.push((bent, "a transfer syntax (0002,0010), found none"));
    all
}

#[test]
fn whatever_is_wrong_with_a_slice_is_told_in_one_line() {
    let all = bad();
    assert!(all.len() >= 70, "{}", all.len());
    for (bytes, said) in all {
        let desk = series(LITTLE, |_, _| {});
        fs::write(desk.path("b.dcm"), bytes).unwrap();
        let start = thread_seconds();
        let line = desk.error("b.dcm");
        assert!(line.contains(said) && thread_seconds() - start < 1.0, "{said}: {line}");
    }
}

#[test]
fn what_is_wrong_with_a_folder_is_told() {
    let desk = Desk::new(&[]);
    assert!(
        desk.error("")
            .contains("is a directory, not a file; name the mesh or volume file itself, or a folder with slices")
    );
    fs::write(desk.path("DICOMDIR"), LITTLE.header("1.2.840.10008.1.3.10")).unwrap();
    assert!(desk.error("").contains("is a directory"));
    fs::write(desk.path("one"), File::slice(LITTLE, 0, at(0)).bytes()).unwrap();
    for name in ["", "one"] {
        assert!(desk.error(name).contains("at least 2 slices of a series in a folder, found 1"));
    }
    let alone = read("one.dcm", &File::slice(LITTLE, 0, at(0)).bytes()).unwrap_err().to_string();
    assert!(alone.contains("header: expected at least 2 slices"), "{alone}");
    let desk = series(LITTLE, |_, _| {});
    fs::write(desk.path("far"), File::slice(LITTLE, 4, at(4)).bytes()).unwrap();
    let line = desk.error("");
    assert!(line.starts_with("SCAN: folder: expected slices at even distances, none missing, found 4.0 mm between `a` and `far`, others are 2.0 mm apart"), "{line}");
    for (name, position) in [("near", "1e15\\0\\5"), ("next", "1e15\\0\\7")] {
        let mut file = File::slice(LITTLE, 0, at(0));
        file.text(0x0020_000e, b"UI", "7");
        file.text(0x0020_0032, b"DS", position);
        fs::write(desk.path(name), file.bytes()).unwrap();
    }
    assert!(desk.error("near").contains("from the origin"), "{}", desk.error("near"));
}

#[cfg(unix)]
#[test]
fn a_slice_that_is_a_link_out_of_the_folder_is_not_read() {
    let (desk, away) = (series(LITTLE, |_, _| {}), Desk::new(&[("data", File::slice(LITTLE, 3, at(3)).bytes())]));
    fs::create_dir(desk.path("deep")).unwrap();
    fs::rename(desk.path("a"), desk.path("deep/a")).unwrap();
    std::os::unix::fs::symlink("deep/a", desk.path("a")).unwrap();
    assert_eq!(volume(open(&desk.folder())).size[2], 3, "within the folder it is");
    std::os::unix::fs::symlink(away.path("data"), desk.path("d")).unwrap();
    for name in ["", "b.dcm"] {
        let line = desk.error(name);
        assert!(line.contains("folder: the link `d` is not supported; it leads out of the folder"), "{line}");
    }
}

#[test]
fn a_folder_of_too_many_files_is_refused_before_they_are_read() {
    let desk = Desk::new(&[]);
    (0..=10_000).for_each(|index| fs::write(desk.path(&index.to_string()), [0; 129]).unwrap());
    let line = desk.error("");
    assert!(line.contains("folder: a folder of more than 10000 files is not supported"), "{line}");
}

#[test]
fn a_slice_that_is_cut_anywhere_is_told_so() {
    for way in WAYS {
        let desk = series(way, |file, _| file.sequence(0x0008_2112, &[way.element(0x0008_0100, b"SH", b"ab")], false));
        let whole = fs::read(desk.path("b.dcm")).unwrap();
        for length in 0..whole.len() {
            fs::write(desk.path("b.dcm"), &whole[..length]).unwrap();
            let line = desk.error("b.dcm");
            assert!(line.contains("b.dcm") || line.contains("SCAN/"), "{length}: {line}");
        }
    }
    let whole = frames(|_, _| {});
    for length in 0..whole.len() {
        assert!(read("all.dcm", &whole[..length]).is_err(), "{length}");
    }
}

#[test]
fn a_file_with_any_byte_changed_is_read_or_refused_in_one_line() {
    let whole = frames(|_, _| {});
    for at in 128..whole.len() {
        for byte in [0, 1, b'\\', 0x7f, 0xff, whole[at] ^ 1] {
            let mut bent = whole.clone();
            bent[at] = byte;
            if let Err(error) = read("all.dcm", &bent) {
                assert!(error.to_string().lines().count() == 1, "{at}: {error}");
            }
        }
    }
}
