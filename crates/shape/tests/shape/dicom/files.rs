//! Builder of DICOM files.

use glam::DVec3;
use hypertexture_shape::{Shape, ShapeError, Volume, open};
use std::collections::BTreeMap;
use std::fs;
use tempfile::TempDir;

/// Encoding of elements.
#[derive(Clone, Copy, PartialEq)]
pub struct Way {
    pub uid: &'static str,
    pub is_implicit: bool,
    pub is_big: bool,
}

pub const LITTLE: Way = Way { uid: "1.2.840.10008.1.2.1", is_implicit: false, is_big: false };
pub const WAYS: [Way; 3] = [
    LITTLE,
    Way { uid: "1.2.840.10008.1.2", is_implicit: true, is_big: false },
    Way { uid: "1.2.840.10008.1.2.2", is_implicit: false, is_big: true },
];

/// Length of an element that ends with a delimiter.
pub const OPEN: u32 = u32::MAX;
pub const ITEM: u32 = 0xfffe_e000;
pub const PIXELS: u32 = 0x7fe0_0010;

impl Way {
    pub fn number<const N: usize>(self, mut little: [u8; N]) -> Vec<u8> {
        if self.is_big {
            little.reverse();
        }
        little.to_vec()
    }

    /// Tag, type and length, not necessarily valid.
    pub fn head(self, tag: u32, kind: &[u8; 2], length: u32) -> Vec<u8> {
        let tags = [self.number(((tag >> 16) as u16).to_le_bytes()), self.number((tag as u16).to_le_bytes())].concat();
        let is_bare = self.is_implicit || tag >> 16 == 0xfffe;
        let is_long = matches!(kind, b"OB" | b"OW" | b"SQ" | b"UN" | b"OF");
        match (is_bare, is_long) {
            (true, _) => [tags, self.number(length.to_le_bytes())].concat(),
            (_, true) => [&tags[..], kind, &[0; 2], &self.number(length.to_le_bytes())].concat(),
            _ => [&tags[..], kind, &self.number((length as u16).to_le_bytes())].concat(),
        }
    }

    pub fn element(self, tag: u32, kind: &[u8; 2], value: &[u8]) -> Vec<u8> {
        let mut value = value.to_vec();
        if value.len() % 2 == 1 {
            value.push(if matches!(kind, b"OB" | b"UI") { 0 } else { b' ' });
        }
        [self.head(tag, kind, value.len() as u32), value].concat()
    }

    /// Sequence of items, with lengths or delimiters.
    pub fn sequence(self, tag: u32, items: &[Vec<u8>], has_lengths: bool) -> Vec<u8> {
        let end = |tag| if has_lengths { Vec::new() } else { self.head(tag, b"  ", 0) };
        let length = |bytes: &[u8]| if has_lengths { bytes.len() as u32 } else { OPEN };
        let item = |item: &Vec<u8>| [self.head(ITEM, b"  ", length(item)), item.clone(), end(0xfffe_e00d)].concat();
        let items = items.iter().flat_map(item).collect::<Vec<u8>>();
        [self.head(tag, b"SQ", length(&items)), items, end(0xfffe_e0dd)].concat()
    }

    pub fn header(self, class: &str) -> Vec<u8> {
        let rest = [
            LITTLE.element(0x0002_0001, b"OB", &[0, 1]),
            LITTLE.element(0x0002_0002, b"UI", class.as_bytes()),
            LITTLE.element(0x0002_0010, b"UI", self.uid.as_bytes()),
            LITTLE.element(0x0002_0012, b"UI", b"1.2.3"),
        ]
        .concat();
        let length = LITTLE.element(0x0002_0000, b"UL", &(rest.len() as u32).to_le_bytes());
        [&[0; 128][..], b"DICM", &length, &rest].concat()
    }
}

/// Bits allocated, bits stored, high bit, and sign.
pub type Bits = (u16, u16, u16, bool);

/// Elements of a file.
#[derive(Clone)]
pub struct File {
    pub way: Way,
    pub elements: BTreeMap<u32, Vec<u8>>,
}

pub const CT: &str = "1.2.840.10008.5.1.4.1.1.2";
pub const SIZE: [usize; 2] = [4, 3];
pub const SPACING: [f64; 2] = [0.5, 0.75]; // of rows and of columns
pub const AXIAL: [f64; 6] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

pub fn decimals(numbers: &[f64]) -> String {
    numbers.iter().map(|number| format!("{number:.9}")).collect::<Vec<_>>().join("\\")
}

/// Stored pixels of slice `z`, x fastest.
pub fn stored(z: usize) -> Vec<i64> {
    (0..12).map(|index| (index + 12 * z as i64) * 3 - 20).collect()
}

impl File {
    /// Slice `z` of a series of 4 x 3 signed 16-bit pixels.
    pub fn slice(way: Way, z: usize, position: DVec3) -> File {
        let mut file = File { way, elements: BTreeMap::new() };
        file.text(0x0008_0060, b"CS", "CT");
        file.text(0x0010_0010, b"PN", "a^b");
        file.text(0x0020_000e, b"UI", "1.2.3.4");
        file.text(0x0020_0032, b"DS", &decimals(&position.to_array()));
        file.text(0x0020_0037, b"DS", &decimals(&AXIAL));
        file.short(0x0028_0002, 1);
        file.text(0x0028_0004, b"CS", "MONOCHROME2");
        file.short(0x0028_0010, SIZE[1] as u16);
        file.short(0x0028_0011, SIZE[0] as u16);
        file.text(0x0028_0030, b"DS", &decimals(&SPACING));
        file.text(0x0028_1052, b"DS", "-1024");
        file.text(0x0028_1053, b"DS", "0.5");
        file.pixels((16, 16, 15, true), &stored(z));
        file
    }

    pub fn set(&mut self, tag: u32, kind: &[u8; 2], value: &[u8]) {
        self.elements.insert(tag, self.way.element(tag, kind, value));
    }

    pub fn text(&mut self, tag: u32, kind: &[u8; 2], text: &str) {
        self.set(tag, kind, text.as_bytes());
    }

    pub fn short(&mut self, tag: u32, number: u16) {
        self.set(tag, b"US", &self.way.number(number.to_le_bytes()));
    }

    pub fn sequence(&mut self, tag: u32, items: &[Vec<u8>], has_lengths: bool) {
        self.elements.insert(tag, self.way.sequence(tag, items, has_lengths));
    }

    /// Pixels of a type; unused bits are 1.
    pub fn pixels(&mut self, (allocated, count, high, is_signed): Bits, values: &[i64]) {
        for (tag, number) in [(0x0028_0100, allocated), (0x0028_0101, count), (0x0028_0102, high)] {
            self.short(tag, number);
        }
        self.short(0x0028_0103, u16::from(is_signed));
        let low = high + 1 - count;
        let mask = ((1_u64 << count) - 1) << low;
        let bytes = values.iter().flat_map(|value| {
            let pixel = (((*value as u64) << low) & mask | !mask) as u32;
            match allocated {
                8 => vec![pixel as u8],
                16 => self.way.number((pixel as u16).to_le_bytes()),
                _ => self.way.number(pixel.to_le_bytes()),
            }
        });
        let bytes: Vec<u8> = bytes.collect();
        self.set(PIXELS, if allocated == 16 { b"OW" } else { b"OB" }, &bytes);
    }

    pub fn bytes(&self) -> Vec<u8> {
        let elements = self.elements.values().flatten().copied();
        self.way.header(CT).into_iter().chain(elements).collect()
    }
}

/// Stacked slices, 2 mm apart.
pub fn at(z: usize) -> DVec3 {
    DVec3::new(10.0, -20.0, 5.0 + 2.0 * z as f64)
}

/// A folder of files.
pub struct Desk(TempDir);

impl Desk {
    pub fn new(files: &[(&str, Vec<u8>)]) -> Desk {
        let desk = Desk(tempfile::tempdir().unwrap());
        files.iter().for_each(|(name, bytes)| fs::write(desk.path(name), bytes).unwrap());
        desk
    }

    pub fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }

    pub fn folder(&self) -> String {
        self.path("").trim_end_matches('/').to_owned()
    }

    pub fn error(&self, name: &str) -> String {
        let path = if name.is_empty() { self.folder() } else { self.path(name) };
        let error = open(&path).map(|_| "a shape").unwrap_err().to_string();
        let line = error.replace(&self.folder(), "SCAN");
        assert!(line.lines().count() == 1 && line.len() < 400 && line.starts_with("SCAN"), "{line}");
        for word in ["Some(", "None", "Err(", "os error", "invalid", "panicked", "ParseFloat"] {
            assert!(!line.contains(word), "{word}: {line}");
        }
        line
    }
}

pub fn volume(shape: Result<Shape, ShapeError>) -> Volume {
    match shape.unwrap() {
        Shape::Volume(volume) => volume,
        _ => panic!("no volume"),
    }
}

/// Three slices whose file names run backwards.
pub fn series(way: Way, edit: impl Fn(&mut File, usize)) -> Desk {
    let file = |z: usize| {
        let mut file = File::slice(way, z, at(z));
        edit(&mut file, z);
        file.bytes()
    };
    Desk::new(&[("c", file(0)), ("b.dcm", file(1)), ("a", file(2))])
}

/// World values of [`series`]; the first two axes are reversed.
pub fn expected(worth: impl Fn(i64, usize) -> f64) -> Vec<f32> {
    let mut values = Vec::new();
    for z in 0..3 {
        let slice = stored(z);
        for y in (0..SIZE[1]).rev() {
            values.extend((0..SIZE[0]).rev().map(|x| worth(slice[y * SIZE[0] + x], z) as f32));
        }
    }
    values
}

/// Multi-frame file: positions and values in per-frame groups, the rest in shared ones.
pub fn frames(edit: impl Fn(&mut File, &mut Vec<Vec<u8>>)) -> Vec<u8> {
    let way = LITTLE;
    let group = |tag, elements: Vec<Vec<u8>>| way.sequence(tag, &[elements.concat()], tag % 2 == 0);
    let text = |tag, text: &str| way.element(tag, b"DS", text.as_bytes());
    let mut file = File::slice(way, 0, DVec3::ZERO);
    file.elements.retain(|tag, _| !matches!(tag, 0x0020_0032 | 0x0020_0037 | 0x0028_0030 | 0x0028_1052 | 0x0028_1053));
    let order = [2, 0, 1]; // they need not be in order
    let mut items: Vec<Vec<u8>> = order
        .iter()
        .map(|z| {
            [
                group(0x0020_9111, vec![text(0x0020_9056, "1")]), // another group
                group(0x0020_9113, vec![text(0x0020_0032, &decimals(&at(*z).to_array()))]),
                group(0x0028_9145, vec![text(0x0028_1052, ["0", "1", "2"][*z]), text(0x0028_1053, "2")]),
            ]
            .concat()
        })
        .collect();
    let shared = [
        group(0x0020_9116, vec![text(0x0020_0037, &decimals(&AXIAL))]),
        group(0x0028_9110, vec![text(0x0018_0050, "2"), text(0x0028_0030, &decimals(&SPACING))]),
    ];
    file.text(0x0028_0008, b"IS", "3");
    file.pixels((16, 16, 15, true), &order.iter().flat_map(|z| stored(*z)).collect::<Vec<_>>());
    file.sequence(0x5200_9229, &[shared.concat()], false);
    edit(&mut file, &mut items);
    file.sequence(0x5200_9230, &items, true);
    file.bytes()
}
