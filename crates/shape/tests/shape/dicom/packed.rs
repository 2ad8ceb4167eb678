//! Compressed pixels: run lengths and JPEG, encoded here after NEMA PS3.5 and ITU-T T.81.

use super::files::{CT, Desk, File, ITEM, LITTLE, OPEN, PIXELS, Way, at, expected, frames, series, stored, volume};
use hypertexture_shape::{Opened, open, read};
use std::fs;

const RLE: &str = "1.2.840.10008.1.2.5";
const LOSSLESS: [&str; 2] = ["1.2.840.10008.1.2.4.57", "1.2.840.10008.1.2.4.70"];
const BASELINE: &str = "1.2.840.10008.1.2.4.50";

/// Encapsulated pixel data: an offset table, maybe empty, and fragments.
fn fragments(table: &[u32], fragments: &[Vec<u8>]) -> Vec<u8> {
    let item = |bytes: &[u8]| [LITTLE.head(ITEM, b"  ", bytes.len() as u32), bytes.to_vec()].concat();
    let table = table.iter().flat_map(|start| start.to_le_bytes()).collect::<Vec<u8>>();
    let end = LITTLE.head(0xfffe_e0dd, b"  ", 0);
    let items = fragments.iter().flat_map(|bytes| item(bytes)).collect::<Vec<u8>>();
    [LITTLE.head(PIXELS, b"OB", OPEN), item(&table), items, end].concat()
}

/// File in another transfer syntax with these pixels.
fn packed(file: &File, uid: &'static str, pixels: Vec<u8>) -> Vec<u8> {
    let mut file = file.clone();
    file.elements.insert(PIXELS, pixels);
    let elements = file.bytes().split_off(LITTLE.header(CT).len());
    [Way { uid, ..LITTLE }.header(CT), elements].concat()
}

fn even(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.resize(bytes.len().next_multiple_of(2), 0);
    bytes
}

/// Run lengths: one segment per byte of a pixel, the highest first.
fn rle(pixels: &[Vec<u8>]) -> Vec<u8> {
    let width = pixels[0].len();
    let (mut header, mut planes) = (vec![width as u32], Vec::new());
    for byte in (0..width).rev() {
        header.push(64 + planes.len() as u32);
        let plane: Vec<u8> = pixels.iter().map(|pixel| pixel[byte]).collect();
        let mut segment = vec![128]; // stands for nothing
        let mut rest = &plane[..];
        while let Some(first) = rest.first() {
            let run = rest.iter().take_while(|byte| *byte == first).count().min(128);
            if run > 1 {
                segment.extend([(257 - run) as u8, *first]);
            } else {
                segment.extend([0, *first]);
            }
            rest = &rest[run..];
        }
        planes.extend(even(segment));
    }
    header.resize(16, 0);
    [header.iter().flat_map(|number| number.to_le_bytes()).collect(), planes].concat()
}

/// Bits, the highest first, with a zero byte after each 0xff.
#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    rest: (u32, u32),
}

impl Bits {
    fn put(&mut self, count: u32, bits: u32) {
        for bit in (0..count).rev() {
            self.rest = (self.rest.0 << 1 | bits >> bit & 1, self.rest.1 + 1);
            if self.rest.1 == 8 {
                self.bytes.push(self.rest.0 as u8);
                if self.rest.0 == 0xff {
                    self.bytes.push(0);
                }
                self.rest = (0, 0);
            }
        }
    }

    fn end(mut self) -> Vec<u8> {
        while self.rest.1 > 0 {
            self.put(1, 1);
        }
        self.bytes
    }
}

/// JPEG segment with its length.
fn segment(marker: u8, content: &[u8]) -> Vec<u8> {
    [&[0xff, marker][..], &(content.len() as u16 + 2).to_be_bytes(), content].concat()
}

/// Category of a difference, and its additional bits.
fn category(difference: i32) -> (u32, u32) {
    let count = 32 - difference.unsigned_abs().leading_zeros();
    let bits = if difference < 0 { difference - 1 } else { difference };
    (count, bits as u32 & ((1 << count) - 1))
}

/// Lossless JPEG: each category of differences from 0 to 16 has a code of 5 bits.
fn lossless(pixels: &[i32], columns: usize, precision: u8, predictor: u8, extra: &[Vec<u8>], shift: u8) -> Vec<u8> {
    let rows = pixels.len() / columns;
    let mut bits = Bits::default();
    for (index, pixel) in pixels.iter().enumerate() {
        let (x, y) = (index % columns, index / columns);
        let at = |back: usize| pixels[index - back];
        let predicted = match (x, y) {
            (0, 0) => 1 << (precision - 1),
            (_, 0) => at(1),
            (0, _) => at(columns),
            _ => {
                let (left, above, corner) = (at(1), at(columns), at(columns + 1));
                match predictor {
                    1 => left,
                    2 => above,
                    3 => corner,
                    4 => left + above - corner,
                    5 => left + ((above - corner) >> 1),
                    6 => above + ((left - corner) >> 1),
                    _ => (left + above) / 2,
                }
            }
        };
        let difference = i32::from((pixel - predicted) as i16); // modulo 2^16
        if difference == -32768 {
            bits.put(5, 16);
        } else {
            let (count, own) = category(difference);
            bits.put(5, count);
            bits.put(count, own);
        }
    }
    let sides = [(rows as u16).to_be_bytes(), (columns as u16).to_be_bytes()].concat();
    let frame = [&[precision][..], &sides, &[1, 1, 0x11, 0]].concat();
    let table = [&[0, 0, 0, 0, 0, 17][..], &[0; 11], &(0..17).collect::<Vec<u8>>()].concat();
    let scan = segment(0xda, &[1, 1, 0, predictor, 0, shift]);
    let parts = [vec![0xff, 0xd8], segment(0xc3, &frame), segment(0xc4, &table), extra.concat(), scan, bits.end()];
    even([parts.concat(), vec![0xff, 0xd9]].concat())
}

/// Baseline JPEG of constant blocks of 8 x 8: 8 times the value above 128, without rounding.
fn baseline(blocks: &[u8], columns: usize) -> Vec<u8> {
    let mut bits = Bits::default();
    let mut before = 0;
    for block in blocks {
        let level = 8 * (i32::from(*block) - 128);
        let (count, own) = category(level - before);
        bits.put(4, count);
        bits.put(count, own);
        bits.put(1, 0); // the end of the block
        before = level;
    }
    let sides = [((blocks.len() / columns * 8) as u16).to_be_bytes(), (columns as u16 * 8).to_be_bytes()].concat();
    let frame = [&[8][..], &sides, &[1, 1, 0x11, 0]].concat();
    let constant = [&[0, 0, 0, 0, 12][..], &[0; 12], &(0..12).collect::<Vec<u8>>()].concat();
    let others = [&[0x10, 1][..], &[0; 15], &[0]].concat();
    let tables = [segment(0xdb, &[&[0][..], &[1; 64]].concat()), segment(0xc0, &frame), segment(0xc4, &constant)];
    let rest = [segment(0xc4, &others), segment(0xda, &[1, 1, 0, 0, 63, 0]), bits.end()];
    even([vec![0xff, 0xd8], tables.concat(), rest.concat(), vec![0xff, 0xd9]].concat())
}

/// Signed 16-bit pixels as stored.
fn raw(z: usize) -> Vec<i32> {
    stored(z).iter().map(|value| i32::from(*value as i16 as u16)).collect()
}

fn worth(value: i64, _: usize) -> f64 {
    0.5 * value as f64 - 1024.0
}

#[test]
fn runs_of_bytes_are_pixels_of_every_width() {
    for bits in [(8, 8, 7, false), (16, 16, 15, true), (16, 12, 11, false), (32, 32, 31, true)] {
        let width = bits.0 as usize / 8;
        let value = |index: usize| (index as i64 / 5) * 29 % 200; // with runs
        let desk = Desk::new(&[]);
        for z in 0..3 {
            let mut file = File::slice(LITTLE, z, at(z));
            let all: Vec<i64> = (0..12).map(|index| value(12 * z + index)).collect();
            file.pixels(bits, &all);
            let pixels: Vec<Vec<u8>> = all.iter().map(|value| value.to_le_bytes()[..width].to_vec()).collect();
            let bytes = packed(&file, RLE, fragments(&[], &[rle(&pixels)]));
            fs::write(desk.path(["c", "b.dcm", "a"][z]), bytes).unwrap();
        }
        let order = expected(|old, _| ((old + 20) / 3) as f64);
        let values: Vec<f32> = order.iter().map(|index| worth(value(*index as usize), 0) as f32).collect();
        assert_eq!(volume(open(&desk.folder())).values, values, "{bits:?}");
    }
}

#[test]
fn lossless_jpeg_gives_the_values_that_were_packed() {
    for uid in LOSSLESS {
        for predictor in 1..=7 {
            let desk = series(LITTLE, |_, _| {});
            for z in 0..3 {
                let frame = lossless(&raw(z), 4, 16, predictor, &[], 0);
                // A frame may be in several fragments.
                let (start, end) = frame.split_at(20 + 2 * z);
                let pixels = fragments(&[], &[start.to_vec(), end.to_vec()]);
                let bytes = packed(&File::slice(LITTLE, z, at(z)), uid, pixels);
                fs::write(desk.path(["c", "b.dcm", "a"][z]), bytes).unwrap();
            }
            assert_eq!(volume(open(&desk.folder())).values, expected(worth), "{uid}, {predictor}");
        }
    }
}

#[test]
fn baseline_jpeg_is_read_and_said_to_change_values() {
    let desk = Desk::new(&[]);
    for z in 0..2 {
        let mut file = File::slice(LITTLE, z, at(z));
        file.short(0x0028_0010, 8);
        file.short(0x0028_0011, 16);
        file.pixels((8, 8, 7, false), &[0; 128]);
        let pixels = fragments(&[0], &[baseline(&[10 + z as u8, 200], 2)]);
        fs::write(desk.path(&z.to_string()), packed(&file, BASELINE, pixels)).unwrap();
    }
    let opened = Opened::of(&desk.folder()).unwrap();
    assert_eq!(opened.notes, ["its pixels are packed by a JPEG that changes values"]);
    let found = volume(Ok(opened.shape));
    assert_eq!(found.size, [16, 8, 2]);
    for (index, value) in found.values.iter().enumerate() {
        let stored = if index % 16 < 8 { 200 } else { 10 + index as i64 / 128 }; // x runs against the patient's
        assert_eq!(*value, worth(stored, 0) as f32, "{index}");
    }
}

#[test]
fn frames_are_told_apart_by_the_table_or_have_a_fragment_each() {
    let frame = |z: usize| lossless(&raw(z), 4, 16, 1, &[], 0);
    let order = [2, 0, 1];
    let plain = |table: &[u32], parts: &[Vec<u8>]| {
        let bytes = frames(|file, _| drop(file.elements.insert(PIXELS, fragments(table, parts))));
        let elements = bytes[LITTLE.header(CT).len()..].to_vec();
        [Way { uid: LOSSLESS[1], ..LITTLE }.header(CT), elements].concat()
    };
    let whole: Vec<Vec<u8>> = order.iter().map(|z| frame(*z)).collect();
    let halves: Vec<Vec<u8>> = whole.iter().flat_map(|frame| [frame[..30].to_vec(), frame[30..].to_vec()]).collect();
    let starts = |heads: u32| {
        let length = |index: usize| whole[index].len() as u32 + heads * 8;
        [0, length(0), length(0) + length(1)]
    };
    let truth = expected(|value, z| 2.0 * value as f64 + z as f64);
    for (table, parts) in [(vec![], &whole), (starts(1).to_vec(), &whole), (starts(2).to_vec(), &halves)] {
        assert_eq!(volume(read("all.dcm", &plain(&table, parts))).values, truth);
    }
    for (table, parts, said) in [
        (vec![], &halves, "compressed data damaged"),
        (vec![0, 4], &whole, "a table of frames with 4 bytes for each, found 8 bytes for 3 frames"),
        (vec![], &vec![whole[0].clone(); 4], "one fragment of packed pixels for each frame, or a table of frames"),
        (vec![], &whole[..2].to_vec(), "compressed data damaged"),
    ] {
        let line = read("all.dcm", &plain(&table, parts)).unwrap_err().to_string();
        assert!(line.contains(said) && line.lines().count() == 1, "{said}: {line}");
    }
}

#[test]
fn what_is_wrong_with_packed_pixels_is_told_in_one_line() {
    let pixels: Vec<Vec<u8>> = raw(1).iter().map(|value| value.to_le_bytes()[..2].to_vec()).collect();
    let good = lossless(&raw(1), 4, 16, 1, &[], 0);
    let mut short = rle(&pixels);
    short.truncate(70);
    let mut three = rle(&pixels);
    three[0] = 3;
    let one = |bytes: Vec<u8>| fragments(&[], &[bytes]);
    let restarts = lossless(&raw(1), 4, 16, 1, &[segment(0xdd, &[0, 4])], 0);
    let cases: Vec<(&'static str, Vec<u8>, &str)> = vec![
        (RLE, one(short), "its runs end too early"),
        (RLE, one(three), "3 segments of RLE for pixels of 2 bytes"),
        (RLE, one(vec![]), "no header of RLE"),
        (RLE, one([&rle(&pixels)[..64], &[129, 7, 129, 7]].concat()), "its runs are too long"),
        (LOSSLESS[1], one(lossless(&raw(1), 6, 16, 1, &[], 0)), "it holds 6 x 2 of L16 for 4 x 3 grey values"),
        (LOSSLESS[1], one(restarts), "JPEG with restarts in lossless data is not supported"),
        (LOSSLESS[1], one(lossless(&raw(1), 4, 16, 1, &[], 1)), "a point transform of lossless data"),
        (LOSSLESS[1], one(good[..good.len() / 2].to_vec()), "compressed data damaged"),
        (LOSSLESS[1], one(b"no JPEG at all".to_vec()), "compressed data damaged"),
        (LOSSLESS[1], LITTLE.element(PIXELS, b"OB", &good), "in fragments, without a length of all, found"),
        (LOSSLESS[1], LITTLE.head(PIXELS, b"OB", OPEN), "the file holds at most 0 once decompressed"),
        (LOSSLESS[1], [LITTLE.head(PIXELS, b"OB", OPEN), LITTLE.head(0x0028_0010, b"US", 0)].concat(), "packed pixels"),
    ];
    for (uid, pixels, said) in cases {
        let desk = series(LITTLE, |_, _| {});
        fs::write(desk.path("b.dcm"), packed(&File::slice(LITTLE, 1, at(1)), uid, pixels)).unwrap();
        let line = desk.error("b.dcm");
        assert!(line.contains(said), "{said}: {line}");
    }
}

#[test]
fn small_files_of_large_declared_size_are_refused_early() {
    for (uid, frame) in [(RLE, rle(&[vec![0, 0]])), (LOSSLESS[1], lossless(&raw(1), 4, 16, 1, &[], 0))] {
        let desk = Desk::new(&[]);
        for z in 0..2 {
            let mut file = File::slice(LITTLE, z, at(z));
            file.short(0x0028_0010, 30_000);
            file.short(0x0028_0011, 30_000);
            let bytes = packed(&file, uid, fragments(&[], std::slice::from_ref(&frame)));
            fs::write(desk.path(&z.to_string()), bytes).unwrap();
        }
        let line = desk.error("");
        assert!(line.contains("declares 1800000000 bytes of data (pixels), the file holds at most"), "{line}");
    }
}

#[test]
fn damaged_packed_pixels_are_read_or_refused_in_one_line() {
    let pixels: Vec<Vec<u8>> = raw(0).iter().map(|value| value.to_le_bytes()[..2].to_vec()).collect();
    let frames_of = |uid: &'static str, frame: Vec<u8>| {
        let bytes = frames(|file, _| {
            file.elements.insert(PIXELS, fragments(&[], &vec![frame.clone(); 3]));
        });
        [Way { uid, ..LITTLE }.header(CT), bytes[LITTLE.header(CT).len()..].to_vec()].concat()
    };
    for whole in [frames_of(RLE, rle(&pixels)), frames_of(LOSSLESS[1], lossless(&raw(0), 4, 16, 1, &[], 0))] {
        let from = whole.windows(4).position(|part| part == [0xe0, 0x7f, 0x10, 0x00]).unwrap();
        for at in from..whole.len() {
            for byte in [0, 1, 0x7f, 0xff, whole[at] ^ 1, whole[at] ^ 0x80] {
                let mut bent = whole.clone();
                bent[at] = byte;
                if let Err(error) = read("all.dcm", &bent) {
                    assert!(error.to_string().lines().count() == 1, "{at}: {error}");
                }
            }
        }
    }
}
