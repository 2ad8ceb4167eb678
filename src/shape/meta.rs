//! MetaImage: volumes as .mhd with a file of data beside it, or both in one .mha.
//!
//! Role: lines `Key = value` into a [`Raster`]. Invariant: a key that changes what the values mean or where they are is
//! understood or refused. Source: Insight Software Consortium, "ITK/MetaIO/Documentation", itk.org/Wiki/ITK/MetaIO.

use super::error::{Location, ShapeError, quoted};
use super::files::Files;
use super::placement::{self, Placement};
use super::raster::{Data, Packing, Raster, Skip};
use super::source::Source;
use super::{Content, SampleType, Shape};
use glam::{DMat3, DVec3};
use std::collections::HashMap;

/// The key behind which the data is: the last one.
const DATA: &str = "ElementDataFile";
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

    /// The numbers of a key, if it is there.
    fn numbers<const N: usize>(&self, source: &Source, key: &'static str) -> Result<Option<[f64; N]>, ShapeError> {
        let Some(text) = self.value(key) else { return Ok(None) };
        let finite = |word: &str| word.parse().ok().filter(|number: &f64| number.is_finite());
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(finite).collect();
        let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
        let expected = if N == 3 { "3 finite numbers" } else { "9 finite numbers" };
        numbers.map(Some).ok_or_else(|| self.wrong(source, key, expected))
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
        if self.value("NDims") != Some("3") {
            return Err(self.wrong(source, "NDims", "`NDims = 3`: one volume of 3 dimensions"));
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
        let size = self.size(source)?;
        // Where samples have a size and no distance, they touch.
        let spacing = self.named(&["ElementSpacing", "ElementSize"]);
        let lengths = DVec3::from(self.numbers(source, spacing)?.unwrap_or([1.0; 3]));
        if !placement::are_lengths(lengths) {
            return Err(self.wrong(source, spacing, placement::STEPS));
        }
        let place = self.named(&["Offset", "Position", "Origin"]);
        let origin = DVec3::from(self.numbers(source, place)?.unwrap_or_default());
        let turn = self.named(&["TransformMatrix", "Rotation", "Orientation"]);
        // The direction of the first axis, then those of the others.
        let axes = self.numbers(source, turn)?.map_or(DMat3::IDENTITY, |axes| DMat3::from_cols_array(&axes));
        let steps = axes * DMat3::from_diagonal(lengths);
        if !placement::are_lengths(super::axes::lengths(&steps)) {
            return Err(self.wrong(source, turn, placement::STEPS));
        }
        let content = match self.value("Comment") {
            Some(SIGNED_DISTANCE) => Content::SignedDistance,
            _ => Content::Scalar,
        };
        let placement = Placement { size, origin, steps, content };
        Ok(Raster { kind, big_endian, packing, scale: None, placement })
    }

    /// `DimSize`, checked.
    fn size(&self, source: &Source) -> Result<[u32; 3], ShapeError> {
        let text = self.value("DimSize").unwrap_or_default();
        let sizes: Option<Vec<u64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
        let wrong = || self.wrong(source, "DimSize", "3 whole numbers of at least 1");
        let size: [u64; 3] = sizes.and_then(|sizes| sizes.try_into().ok()).ok_or_else(wrong)?;
        if size.contains(&0) {
            return Err(wrong());
        }
        placement::checked(&source.file, size)
    }
}
