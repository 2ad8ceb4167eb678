//! MetaImage: volumes as .mhd with a data file, or both in one .mha.
//!
//! Invariant: a key that changes the meaning or the place of values is understood or refused. Positions are LPS, whatever
//! `AnatomicalOrientation` says, as in ITK; a header without directions has no space. Source: Insight Software Consortium,
//! "ITK/MetaIO/Documentation", itk.org/Wiki/ITK/MetaIO.

use super::data_files::DataFiles;
use super::fields::{Fields, finite_or_nan};
use super::placement::{self, Placement};
use super::raster::{Compression, Data, Raster};
use super::space::{Space, or_usual, three_axes};
use crate::error::{ShapeError, quoted};
use crate::sample_type::SampleType;
use crate::shape::{Content, Shape, axes};
use crate::source::Source;
use crate::unit::Unit;
use glam::{DMat3, DVec3};
use std::ops::RangeInclusive;

/// Last key of a header, before the data.
const DATA: &str = "ElementDataFile";
/// Informative key: the sides that the axes come from.
const ORIENTATION: &str = "AnatomicalOrientation";
/// Supported numbers of dimensions.
const DIMENSIONS: RangeInclusive<usize> = 3..=10;
/// Value of `Comment` for signed distances.
pub(crate) const SIGNED_DISTANCE: &str = "hypertexture signed distance";

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

/// Whether the file begins with a first key of MetaImage.
pub(crate) fn recognizes(start: &[u8], _len: u64) -> bool {
    let line = start.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let key = line.split(|byte| *byte == b'=').next().unwrap_or_default().trim_ascii();
    line.contains(&b'=') && (key == b"ObjectType" || key == b"NDims")
}

/// Reads a volume: raw or compressed, after the header or in data files; integers of 8 to 64 bits, float or double, both byte
/// orders, converted to f32 (integers above 2^24 and doubles are rounded).
pub(crate) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    source.unit.set(Some(Unit::Millimeter)); // as ITK takes it
    let header = MetaHeader::read(source)?;
    let raster = header.raster(source)?;
    let is_here = matches!(header.0.get(DATA), Some("LOCAL" | "Local" | "local"));
    let before = match header.0.get("HeaderSize").map(str::parse::<i64>) {
        None | Some(Ok(0)) => Some(0),
        Some(Ok(-1)) if raster.compression == Compression::None => None,
        Some(Ok(-1)) => return Err(header.0.unsupported("HeaderSize", "of compressed data, say how many bytes")),
        // Counted from the start of the file with the data.
        Some(Ok(bytes @ 1..)) if !is_here => Some(bytes as u64),
        Some(Ok(bytes)) if bytes as u64 >= source.offset && bytes > 0 => Some(bytes as u64 - source.offset),
        Some(_) => return Err(header.0.malformed("HeaderSize", "a number of bytes before the data, or -1")),
    };
    let name = header.0.get(DATA).unwrap_or_default();
    let files = if is_here { None } else { Some(DataFiles::read(name, raster.placement.size, source)?) };
    raster.read(source, &Data { files, before, ..Data::HERE })
}

struct MetaHeader(Fields);

impl MetaHeader {
    /// Reads up to the key of the data.
    fn read(source: &mut Source) -> Result<MetaHeader, ShapeError> {
        let (mut fields, mut line) = (Fields::new(source), Vec::new());
        loop {
            if !source.next_line(&mut line)? {
                return Err(source.ended("`ElementDataFile = ...`"));
            }
            let text = String::from_utf8_lossy(&line);
            if text.trim().is_empty() {
                continue;
            }
            let Some((key, value)) = text.split_once('=') else {
                return Err(source.malformed("`Key = value`", &line));
            };
            if !fields.insert(source, key.trim().to_string(), value) {
                return Err(source.malformed("each key once", &line));
            }
            if key.trim() == DATA {
                return Ok(MetaHeader(fields));
            }
        }
    }

    /// First of several alternative keys that the header has.
    fn named<'a>(&self, names: &[&'a str]) -> &'a str {
        names.iter().find(|name| self.0.get(name).is_some()).or(names.first()).copied().unwrap_or_default()
    }

    /// Numbers of a key, if present; NaN is allowed.
    fn numbers(&self, key: &str, count: usize) -> Result<Option<Vec<f64>>, ShapeError> {
        if self.0.get(key).is_none() {
            return Ok(None);
        }
        let numbers: Option<Vec<f64>> = self.0.words(key).into_iter().map(finite_or_nan).collect();
        let expected = match count {
            3 => "3 finite numbers",
            9 => "9 finite numbers",
            _ => "as many finite numbers as `NDims` asks for",
        };
        let numbers = numbers.filter(|numbers| numbers.len() == count);
        numbers.map(Some).ok_or_else(|| self.0.malformed(key, expected))
    }

    /// Value of a Boolean key, `false` if it is missing.
    fn flag(&self, key: &'static str) -> Result<bool, ShapeError> {
        match self.0.get(key).map(str::to_ascii_lowercase).as_deref() {
            None | Some("false" | "f" | "0") => Ok(false),
            Some("true" | "t" | "1") => Ok(true),
            Some(_) => Err(self.0.malformed(key, "`True` or `False`")),
        }
    }

    fn raster(&self, source: &Source) -> Result<Raster, ShapeError> {
        if self.0.get("ObjectType").is_some_and(|kind| kind != "Image") {
            return Err(self.0.unsupported("ObjectType", "only images are volumes"));
        }
        if self.0.get("ElementNumberOfChannels").is_some_and(|count| count != "1") {
            return Err(self.0.unsupported("ElementNumberOfChannels", "extract one of them"));
        }
        if self.0.get("BinaryData").is_some() && !self.flag("BinaryData")? {
            return Err(self.0.unsupported("BinaryData", "save it as binary data"));
        }
        let name =
            self.0.get("ElementType").ok_or_else(|| self.0.malformed("ElementType", "`ElementType = MET_...`"))?;
        let kind = TYPES.iter().find(|(known, _)| *known == name).map(|(_, kind)| *kind);
        let remedy = "convert it to an integer type, float or double";
        let kind = kind.ok_or_else(|| self.0.unsupported("ElementType", remedy))?;
        let order = self.named(&["BinaryDataByteOrderMSB", "ElementByteOrderMSB"]);
        let big_endian = self.flag(order)?;
        let compression = if self.flag("CompressedData")? { Compression::Zlib } else { Compression::None };
        let (size, dimensions, axes) = self.size(source)?;
        // Samples with a size but no spacing touch each other.
        let spacing = self.named(&["ElementSpacing", "ElementSize"]);
        let lengths = self.numbers(spacing, dimensions)?.unwrap_or(vec![1.0; dimensions]);
        let lengths = or_usual(source, spacing, axes.map(|axis| lengths[axis]), f64::NAN, 1.0);
        if !placement::are_lengths(lengths.abs()) {
            return Err(self.0.malformed(spacing, placement::STEPS));
        }
        if lengths.min_element() < 0.0 {
            source.note(format!("{spacing} is below 0: these axes run backwards, as ITK reads it"));
        }
        let place = self.named(&["Offset", "Position", "Origin"]);
        let origin = self.numbers(place, dimensions)?.map(|numbers| DVec3::from(axes.map(|axis| numbers[axis])));
        let origin = origin.unwrap_or_default();
        if origin.is_nan() {
            return Err(self.0.malformed(place, "finite numbers"));
        }
        let turn = self.named(&["TransformMatrix", "Rotation", "Orientation"]);
        // The direction of the first axis, then those of the others.
        let matrix = self.numbers(turn, dimensions * dimensions)?;
        let part = |matrix: &Vec<f64>, axis: usize| DVec3::from(axes.map(|row| matrix[axis * dimensions + row]));
        let columns =
            |matrix: Vec<f64>| DMat3::from_cols(part(&matrix, axes[0]), part(&matrix, axes[1]), part(&matrix, axes[2]));
        let steps = matrix.map_or(DMat3::IDENTITY, columns) * DMat3::from_diagonal(lengths);
        if !placement::are_lengths(axes::lengths(&steps)) {
            return Err(self.0.malformed(turn, placement::STEPS));
        }
        let content = match self.0.get("Comment") {
            Some(SIGNED_DISTANCE) => Content::SignedDistance,
            _ => Content::Scalar,
        };
        self.compare_orientation(source, &steps);
        let is_told = [turn, ORIENTATION].iter().any(|key| self.0.get(key).is_some());
        let space = if is_told { Space::LPS } else { Space::RAS };
        let placement = Placement::new(space, size, (origin, steps), content);
        Ok(Raster { kind, big_endian, compression, scale: None, placement })
    }

    /// Notes an `AnatomicalOrientation` that contradicts the matrix, as sides that the axes come from or point to.
    fn compare_orientation(&self, source: &Source, steps: &DMat3) {
        let Some(said) = self.0.get(ORIENTATION) else { return };
        let sides = |steps: &DMat3| Space::LPS.letters(steps);
        let (to, from) = (sides(steps), sides(&(-1.0 * *steps)));
        if Space::of(said).is_some() && ![&*to, &*from].contains(&&*said.to_ascii_uppercase()) {
            let found = quoted(said.as_bytes());
            source.note(format!("{ORIENTATION} {found} is left out: by its matrix the axes come from {from}"));
        }
    }

    /// Checked size, number of dimensions, and the dimensions of the volume.
    fn size(&self, source: &Source) -> Result<([u32; 3], usize, [usize; 3]), ShapeError> {
        let dimensions = self.0.get("NDims").and_then(|text| text.parse().ok()).unwrap_or(0);
        let one_volume = || self.0.malformed("NDims", "`NDims = 3`: one volume of 3 dimensions");
        if !DIMENSIONS.contains(&dimensions) {
            return Err(one_volume());
        }
        let sizes = self.0.integers("DimSize").filter(|sizes| sizes.len() == dimensions && !sizes.contains(&0));
        let expected = "`DimSize` with a whole number of at least 1 for each dimension";
        let sizes = sizes.ok_or_else(|| self.0.malformed("DimSize", expected))?;
        let axes = three_axes(source, &sizes, |_| false).ok_or_else(one_volume)?;
        Ok((placement::checked(&source.file, axes.map(|axis| sizes[axis]))?, dimensions, axes))
    }
}
