//! DICOM.

use super::{folder, noted_volume};
use flate2::Compression;
use flate2::write::DeflateEncoder;
use glam::Vec3;
use hypertexture_shape::{Opened, Volume};
use std::io::Write;

const COLUMNS: u16 = 4;
const ROWS: u16 = 3;
const PLAIN: &str = "1.2.840.10008.1.2.1";
const DEFLATED: &str = "1.2.840.10008.1.2.1.99";

/// An element of a type with a short length.
fn element(tag: u32, kind: &[u8; 2], value: &[u8]) -> Vec<u8> {
    let mut value = value.to_vec();
    value.resize(value.len().next_multiple_of(2), if kind == b"UI" { 0 } else { b' ' });
    let [group, number] = [(tag >> 16) as u16, tag as u16].map(u16::to_le_bytes);
    let length = match kind {
        b"OB" | b"OW" => [&[0; 2][..], &(value.len() as u32).to_le_bytes()].concat(),
        _ => (value.len() as u16).to_le_bytes().to_vec(),
    };
    [&group[..], &number, kind, &length, &value].concat()
}

/// A file of frames of 4 x 3 pixels, each of the value of its number and a first pixel of 500 more; `place` has further elements.
fn file(syntax: &str, place: &[(u32, &[u8; 2], String)], frames: std::ops::Range<u16>) -> Vec<u8> {
    let of_header = element(0x0002_0010, b"UI", syntax.as_bytes());
    let header = [element(0x0002_0000, b"UL", &(of_header.len() as u32).to_le_bytes()), of_header].concat();
    let short = |tag, number: u16| element(tag, b"US", &number.to_le_bytes());
    let mut all = vec![
        (0x0020_000e, element(0x0020_000e, b"UI", b"1.2.3.4")),
        (0x0028_0002, short(0x0028_0002, 1)),
        (0x0028_0004, element(0x0028_0004, b"CS", b"MONOCHROME2")),
        (0x0028_0010, short(0x0028_0010, ROWS)),
        (0x0028_0011, short(0x0028_0011, COLUMNS)),
        (0x0028_0100, short(0x0028_0100, 16)),
        (0x0028_0101, short(0x0028_0101, 16)),
        (0x0028_0102, short(0x0028_0102, 15)),
        (0x0028_0103, short(0x0028_0103, 0)),
    ];
    all.extend(place.iter().map(|(tag, kind, text)| (*tag, element(*tag, kind, text.as_bytes()))));
    let pixels = frames.flat_map(|frame| (0..ROWS * COLUMNS).map(move |at| frame + if at == 0 { 500 } else { 0 }));
    let pixels: Vec<u8> = pixels.flat_map(u16::to_le_bytes).collect();
    all.push((0x7fe0_0010, element(0x7fe0_0010, b"OW", &pixels)));
    all.sort_by_key(|(tag, _)| *tag);
    let body: Vec<u8> = all.into_iter().flat_map(|(_, bytes)| bytes).collect();
    let body = if syntax == DEFLATED {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(&body).unwrap();
        encoder.finish().unwrap()
    } else {
        body
    };
    [&[0; 128][..], b"DICM", &header, &body].concat()
}

/// Slice `number` of a series at a height, mm.
fn slice(syntax: &str, number: u16, height: f64) -> Vec<u8> {
    let place = [
        (0x0020_0032, b"DS", format!("0\\0\\{height}")),
        (0x0020_0037, b"DS", "1\\0\\0\\0\\1\\0".into()),
        (0x0028_0030, b"DS", "0.5\\0.75".into()),
    ];
    file(syntax, &place, number..number + 1)
}

/// The slices at these heights, in a folder of the desk.
fn read(syntax: &str, inside: &str, heights: &[f64]) -> Result<(Volume, String), String> {
    let files: Vec<(String, Vec<u8>)> = (heights.iter().enumerate())
        .map(|(number, height)| (format!("{inside}I{number:03}.dcm"), slice(syntax, number as u16, *height)))
        .collect();
    let desk = folder(&files.iter().map(|(name, bytes)| (name.as_str(), &bytes[..])).collect::<Vec<_>>());
    let opened = Opened::of(desk.path().to_str().unwrap());
    opened.map(noted_volume).map_err(|error| error.to_string())
}

/// Values of the last pixels of the slices, which are those of their numbers, from below on.
fn numbers(volume: &Volume) -> Vec<f32> {
    let pixels = usize::from(ROWS * COLUMNS);
    let slices: Vec<&[f32]> = volume.values.chunks(pixels).collect();
    let value = |slice: &&[f32]| {
        // The place of the first pixel depends on the axes: it is the largest one.
        let mut values = slice.to_vec();
        values.sort_by(f32::total_cmp);
        assert!((values[pixels - 1] - values[0] - 500.0).abs() < 1e-3 && values[0] == values[pixels - 2], "{values:?}");
        values[0]
    };
    slices.iter().map(value).collect()
}

#[test]
fn deflated_files_are_inflated() {
    let heights = [0.0, 2.0, 4.0];
    let (plain, _) = read(PLAIN, "", &heights).unwrap();
    let (found, notes) = read(DEFLATED, "", &heights).unwrap();
    assert_eq!((found.values, found.steps, notes.as_str()), (plain.values, plain.steps, ""));
    let mut torn = slice(DEFLATED, 0, 0.0);
    torn.truncate(torn.len() - 20);
    let desk = folder(&[("a.dcm", &torn), ("b.dcm", &slice(DEFLATED, 1, 2.0))]);
    let error = Opened::of(desk.path().to_str().unwrap()).unwrap_err().to_string();
    assert!(error.contains("a.dcm: byte ") && error.contains("compressed data damaged"), "{error}");
}

#[test]
fn slices_in_a_nested_folder_are_found() {
    let (found, notes) = read(PLAIN, "patient/study 1/", &[0.0, 2.0]).unwrap();
    assert_eq!(
        (numbers(&found), notes.as_str()),
        (vec![0.0, 1.0], "its slices are in the folder `patient/study 1` in it")
    );
    let two = folder(&[
        ("a/1.dcm", &slice(PLAIN, 0, 0.0)),
        ("b/1.dcm", &String::from_utf8_lossy(&slice(PLAIN, 0, 0.0)).replace("1.2.3.4", "1.2.3.5").into_bytes()),
    ]);
    assert!(Opened::of(two.path().to_str().unwrap()).is_err());
    let empty = folder(&[("a/b/notes.txt", b"no slices here")]);
    let error = Opened::of(empty.path().to_str().unwrap()).unwrap_err().to_string();
    assert!(error.contains("is a directory, not a file"), "{error}");
    // Slices behind the last folder that is looked into would be lost.
    (0..1000).for_each(|number| std::fs::create_dir(empty.path().join(number.to_string())).unwrap());
    let error = Opened::of(empty.path().to_str().unwrap()).unwrap_err().to_string();
    assert!(error.contains("a folder of more than 1000 folders is not supported; put the slices"), "{error}");
}

#[test]
fn slices_at_different_distances_are_interpolated() {
    // 2 mm apart, then 3, then 2: the values are linear in the number, so at 2 mm each they are known.
    let heights = [0.0, 2.0, 4.0, 7.0, 10.0, 12.0, 14.0];
    let (found, notes) = read(PLAIN, "", &heights).unwrap();
    assert_eq!(notes, "its slices are 2.0 to 3.0 mm apart: it is interpolated at even distances of 2.0 mm");
    let at = |height: f64| {
        let below = heights.windows(2).position(|pair| height <= pair[1]).unwrap();
        below as f64 + (height - heights[below]) / (heights[below + 1] - heights[below])
    };
    let found_numbers = numbers(&found);
    assert_eq!(found_numbers.len(), 8);
    for (index, number) in found_numbers.iter().enumerate() {
        assert!((f64::from(*number) - at(2.0 * index as f64)).abs() < 1e-4, "{found_numbers:?}");
    }
    assert_eq!(found.spacing(), Vec3::new(0.75, 0.5, 2.0));
    // One that is missing among many is no different distance.
    let missing: Vec<f64> = (0..12).filter(|index| *index != 5).map(|index| 2.0 * f64::from(index)).collect();
    assert!(read(PLAIN, "", &missing).unwrap_err().contains("none missing"));
}

#[test]
fn frames_without_places_lie_one_above_the_other() {
    let count = (0x0028_0008, b"IS", "3".to_string());
    for (more, step, note) in [
        (
            vec![(0x0018_0088, b"DS", "2.5".into())],
            2.5,
            "its 3 frames have no places of their own: they are put 2.5 mm apart, as SpacingBetweenSlices says",
        ),
        (vec![(0x0018_0050, b"DS", "4".into())], 4.0, "they are put 4 mm apart, as SliceThickness says"),
        (vec![(0x3004_000c, b"DS", "0\\3\\6".into())], 3.0, "they lie as GridFrameOffsetVector says"),
        (vec![], 1.0, "they are put 1 mm apart, as nothing says"),
    ] {
        let mut place: Vec<(u32, &[u8; 2], String)> = vec![count.clone(), (0x0028_0030, b"DS", "0.5\\0.75".into())];
        place.extend(more);
        let desk = folder(&[("a.dcm", &file(PLAIN, &place, 0..3))]);
        let (found, notes) = noted_volume(Opened::of(desk.path().join("a.dcm").to_str().unwrap()).unwrap());
        assert_eq!((found.spacing(), numbers(&found)), (Vec3::new(0.75, 0.5, step), vec![0.0, 1.0, 2.0]), "{note}");
        assert!(notes.contains(note), "{notes}");
    }
    let desk = folder(&[("a.dcm", &file(PLAIN, &[count], 0..3))]);
    let (_, notes) = noted_volume(Opened::of(desk.path().join("a.dcm").to_str().unwrap()).unwrap());
    assert!(notes.ends_with("; its pixels are taken to be 1 mm wide"), "{notes}");
}
