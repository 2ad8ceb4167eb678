//! All versions, types and compressions of OpenVDB give the written voxels; errors are one line.

mod reads;
mod wrong;

use crate::packed::{thread_seconds, zlib};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;
use glam::Vec3;
use half::f16;
use hypertexture_shape::{Content, Shape, ShapeError, Volume, read, read_noted};
use proptest::prelude::*;
use std::collections::HashMap;
use std::io::Read;

const ZIP: u32 = 1;
const MASK: u32 = 2;
const BLOSC: u32 = 4;

/// Encoding of a file.
#[derive(Clone, Copy, Debug)]
struct Kind {
    version: u32,
    is_double: bool,
    is_half: bool,
    flags: u32,
    /// Node code of the first leaf, in versions with codes.
    code: u8,
}

const PLAIN: Kind = Kind { version: 224, is_double: false, is_half: false, flags: MASK, code: 0 };

/// Background.
const BACKGROUND: f64 = 2.0;

/// Values of inactive voxels of the first leaf, by its code.
fn inactive(code: u8, place: usize) -> f64 {
    let choice = |pair: [f64; 2]| pair[place % 2];
    match code {
        0 => BACKGROUND,
        1 => -BACKGROUND,
        2 => 5.0,
        3 => choice([-BACKGROUND, BACKGROUND]),
        4 => choice([5.0, BACKGROUND]),
        5 => choice([5.0, 7.0]),
        _ => place as f64 / 8.0,
    }
}

/// Value of a voxel of a leaf, if it is active.
fn is_active(place: usize) -> bool {
    (place / 64 + place / 8 % 8 + place % 8) % 3 != 1
}

fn active(place: usize) -> f64 {
    (place * 37 % 1021) as f64 / 64.0 - 6.0
}

/// Values of the file of [`tree`]: two leaves and a tile of 8 in a node of 16^3, a tile of 128, one of 4096.
fn truth(code: u8, [x, y, z]: [i32; 3]) -> f64 {
    let place = ((x - 4088) * 64 + y * 8 + z.rem_euclid(8)) as usize;
    match (x, y, z) {
        (_, i32::MIN..0, _) | (_, _, i32::MIN..0) => BACKGROUND,
        (4096.., ..) => -3.0,
        (_, _, 128..) => 1.5,
        (4088.., 8..16, 0..8) => -0.5,
        (4088.., 0..8, 0..8) if is_active(place) => active(place),
        (4088.., 0..8, 0..8) => inactive(code, place),
        (4088.., 0..8, 120..) if is_active(place) => active(place),
        _ => BACKGROUND,
    }
}

/// File, and the offsets of its parts.
#[derive(Clone, Default)]
struct File {
    bytes: Vec<u8>,
    at: HashMap<&'static str, usize>,
}

impl File {
    fn mark(&mut self, name: &'static str) {
        self.at.insert(name, self.bytes.len());
    }

    fn put(&mut self, name: &'static str, bytes: &[u8]) {
        self.mark(name);
        self.bytes.extend(bytes);
    }

    fn number(&mut self, name: &'static str, number: u32) {
        self.put(name, &number.to_le_bytes());
    }

    fn text(&mut self, name: &'static str, text: &str) {
        self.number(name, text.len() as u32);
        self.bytes.extend(text.bytes());
    }

    fn floats(&mut self, name: &'static str, floats: &[f64]) {
        self.mark(name);
        self.bytes.extend(floats.iter().flat_map(|x| x.to_le_bytes()));
    }

    fn entry(&mut self, key: &'static str, kind: &str, value: &[u8]) {
        self.text(key, key);
        self.text("", kind);
        self.number("", value.len() as u32);
        self.bytes.extend(value);
    }

    /// Value outside of a node.
    fn value(&mut self, kind: Kind, name: &'static str, value: f64) {
        match kind.is_double {
            true => self.put(name, &value.to_le_bytes()),
            false => self.put(name, &(value as f32).to_le_bytes()),
        }
    }

    fn mask(&mut self, name: &'static str, places: usize, is_on: impl Fn(usize) -> bool) {
        self.mark(name);
        self.bytes
            .extend((0..places / 8).map(|byte| (0..8).map(|bit| u8::from(is_on(8 * byte + bit)) << bit).sum::<u8>()));
    }

    /// Values of a node of `code`, with two inactive values and the mask of the second.
    fn values(
        &mut self,
        kind: Kind,
        name: &'static str,
        code: u8,
        values: &[f64],
        is_on: impl Fn(usize) -> bool,
        unlike: ([f64; 2], &dyn Fn(usize) -> bool),
    ) {
        let mut stored = values.to_vec();
        self.mark(name);
        if kind.version >= 222 {
            let code = if kind.flags & MASK == 0 { 6 } else { code };
            self.bytes.push(code);
            let ([first, second], is_second) = unlike;
            if matches!(code, 2 | 4 | 5) {
                self.value(kind, "", first);
            }
            if code == 5 {
                self.value(kind, "", second);
            }
            if matches!(code, 3..=5) {
                self.mask("", values.len(), is_second);
            }
            if code != 6 {
                stored = (0..values.len()).filter(|place| is_on(*place)).map(|place| values[place]).collect();
            }
        }
        if kind.is_half && stored.is_empty() {
            return;
        }
        let one = |value: &f64| match (kind.is_half, kind.is_double) {
            (true, _) => f16::from_f64(*value).to_le_bytes().to_vec(),
            (_, true) => value.to_le_bytes().to_vec(),
            _ => (*value as f32).to_le_bytes().to_vec(),
        };
        let bytes: Vec<u8> = stored.iter().flat_map(one).collect();
        self.packed(kind.flags, &bytes);
    }

    fn packed(&mut self, flags: u32, bytes: &[u8]) {
        let size = bytes.len();
        let packed = if flags & BLOSC != 0 {
            let numbers = [size as u32, size as u32, size as u32 + 16].map(u32::to_le_bytes);
            [&[2, 1, 0x33, 4], numbers.as_flattened(), bytes].concat() // a copy
        } else if flags & ZIP != 0 {
            zlib(bytes)
        } else {
            self.bytes.extend(bytes);
            return;
        };
        let is_smaller = flags & BLOSC != 0 || packed.len() < size;
        let length = if is_smaller { packed.len() as i64 } else { -(size as i64) };
        self.put("length", &length.to_le_bytes());
        self.bytes.extend(if is_smaller { &packed } else { bytes });
    }
}

fn header(version: u32, grids: u32) -> File {
    let mut file = File::default();
    file.put("magic", b" BDV\0\0\0\0");
    file.number("version", version);
    file.put("library", &[0; 8]);
    file.put("has offsets", &[1]);
    if version < 222 {
        file.put("is zip", &[0]);
    }
    file.put("identifier", &[b'x'; 36]);
    file.number("metadata of the file", 1);
    file.entry("creator", "string", b"a test");
    file.number("grids", grids);
    file
}

/// Grid up to its tree; `map` writes the transform.
fn head(file: &mut File, kind: Kind, class: &str, map: &dyn Fn(&mut File)) {
    file.text("name", "a grid\u{1e}2");
    let of_values = if kind.is_double { "double" } else { "float" };
    file.text("type", &format!("Tree_{of_values}_5_4_3{}", if kind.is_half { "_HalfFloat" } else { "" }));
    file.text("parent", "");
    file.put("start", &[0; 8]);
    file.put("blocks", &[0; 8]);
    file.put("end", &[0; 8]);
    if kind.version >= 222 {
        file.number("flags", kind.flags);
    }
    file.number("metadata", 4);
    file.entry("class", "string", class.as_bytes());
    file.entry("is_saved_as_half_float", "bool", &[u8::from(kind.is_half)]);
    file.entry("file_bbox_max", "vec3i", &[7; 12]);
    file.entry("anything", "a type of tomorrow", &[9; 300]);
    map(file);
}

fn scaled(file: &mut File) {
    file.text("map", "UniformScaleMap");
    file.floats("scale", &[0.5; 3]);
    file.floats("", &[0.0; 12]);
}

/// The tree of [`truth`].
fn tree(file: &mut File, kind: Kind) {
    let on = |list: &'static [usize]| move |place: usize| list.contains(&place);
    file.number("buffers", 1);
    file.value(kind, "background", BACKGROUND);
    file.number("tiles", 1);
    file.number("children", 1);
    file.put("tile", &[4096, 0, 0].map(i32::to_le_bytes).concat());
    file.value(kind, "tile value", -3.0);
    file.put("tile activity", &[0]);
    file.put("child", &[0; 12]);
    // Of 32^3: the child that is last along x, and a tile of 128 behind it along z.
    let [child, tile] = [31 * 1024, 31 * 1024 + 1];
    file.mask("mask of 32", 32_768, move |place| place == child);
    file.mask("active of 32", 32_768, |_| false);
    let values = |tile: usize, value: f64, places: usize| {
        let value = move |place| if place == tile { value } else { BACKGROUND };
        (0..places)
            .filter(|place| kind.version >= 222 || *place != child || places < 32_768)
            .map(value)
            .collect::<Vec<_>>()
    };
    file.values(
        kind,
        "values of 32",
        4,
        &values(tile, 1.5, 32_768),
        |_| false,
        ([1.5, 0.0], &move |place| place != tile),
    );
    // Of 16^3: leaves that are first and last along z, and an active tile of 8 beside the first along y.
    let leaves: &[usize] = &[15 * 256, 15 * 256 + 15];
    file.mask("mask of 16", 4096, on(&[15 * 256, 15 * 256 + 15]));
    file.mask("active of 16", 4096, on(&[15 * 256 + 16]));
    let mut tiles = values(15 * 256 + 16, -0.5, 4096);
    if kind.version < 222 {
        tiles = (0..4096).filter(|place| !leaves.contains(place)).map(|place| tiles[place]).collect();
    }
    file.values(kind, "values of 16", 0, &tiles, on(&[15 * 256 + 16]), ([0.0; 2], &|_| false));
    file.mask("leaf", 512, is_active);
    file.mask("", 512, is_active);
    let blocks = file.bytes.len() as u64;
    for (leaf, code) in [("values", kind.code), ("last values", 0)] {
        file.mask("mask of a leaf", 512, is_active);
        if kind.version < 222 {
            file.put("origin", &[4088, 0, if leaf == "values" { 0 } else { 120 }].map(i32::to_le_bytes).concat());
            file.bytes.push(2); // buffers, the second one being left over
        }
        let voxel = |place: usize| if is_active(place) { active(place) } else { inactive(code, place) };
        let voxels: Vec<f64> = (0..512).map(voxel).collect();
        let unlike = match code {
            3 => [-BACKGROUND, BACKGROUND],
            _ => [5.0, 7.0],
        };
        file.values(kind, leaf, code, &voxels, is_active, (unlike, &|place| place % 2 == 1));
        if kind.version < 222 {
            let bytes = 512
                * if kind.is_half {
                    2
                } else if kind.is_double {
                    8
                } else {
                    4
                };
            file.packed(kind.flags & ZIP, &vec![77; bytes]);
        }
    }
    let end = file.bytes.len() as u64;
    for (name, offset) in [("blocks", blocks), ("end", end)] {
        let at = file.at[name];
        file.bytes[at..at + 8].copy_from_slice(&offset.to_le_bytes());
    }
}

fn file(kind: Kind, class: &str) -> File {
    let mut file = header(kind.version, 1);
    if kind.version < 222 {
        let at = file.at["is zip"];
        file.bytes[at] = u8::from(kind.flags & ZIP != 0);
    }
    head(&mut file, kind, class, &scaled);
    tree(&mut file, kind);
    file
}

fn volume(shape: Result<Shape, ShapeError>) -> Volume {
    match shape {
        Ok(Shape::Volume(volume)) => volume,
        other => panic!("{other:?}"),
    }
}

fn error(bytes: &[u8]) -> String {
    let start = thread_seconds();
    let line = read("test.vdb", bytes).unwrap_err().to_string();
    assert!(thread_seconds() - start < 1.0, "{line}");
    assert!(line.starts_with("test.vdb: ") && !line.contains('\n') && line.len() < 400, "{line}");
    let foreign = ["Some(", "None", "Err(", "os error", "invalid digit", "failed to fill"];
    assert!(foreign.iter().all(|word| !line.contains(word)), "{line}");
    line
}

/// Checks the volume against [`truth`] in the box around its active voxels with a margin of one.
fn assert_truth(volume: &Volume, code: u8, kind: Kind) {
    assert_eq!(volume.size, [10, 18, 130], "{kind:?}");
    let first = [4087, -1, -1];
    assert_eq!(volume.position([0; 3]), Vec3::from(first.map(|n| n as f32 * 0.5)));
    assert_eq!(volume.position([9, 17, 129]), Vec3::new(4096.0, 16.0, 128.0) * 0.5);
    for (index, value) in volume.values.iter().enumerate() {
        let [x, y, z] = [index % 10, index / 10 % 18, index / 180];
        let at = [first[0] + x as i32, first[1] + y as i32, first[2] + z as i32];
        assert_eq!(f64::from(*value), truth(code, at), "{kind:?} {at:?}");
    }
}
