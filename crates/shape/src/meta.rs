//! MetaImage: volumes as .mhd with a file of data beside it, or both in one .mha.
//!
//! Role: lines `Key = value` into a [`Raster`]. Invariant: a key that changes what the values mean or where they are is
//! understood or refused. Positions are LPS, whatever `AnatomicalOrientation` says: so ITK reads and writes them, and all that
//! is built on it. A header without directions says nothing of the kind, as NRRD without a space. Source: Insight Software Consortium, "ITK/MetaIO/Documentation", itk.org/Wiki/ITK/MetaIO.

use super::error::{Location, ShapeError, quoted};
use super::files::Files;
use super::placement::{self, Placement};
use super::raster::{Data, Packing, Raster, Skip};
use super::source::Source;
use super::space::{Space, or_usual, three_axes};
use super::{Content, SampleType, Shape};
use glam::{DMat3, DVec3};
use std::collections::HashMap;
use std::ops::RangeInclusive;

/// The key behind which the data is: the last one.
const DATA: &str = "ElementDataFile";
/// The key of the sides that the axes come from, for people.
const ORIENTATION: &str = "AnatomicalOrientation";
/// Dimensions that an image may have.
const DIMENSIONS: RangeInclusive<usize> = 3..=10;
/// What the key `Comment` says where values are signed distances.
pub(super) const SIGNED_DISTANCE: &str = "hypertexture signed distance";

/// Names of the types of values.
const TYPES: [(&str, SampleType); 12] = [
    ("MET_CHAR", SampleType::I8),
    ("MET_UCHAR", SampleType::U8),
    ("MET_SHORT", SampleType::I16),
    ("MET_USHORT", SampleType::U16),
    ("MET_INT", SampleType::I32),
    ("MET_UINT", SampleType::U32),
    ("MET_LONG", SampleType::I32),
    ("MET_ULONG", SampleType::U32),
    ("MET_LONG_LONG", SampleType::I64),
    ("MET_ULONG_LONG", SampleType::U64),
    ("MET_FLOAT", SampleType::F32),
    ("MET_DOUBLE", SampleType::F64),
];

/// Whether the file begins with a key that these files begin with.
pub(super) fn recognizes(start: &[u8], _len: u64) -> bool {
    let line = start.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let key = line.split(|byte| *byte == b'=').next().unwrap_or_default().trim_ascii();
    line.contains(&b'=') && (key == b"ObjectType" || key == b"NDims")
}

/// Reads a volume: raw or compressed, behind the header or in files beside it; integers of 8 to 64 bits, float or double,
/// both byte orders, converted to f32 (integers above 2^24 and doubles are rounded).
pub(super) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    let keys = Keys::read(source)?;
    let raster = keys.raster(source)?;
    let is_here = matches!(keys.value(DATA), Some("LOCAL" | "Local" | "local"));
    let before = match keys.value("HeaderSize").map(str::parse::<i64>) {
        None | Some(Ok(0)) => Skip::Bytes(0),
        Some(Ok(-1)) if raster.packing == Packing::None => Skip::ToData,
        Some(Ok(-1)) => return Err(keys.unsupported(source, "HeaderSize", "of compressed data, say how many bytes")),
        // From the start of the file on, whichever it is.
        Some(Ok(bytes @ 1..)) if !is_here => Skip::Bytes(bytes as u64),
        Some(Ok(bytes)) if bytes as u64 >= source.offset && bytes > 0 => Skip::Bytes(bytes as u64 - source.offset),
        Some(_) => return Err(keys.wrong(source, "HeaderSize", "a number of bytes before the data, or -1")),
    };
    let name = keys.value(DATA).unwrap_or_default();
    let files = if is_here { None } else { Some(Files::read(name, raster.placement.size, source)?) };
    raster.read(source, &Data { files, before, ..Data::HERE })
}

/// The lines of a header.
struct Keys(HashMap<String, (u64, String)>);

impl Keys {
    fn read(source: &mut Source) -> Result<Keys, ShapeError> {
        let (mut keys, mut line) = (HashMap::new(), Vec::new());
        loop {
            if !source.next_line(&mut line)? {
                let end = Location::Line(source.line);
                return Err(source.malformed_at(end, "`ElementDataFile = ...`", "the end of the file".into()));
            }
            let text = String::from_utf8_lossy(&line);
            if text.trim().is_empty() {
                continue;
            }
            let Some((key, value)) = text.split_once('=') else {
                return Err(source.malformed("`Key = value`", &line));
            };
            let key = key.trim().to_string();
            let is_last = key == DATA;
            if keys.insert(key, (source.line, value.trim().to_string())).is_some() {
                return Err(source.malformed("each key once", &line));
            }
            if is_last {
                return Ok(Keys(keys));
            }
        }
    }

    fn value(&self, key: &str) -> Option<&str> {
        self.0.get(key).map(|(_, value)| value.as_str())
    }

    /// The first of several names of a key that there is.
    fn named<'a>(&self, names: &[&'a str]) -> &'a str {
        names.iter().find(|name| self.value(name).is_some()).or(names.first()).copied().unwrap_or_default()
    }

    fn place(&self, key: &str) -> Location {
        self.0.get(key).map_or(Location::Header, |(line, _)| Location::Line(*line))
    }

    fn wrong(&self, source: &Source, key: &'static str, expected: &'static str) -> ShapeError {
        let found = match self.value(key) {
            Some(value) => format!("{key} {}", quoted(value.as_bytes())),
            None => format!("no {key}"),
        };
        source.malformed_at(self.place(key), expected, found)
    }

    fn unsupported(&self, source: &Source, key: &'static str, remedy: &'static str) -> ShapeError {
        let found = quoted(self.value(key).unwrap_or_default().as_bytes());
        ShapeError::Unsupported { file: source.file.clone(), place: self.place(key), what: key, found, remedy }
    }

    /// The numbers of a key, if it is there: so many, and none infinite.
    fn numbers(&self, source: &Source, key: &'static str, count: usize) -> Result<Option<Vec<f64>>, ShapeError> {
        let Some(text) = self.value(key) else { return Ok(None) };
        let number = |word: &str| word.parse().ok().filter(|number: &f64| !number.is_infinite());
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
        let numbers = numbers.filter(|numbers| numbers.len() == count);
        let expected = match count {
            3 => "3 finite numbers",
            9 => "9 finite numbers",
            _ => "as many finite numbers as `NDims` asks for",
        };
        numbers.map(Some).ok_or_else(|| self.wrong(source, key, expected))
    }

    /// The same of the axes of the volume, none of them NaN.
    fn three(
        &self,
        source: &Source,
        key: &'static str,
        (dimensions, axes): (usize, [usize; 3]),
    ) -> Result<Option<DVec3>, ShapeError> {
        let numbers = self.numbers(source, key, dimensions)?.map(|numbers| DVec3::from(axes.map(|axis| numbers[axis])));
        match numbers {
            Some(numbers) if numbers.is_nan() => Err(self.wrong(source, key, "finite numbers")),
            numbers => Ok(numbers),
        }
    }

    /// Whether a key says yes.
    fn says(&self, source: &Source, key: &'static str) -> Result<bool, ShapeError> {
        match self.value(key).map(str::to_ascii_lowercase).as_deref() {
            None | Some("false" | "f" | "0") => Ok(false),
            Some("true" | "t" | "1") => Ok(true),
            Some(_) => Err(self.wrong(source, key, "`True` or `False`")),
        }
    }

    fn raster(&self, source: &Source) -> Result<Raster, ShapeError> {
        if self.value("ObjectType").is_some_and(|kind| kind != "Image") {
            return Err(self.unsupported(source, "ObjectType", "only images are volumes"));
        }
        if self.value("ElementNumberOfChannels").is_some_and(|count| count != "1") {
            return Err(self.unsupported(source, "ElementNumberOfChannels", "extract one of them"));
        }
        if self.value("BinaryData").is_some() && !self.says(source, "BinaryData")? {
            return Err(self.unsupported(source, "BinaryData", "save it as binary data"));
        }
        let name =
            self.value("ElementType").ok_or_else(|| self.wrong(source, "ElementType", "`ElementType = MET_...`"))?;
        let kind = TYPES.iter().find(|(known, _)| *known == name).map(|(_, kind)| *kind);
        let remedy = "convert it to an integer type, float or double";
        let kind = kind.ok_or_else(|| self.unsupported(source, "ElementType", remedy))?;
        let order = self.named(&["BinaryDataByteOrderMSB", "ElementByteOrderMSB"]);
        let big_endian = self.says(source, order)?;
        let packing = if self.says(source, "CompressedData")? { Packing::Zlib } else { Packing::None };
        let (size, dimensions, axes) = self.size(source)?;
        // Where samples have a size and no distance, they touch.
        let spacing = self.named(&["ElementSpacing", "ElementSize"]);
        let lengths = self.numbers(source, spacing, dimensions)?.unwrap_or(vec![1.0; dimensions]);
        let lengths = or_usual(source, spacing, axes.map(|axis| lengths[axis]), f64::NAN, 1.0);
        if !placement::are_lengths(lengths.abs()) {
            return Err(self.wrong(source, spacing, placement::STEPS));
        }
        if lengths.min_element() < 0.0 {
            source.note(format!("{spacing} is below 0: these axes run backwards, as ITK reads it"));
        }
        let place = self.named(&["Offset", "Position", "Origin"]);
        let origin = self.three(source, place, (dimensions, axes))?.unwrap_or_default();
        let turn = self.named(&["TransformMatrix", "Rotation", "Orientation"]);
        // The direction of the first axis, then those of the others.
        let matrix = self.numbers(source, turn, dimensions * dimensions)?;
        let part = |matrix: &Vec<f64>, axis: usize| DVec3::from(axes.map(|row| matrix[axis * dimensions + row]));
        let columns =
            |matrix: Vec<f64>| DMat3::from_cols(part(&matrix, axes[0]), part(&matrix, axes[1]), part(&matrix, axes[2]));
        let steps = matrix.map_or(DMat3::IDENTITY, columns) * DMat3::from_diagonal(lengths);
        if !placement::are_lengths(super::axes::lengths(&steps)) {
            return Err(self.wrong(source, turn, placement::STEPS));
        }
        let content = match self.value("Comment") {
            Some(SIGNED_DISTANCE) => Content::SignedDistance,
            _ => Content::Scalar,
        };
        self.compare_orientation(source, &steps);
        let is_told = [turn, ORIENTATION].iter().any(|key| self.value(key).is_some());
        let space = if is_told { Space::LPS } else { Space::RAS };
        let placement = Placement::new(space, size, (origin, steps), content);
        Ok(Raster { kind, big_endian, packing, scale: None, placement })
    }

    /// Says so where `AnatomicalOrientation` is neither the sides that the axes come from nor those that they point to.
    fn compare_orientation(&self, source: &Source, steps: &DMat3) {
        let Some(said) = self.value(ORIENTATION) else { return };
        let sides = |steps: &DMat3| Space::LPS.letters(steps);
        let (to, from) = (sides(steps), sides(&(-1.0 * *steps)));
        if Space::of(said).is_some() && ![&*to, &*from].contains(&&*said.to_ascii_uppercase()) {
            let found = quoted(said.as_bytes());
            source.note(format!("{ORIENTATION} {found} is left out: by its matrix the axes come from {from}"));
        }
    }

    /// `DimSize`, checked, how many it has, and which of them are those of the volume.
    fn size(&self, source: &Source) -> Result<([u32; 3], usize, [usize; 3]), ShapeError> {
        let dimensions = self.value("NDims").and_then(|text| text.parse().ok()).unwrap_or(0);
        let one_volume = || self.wrong(source, "NDims", "`NDims = 3`: one volume of 3 dimensions");
        if !DIMENSIONS.contains(&dimensions) {
            return Err(one_volume());
        }
        let text = self.value("DimSize").unwrap_or_default();
        let sizes: Option<Vec<u64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
        let sizes = sizes.filter(|sizes| sizes.len() == dimensions && !sizes.contains(&0));
        let sizes = sizes.ok_or_else(|| self.wrong(source, "DimSize", "3 whole numbers of at least 1"))?;
        let axes = three_axes(source, &sizes, |_| false).ok_or_else(one_volume)?;
        Ok((placement::checked(&source.file, axes.map(|axis| sizes[axis]))?, dimensions, axes))
    }
}
