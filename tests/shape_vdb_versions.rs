//! Versions and types of OpenVDB: every one and every packing gives the voxels that were written, and what is wrong is one line.
#![allow(clippy::unwrap_used)] // clippy sees a test only in `#[test]`, not in what it calls

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use glam::Vec3;
use half::f16;
use hypertexture::shape::{Content, Shape, ShapeError, Volume, read};
use proptest::prelude::*;
use std::collections::HashMap;
use std::io::{Read, Write};
use std::time::Instant;

const ZIP: u32 = 1;
const MASK: u32 = 2;
const BLOSC: u32 = 4;

/// How a file is written.
#[derive(Clone, Copy, Debug)]
struct Kind {
    version: u32,
    is_double: bool,
    is_half: bool,
    flags: u32,
    /// The code of the first leaf, where nodes have one.
    code: u8,
}

const PLAIN: Kind = Kind { version: 224, is_double: false, is_half: false, flags: MASK, code: 0 };

/// Where values are outside of everything.
const BACKGROUND: f64 = 2.0;

/// What inactive voxels of the first leaf are, by its code.
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

/// Whether a voxel of a leaf is active, and its value then.
fn is_active(place: usize) -> bool {
    (place / 64 + place / 8 % 8 + place % 8) % 3 != 1
}

fn active(place: usize) -> f64 {
    (place * 37 % 1021) as f64 / 64.0 - 6.0
}

/// The values that the file of [`tree`] has: two leaves and a tile of 8 in a node of 16^3, a tile of 128, one of 4096.
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

/// A file, and where its parts are in it.
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

    /// A value beside the nodes.
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

    /// The values of a node of `code`, with two inactive ones and which of them is the second.
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
            let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
            encoder.write_all(bytes).unwrap();
            encoder.finish().unwrap()
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

/// A grid up to its tree; `map` writes the transform.
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
    let start = Instant::now();
    let line = read("test.vdb", bytes).unwrap_err().to_string();
    assert!(start.elapsed().as_secs_f32() < 1.0, "{line}");
    assert!(line.starts_with("test.vdb: ") && !line.contains('\n') && line.len() < 400, "{line}");
    let foreign = ["Some(", "None", "Err(", "os error", "invalid digit", "failed to fill"];
    assert!(foreign.iter().all(|word| !line.contains(word)), "{line}");
    line
}

/// The volume has the values of [`truth`] in all of the box around its active voxels, one more on each side.
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

#[test]
fn every_version_type_and_packing_gives_the_voxels_in_their_place() {
    for version in 220..=225 {
        let flags: &[u32] = if version < 222 { &[0, ZIP] } else { &[0, ZIP, MASK, MASK | ZIP, BLOSC, BLOSC | MASK] };
        for &flags in flags {
            for (is_double, is_half) in [(false, false), (false, true), (true, false), (true, true)] {
                let kind = Kind { version, is_double, is_half, flags, code: 6 };
                let read = volume(read("test.vdb", &file(kind, "level set").bytes));
                assert_eq!(read.content, Content::LevelSet);
                assert_truth(&read, 6, kind);
            }
        }
    }
}

#[test]
fn every_code_of_a_node_gives_its_inactive_voxels() {
    for code in 0..=6 {
        for is_double in [false, true] {
            let kind = Kind { code, is_double, ..PLAIN };
            let read = volume(read("test.vdb", &file(kind, "fog volume").bytes));
            assert_eq!(read.content, Content::Scalar);
            assert_truth(&read, code, kind);
        }
    }
}

/// What writes a transform, its origin and its distances.
type Map<'a> = (&'a dyn Fn(&mut File), Vec3, Vec3);

#[test]
fn linear_transforms_place_the_voxels() {
    let affine = |rows: [f64; 16]| {
        move |file: &mut File| {
            file.text("map", "AffineMap");
            file.floats("scale", &rows);
        }
    };
    let scale = |name: &'static str, before: &'static [f64], scale: [f64; 3]| {
        move |file: &mut File| {
            file.text("map", name);
            file.floats("", before);
            file.floats("", &scale);
            file.floats("", &[1.0; 12]);
        }
    };
    let maps: [Map; 6] = [
        (&scale("UniformScaleTranslateMap", &[1.0, 2.0, 3.0], [2.0; 3]), Vec3::new(1.0, 2.0, 3.0), Vec3::splat(2.0)),
        (
            &scale("ScaleTranslateMap", &[1.0, 2.0, 3.0], [1.0, 2.0, 4.0]),
            Vec3::new(1.0, 2.0, 3.0),
            Vec3::new(1.0, 2.0, 4.0),
        ),
        (&scale("ScaleMap", &[], [1.0, 2.0, 4.0]), Vec3::ZERO, Vec3::new(1.0, 2.0, 4.0)),
        (&scale("UniformScaleMap", &[], [0.25; 3]), Vec3::ZERO, Vec3::splat(0.25)),
        (
            &|file| {
                file.text("map", "TranslationMap");
                file.floats("", &[5.0, 6.0, 7.0]);
            },
            Vec3::new(5.0, 6.0, 7.0),
            Vec3::ONE,
        ),
        (
            &affine([2.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 7.0, 8.0, 9.0, 1.0]),
            Vec3::new(7.0, 8.0, 9.0),
            Vec3::new(2.0, 3.0, 4.0),
        ),
    ];
    for (map, origin, scale) in maps {
        let mut file = header(224, 1);
        head(&mut file, PLAIN, "fog volume", map);
        tree(&mut file, PLAIN);
        let volume = volume(read("test.vdb", &file.bytes));
        for index in [[0, 0, 0], [9, 0, 0], [0, 17, 0], [3, 4, 129]] {
            let voxel = Vec3::from([4087.0, -1.0, -1.0]) + Vec3::from(index.map(|n| n as f32));
            assert_eq!(volume.position(index), origin + scale * voxel, "{index:?}");
        }
    }
    let refused = |map: &dyn Fn(&mut File)| {
        let mut file = header(224, 1);
        head(&mut file, PLAIN, "fog volume", map);
        tree(&mut file, PLAIN);
        error(&file.bytes)
    };
    let flat = refused(&affine([2.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 7.0, 8.0, 9.0, 1.0]));
    assert!(flat.contains("its axes lie in a plane"), "{flat}");
    let projective = refused(&affine([2.0, 0.0, 0.0, 0.5, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 7.0, 8.0, 9.0, 1.0]));
    assert!(projective.contains("0, 0, 0, 1 in its last column, found [0.5, 0.0, 0.0, 1.0]"), "{projective}");
    let frustum = refused(&|file| file.text("map", "NonlinearFrustumMap"));
    assert!(frustum.contains("the transform `NonlinearFrustumMap` is not supported"), "{frustum}");
    let far = refused(&scale("ScaleTranslateMap", &[1e9, 0.0, 0.0], [1.0; 3]));
    assert!(far.contains("voxels from the origin"), "{far}");
    let nothing = refused(&scale("ScaleMap", &[], [1.0, 0.0, 1.0]));
    assert!(nothing.contains("expected distances between samples"), "{nothing}");
}

/// A file that OpenVDB 10.0.1 wrote.
fn written(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    ZlibDecoder::new(&STANDARD.decode(text).unwrap()[..]).read_to_end(&mut bytes).unwrap();
    bytes
}

#[test]
fn a_ball_that_openvdb_wrote_has_its_distances() {
    let ball = volume(read("ball.vdb", &written(BALL)));
    assert_eq!((ball.size, ball.content), ([13; 3], Content::LevelSet));
    let center = Vec3::new(0.25, -0.5, 1.0);
    assert_eq!(ball.bounds().center(), center);
    let mut near = 0;
    for (index, &value) in ball.values.iter().enumerate() {
        let index = index as u32;
        let distance = ball.position([index % 13, index / 13 % 13, index / 169]).distance(center) - 1.0;
        if value.abs() < 0.5 {
            assert!((value - distance).abs() < 1e-6, "{index}: {value} {distance}");
            near += 1;
        } else {
            assert!(value == 0.5_f32.copysign(distance), "{index}: {value} {distance}");
        }
    }
    assert_eq!(near, 862);
}

#[test]
fn fog_that_openvdb_wrote_behind_a_grid_of_vectors_is_read() {
    let fog = volume(read("fog.vdb", &written(FOG)));
    assert_eq!((fog.size, fog.content), ([10, 11, 6], Content::Scalar));
    assert_eq!(fog.position([0; 3]), Vec3::new(-4.0, -1.0, -3.0) * 0.5);
    for (index, &value) in fog.values.iter().enumerate() {
        let [x, y, z] = [index % 10, index / 10 % 11, index / 110].map(|n| n as f32);
        let (x, y, z) = (x - 4.0, y - 1.0, z - 3.0);
        let is_in = (-3.0..5.0).contains(&x) && (0.0..9.0).contains(&y) && (-2.0..2.0).contains(&z);
        assert_eq!(value, if is_in { x * 0.125 + y * 3.0 + z * 0.5 } else { 0.0 }, "{x} {y} {z}");
    }
}

#[test]
fn the_first_grid_that_fits_is_read_and_the_others_are_named_where_none_does() {
    let grid = |file: &mut File, class: &str| {
        let start = file.bytes.len();
        head(file, PLAIN, class, &scaled);
        tree(file, PLAIN);
        start
    };
    let mut file = header(224, 2);
    grid(&mut file, "staggered");
    grid(&mut file, "fog volume");
    assert_truth(&volume(read("test.vdb", &file.bytes)), 0, PLAIN);

    let mut file = header(224, 2);
    let first = grid(&mut file, "unknown");
    let at = file.at["type"];
    grid(&mut file, "");
    let line = error(&file.bytes);
    assert!(
        line.contains("a file of `a grid` (class `unknown`), `a grid` (class `unknown`) is not supported"),
        "{line}"
    );
    file.bytes[at + 4..at + 20].copy_from_slice(b"Tree_vec3s_5_4_3");
    assert!(error(&file.bytes).contains("`a grid` (`Tree_vec3s_5_4_3`), `a grid` (class"), "{}", error(&file.bytes));
    // Without offsets nothing is behind a grid that cannot be read.
    let at = file.at["has offsets"];
    file.bytes[at] = 0;
    assert!(error(&file.bytes).contains("the offset of the end of a grid"), "{first}");
    // But one that can be read needs none.
    let mut file = self::file(PLAIN, "fog volume");
    let at = file.at["has offsets"];
    file.bytes[at] = 0;
    let at = file.at["start"];
    file.bytes[at..at + 24].fill(0);
    assert_truth(&volume(read("test.vdb", &file.bytes)), 0, PLAIN);
}

/// A fog of single voxels in leaves of their own.
fn voxels(origins: &[[i32; 3]]) -> Vec<u8> {
    let mut file = header(224, 1);
    head(&mut file, PLAIN, "fog volume", &scaled);
    file.number("buffers", 1);
    file.value(PLAIN, "background", 0.0);
    file.number("tiles", 0);
    file.number("children", origins.len() as u32);
    for origin in origins {
        let local = origin.map(|n| n.rem_euclid(4096) as usize);
        let place = |shift: u32, side: usize| local.iter().fold(0, |place, n| place * side + (n >> shift & (side - 1)));
        let (of_32, of_16) = (place(7, 32), place(3, 16));
        file.put("child", &origin.map(|n| (n - n.rem_euclid(4096)).to_le_bytes()).concat());
        file.mask("", 32_768, |place| place == of_32);
        file.mask("", 32_768, |_| false);
        file.bytes.push(0);
        file.mask("", 4096, |place| place == of_16);
        file.mask("", 4096, |_| false);
        file.bytes.push(0);
        file.mask("leaf", 512, |place| place == 0);
    }
    let blocks = file.bytes.len() as u64;
    for _ in origins {
        file.mask("", 512, |place| place == 0);
        file.bytes.push(0);
        file.bytes.extend(1.0_f32.to_le_bytes());
    }
    let offsets = [blocks, file.bytes.len() as u64].map(u64::to_le_bytes);
    let at = file.at["blocks"];
    file.bytes[at..at + 16].copy_from_slice(offsets.as_flattened());
    file.bytes
}

#[test]
fn two_voxels_far_from_each_other_are_refused_with_the_size_of_their_box() {
    let near = volume(read("test.vdb", &voxels(&[[-8, 8, 16], [0, 0, 4088]])));
    assert_eq!(near.size, [11, 11, 4075]);
    assert_eq!(near.values.iter().filter(|value| **value == 1.0).count(), 2);
    assert_eq!(near.sample(Vec3::new(-8.0, 8.0, 16.0) * 0.5), Some(1.0));
    assert_eq!(near.sample(Vec3::new(0.0, 0.0, 4088.0) * 0.5), Some(1.0));
    for (other, size) in
        [([1 << 20, 1 << 20, 1 << 20], "1048579 x 1048579 x 1048579"), ([4096, 4096, 8], "4099 x 4099 x 11")]
    {
        let line = error(&voxels(&[[0; 3], other]));
        assert!(
            line.contains(&format!("{size} voxels in the box around the active ones, the limit is 67108864")),
            "{line}"
        );
    }
    let line = error(&voxels(&[[i32::MIN; 3], [i32::MAX - 4095; 3]]));
    assert!(line.contains("multiples of 4096 up to 2^30"), "{line}");
}

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
    let cases: [(&str, usize, &[u8], &str); 42] = [
        ("magic", 1, b"X", "expected ` BDV`, the mark of OpenVDB"),
        ("version", 0, &[219, 0, 0, 0], "byte 8: version 219 is not supported; versions 220 to 225 are read"),
        ("version", 0, &[226, 0, 0, 0], "version 226"),
        ("metadata of the file", 0, &many, "expected a name of at most 4096 bytes"),
        ("metadata of the file", 0, &[0; 4], "expected a name of at most 4096 bytes"),
        ("creator", 0, &many, "expected a name of at most 4096 bytes, found 2147483647 bytes"),
        ("grids", 0, &[0; 4], "a file of no grids is not supported"),
        ("name", 0, &many, "a name of at most 4096 bytes"),
        ("type", 4, b"Tree_bool_9_9_9_", "`a grid` (`Tree_bool_9_9_9_`)"),
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
        ("background", 0, &nan, "voxels are NaN"),
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
        ("tile value", 0, &nan, "of 23400 voxels are NaN"),
        ("tile activity", 0, &[1], "voxels in the box around the active ones, the limit is"),
        ("values of 32", 0, &[7], "expected a code of a node from 0 to 6, found 7"),
        ("values of 16", 0, &[255], "expected a code of a node from 0 to 6, found 255"),
        ("mask of 16", 511, &[255], "expected"),
        ("mask of a leaf", 0, &[0], "expected the same mask of a leaf as in the tree"),
        ("values", 1, &nan, "1 of 23400 voxels are NaN, infinite or beyond 32-bit floats"),
    ];
    for (name, skip, bytes, said) in cases {
        wrong(&good, name, skip, bytes, said);
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
    assert!(empty.contains("expected a grid with active voxels, found none"), "{empty}");
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
        // What is between is zeros, nearly all.
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

/// A ball of radius 1 around (0.25, -0.5, 1), voxels of 0.25, Blosc and active mask.
const BALL: &str = "eNrtnV1oW8kVx8/Vlb/ysZY3khtso3VWm3Y/Eq8cO1lnK6nF1C+lgpBNTVpMvbIjd73IH8SKooAfLrUIoYg2C92CH0r1sI8X1oZC\
    Hmw5CrSxAyn4Qe/evBqWRDTKZsFInbl3jqLYMdvYSdiu/78wPvdOxldn5p7zn3GYjNt7f9FPgq9E2Uc22omhyPDQiRMnj0eiPdHj\
    3T2dw8eHPhg6fTzaPdTd0xXpOn2qq9NqKIpTlKFILOYS9tzFaHRwJDYRiQ+eHOwe7JJtrqiHfvkTzbKTp2xbK0q9KDWiDMciU1Oy\
    Yip+cXT89w3iKhZNRGPtU9H4QXEzMhqLDg4NTSQHxyJJ+Q2J6HDX6AH1FF0U+S2bWo6OP9Vyo1wuf1u2cXHL4YmxyYvRqanRifEn\
    H++RPYpNTA23v9ceGY6PJqLtiUjsUnSqib/tQjQWuRK9MCh6ekF+6iDXyIoLouKA6rTlm/VVp1+JC4fW6TSElUXeu0XpFuVRQze9\
    Q59Qm+jEMZqkb2lV1NeKGo2aHPupSaslxwFy1FKjgzrOWA99jb0Zi44NDl2JR6dkf0fH46e65bie/+NRq1mlr4mJZDQmenxpPP5U\
    w9/ZPlovcjwyFn0yEPxqG4X99fjoyMTFsY+GI7FoODJpf8vqz57Pun7+bOvfxtIWa8cOWc+TztODcrlSAAAAAAAAAAAA8EPHwBAA\
    AAAAAAAAAAB7AJeyDq1Lbl2wtqe4MCx7HQNDAGF4ccJgGIYyBnYeAQAAAAAAAAAAewcNQwAAAAAAAAAAAOwNsPsIbEXHEEAYdiwM\
    PdOlUkmYUqlcLgtjnV5F09Lef75dR5qmWV91XUakNHpl5xJ2MAEAAAAAAAAAAK8KA0MAAAAAAAAAAACAlwp2L+1RDAwBeIXCUIk3\
    7DoCAAAAAAAAAABeKTi/CAAAAAAAAAAAAC8d7D7am+B0JPBShGG6x7alkn1RLtsXwk7vxA9N/ROpXv1Ppd+P3/5mIEoAAAAAAAAA\
    AAAAAAAAAAAAAACAF8AONykYGDkA9qYwGJJnWGJLbLfje3B+Ev7fKAAAAAAAAAAAAAAAAAAAAAAAAPCC2NnuI5y8A8DeFIZSuVxe\
    Xl6W9v7yzHLlflpe3C9Tj7Ryd1FPqWRZ6pkulUpPnqzpkq3WvpBWs6282n6TkL2DycCbAgAAAAAAAAAAAAAAAAAAAAAAAP7P2XaT\
    goGxAQDCsEkY+FSkLXYHn4HziwAAAAAAAAAAAAAAAAAAAAAAAIAfANttMsDpSABAGLYIQ7lcts5Buq9suWJL08r2SFuyDU33PP1c\
    XdeebdVWJO1lbEmq/s1yx6o61iasLLKurbcYygysh6TNh9dCi55syB2et+z/8BHqgCh1YBQfIKUOlNLL383yjKZpwlgDIIz11PKM\
    bY842OkjTlNcyyLr3KLuT6L8p64t05ZfdC/m2xZTZmqxLeM2yXRnXqOu/N18Ez2sd1+bW5275s6bc7lcbs68S6s5yq2KV/pWW+ZD\
    etiUSR3O5DKHU+7DuaQ/mTtsZpLmYzOZoZz/MT3251ykXSK9n5zH6IHrWu4LaqEvcnNJ8l71UnLV33L1aoufb22Pegd6wx7xp9fT\
    arZ6egfCwqPwgPAofCgsPQr7fAs+Xzhs+hLehM88RAte8i5Ij3oHpEcDrTdvJW7dbA3f9PYV+7w3zVt9hXih7xYlinGKFxOWR85+\
    0qVHPq+fHpHf6+ujyyuXqW+h+Ghl5VGRb22PiuvFtex8dq2YnU3PZovr82kjPb8uPFrLr0mP5kc8Bc/I/Frak9xIetJ5o7BBGwVD\
    eFRclx6tz/pvJG/4Z+f9G6k7qQ1/+kaqo78jdcNI3uk3+u8knxqjkY0G43OjYcOTMm7fu22kCnc+v3fv8zt8+5Hw6I2QRs2vB9+l\
    I8FAA3UHA9RAmovqHKIi+Dp9Hchms4FQKJhdWlrKButJ7yRHg+xve2BJE19CXUQnSaun69mQbCNaPVda2EeT8VFl9tFlH1elxxlh\
    ZZF1MiXuHspbqSHTRKaGaaatdBGZZdXxvfy7a74Rq+2cz2Ol0OpCISjr+X7HqcwX7ipHpUI5VZ380O96CIsSixSLFosY1Wj88E5n\
    QFzLIuvkB3wtY6nFTrZMm8orlW8i2TiBOKFa6B+iGWfMm6T/lLRfigfYuSFyxE4DlR4iNzjeOf7FA0QzDvAnD7BDeb2oolZFswhl\
    Dk8OV/EA0YzjkR/QLIMvuJ80B52xAm0fvRsMttqxdTjwpniniud9RSzhLOn0VtWrcqvXJOtkPMi44ViR97Tb3wz6SdWHnRf2vKqT\
    gSkDL9U6awWqtNWBLIOYA3hzu83zQfVcsdvDBPWyGqYtVml/ZS7guaEyV9gUquaGFZEFshTU3HBTlEKLmhNY+1naWa5zptdr5h5f\
    vfp4HxUaVSTzBMH6ryT+beoUj6ynxt9Q68ODVhKoDOC450hPkz5CzkbqEtH/Z0pxOpwm57/I+Xdyuqyp6QTpn5LzETlXZU2naPsZ\
    6f8k/SRNKq/tLqhJhCcLngtY3xOFy5cL3vjKSlx2QeUSzyg8Yag54ekuWGnIU5HKPM61ShdE/okucEJWd0Hk6wlyfkq63YVarVO0\
    rXRBeW13Qc06PLvw5METQrLj9u2Ojf579/plF1Q28xTEM4yaRGQXDIO7YAmBUgHOfc72SheEAogusCRUd0Eoxqa3INpWuqC8vi66\
    4BGK8VUwEAxVpqRQHYkpi2rJFaghV7CG6o6L+ft90jtIq6MjS9m36RD5qeY96WkLzdBnoZCa1M7Q0aVAmrS/kDvbSPQO1Viz3oek\
    nybtOh3NBv8tfal5n+ivpNWS/jc1wI0Ocp5RurTLYzhX6InK5+XUoepk5syJ8k1d3mybW8ylcmYudZcyq+6cKRLCbKZvWt3X8nOL\
    q+65RZEvbZQx20Qwh81enyfR6jUTrYdoYCHsFa29VuuwL+zzLIgiQrOXBsxeETdr6aInm5zdSCdn88Z6YV68K2Mj3UwPaudH1jzZ\
    wrwnK6KgaKyni+IVibE/FwwFQsEGMaChwH6qaybaL8f+Out0aNf/M2C7tTFrHgs230td3PUPBPLl2AK52Wozyi5Lq9mmPLP89MK5\
    pG1dG5fUXP0H6UAHCx0LHwuhUhglbax0rHxKCIN04OFBFjUWOV5NW/pHMyxuZy21+zHpTTQn4oHXCLYXrFWsXaxlSiSUOrFYsXgp\
    LbO8YF1inWLZkhImvGB9OmsJlu2FXE+ohYbtBcsNyw/LkcpzJTCsN6w/So4sL1haWGp41SxVSHjBEnPW0hzbCxG/vFo5J7zwi9Wq\
    Rv6sDObJrKUngVpyOEhrpnovfSAWwm8QdVNjkOraQwEvXV8KKOE4S7W/pTo3/SjYLFcuB1z0sR37u/65cruFLy9YeW0gY54Xs7zw\
    lQvjZ7WrXthw7vwX/NPVlA==";

/// Doubles in a box, Blosc without a mask, behind a grid of vectors.
const FOG: &str = "eNrtnN9PHFUUx88M2+U3u7W/gNUuBe0PW+guLIVpbZYaE2MibROrabTpsixDu+3CEpYSGhOdhD42qW998EESffChiT74aOwk/gM8\
    khgTTNq0MVgb02iiFTz33tkfwA5sS1Ep3w+Zc2fPnLk/zjl7uW1OaHr9jfeImeWrihRaqCtkdHWbXa1xwwy1Rtr7I63dg4nB1o7B\
    zo640RkeDHcbwlAXxnyN+1mcGTXN2LiZ6MjEOmORWIcwGHd69LSp9nun9fBVzlctX4PJlBnr709PxIbiE1vES9xHssbpWgxRttwy\
    Oexq6c9aJtJDI6NmJpNMD3tZlxkbTQ5fEK/1p9KZxNas2YCZil81B2KpdHxAjBLLaoRih9N5jo+cti77+pA5FOu/OmZmRM/J4bEj\
    kQq+mTpRKc1ykxlPT5gpntKV4bFFhtnOhUeG40NmfqbSsT4W7w4nB9OjQ+8k4imzNz6i7B9G17edXdYuckM2U1b5DAAAAAAAAAAA\
    AAAAAAAAAAAAAICNh/eMV93o2h4PfxQqErrtfHddIwqSRgvgv+XiaRkjxAPxAIjHRokHissA2MSHS79WcLi0+YYvoROHy2P0dJv1\
    LrW3bOjX81Ss0cVP9743W+YtA1PPN/Wq9FsExl+4tjk14WK6Bkd3N2pZ1l9016eLx38sfcgsfSgKyQfM4Uxy7Koo6pZ16APpK/0p\
    M1+IvuAUngdnVPvtT6r1OIsWNdmJVDyTyddfi2r4wfSFpvF06sqQuXKlerYbkaArV6r/zfMWA89z+0wr1U8WCd9RGZOwx+LWcj6L\
    mDTz9Vjz0XWq4utL+oaS9BlPPqB5iF3brfy6Son7RP22XDBXLHFv0vK+XlziXhA510L32eiTtdRTvPW7tMsL4JeeMzxSrcKWawEA\
    AAAAAAAAALDeWHABAAAAAAAAAAAA1hPvaY+6UUXu4oOHhE6UVlSjaFRyT9WQwB1wB9xRojvAc46F/7gGKxwspqngYGHJhCGhEweL\
    g1TaXlmu9pL/lXmp2C6U/L5Li6pNAAAAAAAAAADg3wV/xQEAAAAAAAAAAADrDao3UZ8Hd8AdqN4ET4SG/7oGKx0sNnv1ZpkLJb/v\
    0uZQVZwWUg0AAAAAAAAAAAAAAAAAAAAAAADY2KB6E/V5cAfc8eyrN/G3GQHYvAeL57V60y4RN8fYJbalgAJqAAAAAAAAAAAAAAAA\
    AAAAAAAAYOOD6k3U58EdcMczdwf+NiMAm/hg8bxWb5aViJtjykps14pbVam3XCsIjJ9v+BI6EZi6vC9+Vss9ldN8alhkfaWz7PFT\
    kK8aY4qaQlTjJ59OwZpPyOen6oA95Whq6/qowe6goM2mXbPUFyLuktuBXJcfGr/T3A3d+JM0Pxkv0HaWu6mJ5Su0l+VBOsQyRGGW\
    HRRh+Yjus3xMOstttIMnErToNeM3utNHxjyV8cgWHeNx2Ly5YJzbdJvHiWan/jZb/cBWPfxTqj9dWu81Wu7Pa+Tmz4JJRdl9N/RL\
    UZt6LLoUZc9YdFZZ1RdYHaEutnImvOQZz3/Rs1JxS1qvXiQ59BKS44ZIjs91MSE/NRYmxksqMWoD9tfZxKjhWNnEqSH0hswMr59U\
    l4lcl2ljhuxJ3dhClRzsnVTPcg81s9xH+1m2UhvLMLWzjFAny2maZumlKpa7qEHmwnEeaYbHK6dq+flNNczugmFuU3TSmfn7bPGE\
    fzzc7fv71HmRFnkxuSQvBpbGPh3tou5JGft7y5/xYhY9W2vJuXeqSF5MuebFRUfzQcBKO0GvDlghMnheYRX1JppamiH81E4U5EjA\
    Pq30fTSb1fdWfafVybuFc2qsH+XSNep+SLM+OiH+Aeslj06R7bSzmjSdwk20p0Jq9tI+pTlErUoTprDSRCiiNHM0ozQabZEadmJv\
    5D5NX5ZanbzKbgftknY+0o6H75B9VmrLqFxp+aW6eW1rxYRUc/KqTjl/1eucwkrDWZydSnt2Kp0VcoFOzA9kF8h7mI+/crlEXRip\
    /FXzkX6+wBv2KruVvdqv7VtFsvaWa9YafDWyptHyiSmfi3JYR+lclU5HOZhblY7Dp3S+ee2ymOt59XJLdmFd1CVfPy8XFex+pMkl\
    Xcx/VaUZLzxv9qBg0Wv9leyNF8nu+KrZfSpgJdYtu53Ff8HXWRK/NtkBFVTjo7fYGY28wTVTC8v9dIBlGx1m2S63wk65Fdp0h2Ul\
    1cpNr5e3xvsjZFQR9240UMAv85Y32DneGqvFPKTVLD1kqxrys1UjvciyhV5meYBeZXmYQnKUDjnKkUXzbHHmGc0Hyk8ng1GO1C8F\
    Zms9/HhvFknPm67p2cZXTB49NUqK3PyYkuILZIt9lf3OTTYnL+WTLUbd/MNvqHQ0FrSksEgqiwZpIQ4OjsWDgvX9A/yll2E=";
