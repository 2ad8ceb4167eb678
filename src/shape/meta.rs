//! MetaImage: volumes as .mhd with a file of data beside it, or both in one .mha.
//!
//! Role: lines `Key = value` into a [`Raster`]. Invariant: a key that changes what the values mean or where they are is
//! understood or refused. Source: Insight Software Consortium, "ITK/MetaIO/Documentation", itk.org/Wiki/ITK/MetaIO.

use super::error::{Location, ShapeError, quoted};
use super::raster::{Packing, Raster, Skip, Type};
use super::source::Source;
use super::{Content, MAX_COORDINATE, MAX_VOXELS, Shape};
use glam::DVec3;
use std::collections::HashMap;

/// The key behind which the data is: the last one.
const DATA: &str = "ElementDataFile";

/// Names of the types of values.
const TYPES: [(&str, Type); 10] = [
    ("MET_CHAR", Type::I8),
    ("MET_UCHAR", Type::U8),
    ("MET_SHORT", Type::I16),
    ("MET_USHORT", Type::U16),
    ("MET_INT", Type::I32),
    ("MET_UINT", Type::U32),
    ("MET_LONG", Type::I32),
    ("MET_ULONG", Type::U32),
    ("MET_FLOAT", Type::F32),
    ("MET_DOUBLE", Type::F64),
];

/// Whether the file begins with a key that these files begin with.
pub(super) fn recognizes(start: &[u8], _len: u64) -> bool {
    let line = start.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let key = line.split(|byte| *byte == b'=').next().unwrap_or_default().trim_ascii();
    line.contains(&b'=') && (key == b"ObjectType" || key == b"NDims")
}

/// Reads a volume: raw or compressed; integers of 8 to 32 bits, float or double, both byte orders, converted to f32
/// (integers above 2^24 and doubles are rounded). An axis that runs backwards is turned.
pub(super) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    let keys = Keys::read(source)?;
    let raster = keys.raster(source)?;
    let skip = match keys.value("HeaderSize").map(str::parse::<i64>) {
        None => Skip::Bytes(0),
        Some(Ok(-1)) => Skip::ToData,
        Some(Ok(bytes @ 0..)) => Skip::Bytes(bytes as u64),
        Some(_) => return Err(keys.wrong(source, "HeaderSize", "a number of bytes, or -1")),
    };
    match keys.value(DATA).unwrap_or_default() {
        "LOCAL" | "Local" | "local" => raster.read(source),
        list if list.starts_with("LIST") || list.contains('%') => {
            Err(keys.unsupported(source, DATA, "join its files into one, such as with SimpleITK's WriteImage"))
        }
        file => source.beside(file, |data| {
            raster.skip(data, skip)?;
            raster.read(data)
        }),
    }
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
        let remedy = "convert it to an integer type of at most 32 bits, float or double";
        let kind = kind.ok_or_else(|| self.unsupported(source, "ElementType", remedy))?;
        let order = self.named(&["BinaryDataByteOrderMSB", "ElementByteOrderMSB"]);
        let big_endian = self.says(source, order)?;
        let packing = if self.says(source, "CompressedData")? { Packing::Zlib } else { Packing::None };
        let size = self.size(source)?;
        // Where samples have a size and no distance, they touch.
        let spacing = self.named(&["ElementSpacing", "ElementSize"]);
        let spacing = DVec3::from(self.numbers(source, spacing)?.unwrap_or([1.0; 3]));
        let place = self.named(&["Offset", "Position", "Origin"]);
        let origin = DVec3::from(self.numbers(source, place)?.unwrap_or_default());
        let turn = self.named(&["TransformMatrix", "Rotation", "Orientation"]);
        let axes: [f64; 9] = self.numbers(source, turn)?.unwrap_or([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        let is_aligned = (0..9).all(|at| if at % 4 == 0 { axes[at].abs() == 1.0 } else { axes[at] == 0.0 });
        if !is_aligned {
            let remedy = "the axes must not be oblique or exchanged: resample onto the axes";
            return Err(self.unsupported(source, turn, remedy));
        }
        let step = spacing * DVec3::new(axes[0], axes[4], axes[8]);
        let tiny = DVec3::splat(f64::from(f32::MIN_POSITIVE));
        if !(spacing.cmpge(tiny) & spacing.cmple(DVec3::splat(f64::from(MAX_COORDINATE)))).all() {
            let key = self.named(&["ElementSpacing", "ElementSize"]);
            return Err(self.wrong(source, key, "distances between samples from 1.2e-38 to 1e18"));
        }
        Ok(Raster { kind, big_endian, packing, size, origin, step, content: Content::Scalar })
    }

    /// `DimSize`, checked against [`MAX_VOXELS`].
    fn size(&self, source: &Source) -> Result<[u32; 3], ShapeError> {
        let text = self.value("DimSize").unwrap_or_default();
        let sizes: Option<Vec<u64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
        let wrong = || self.wrong(source, "DimSize", "3 whole numbers of at least 1");
        let size: [u64; 3] = sizes.and_then(|sizes| sizes.try_into().ok()).ok_or_else(wrong)?;
        if size.contains(&0) {
            return Err(wrong());
        }
        let voxels = size.iter().try_fold(1_u64, |product, &n| product.checked_mul(n));
        if voxels.is_none_or(|voxels| voxels > MAX_VOXELS) {
            let found = size.map(|n| n.to_string()).join(" x ");
            return Err(ShapeError::TooLarge { file: source.file.clone(), what: "voxels", found, limit: MAX_VOXELS });
        }
        Ok(size.map(|n| n as u32)) // each is at most the product
    }
}
