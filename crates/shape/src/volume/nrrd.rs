//! NRRD, "nearly raw raster data": reader.
//!
//! Invariant: a field that changes the meaning or the place of values is understood or refused, never skipped. Source: G.
//! Kindlmann, "Definition of NRRD file format", teem.sourceforge.net/nrrd/format.html.

use super::data_files::DataFiles;
use super::fields::{Fields, finite_or_nan};
use super::placement::{self, Placement};
use super::raster::{Compression, Data, MAX_UNPACKED_SKIP, Raster};
use super::space::{Space, listed, or_usual, three_axes};
use crate::error::{Location, ShapeError, quoted};
use crate::sample_type::SampleType;
use crate::shape::{Content, Shape, axes};
use crate::source::Source;
use crate::unit::Unit;
use glam::{DMat3, DVec3};
use std::ops::RangeInclusive;

/// Key of the key/value line with the meaning of the values.
pub(crate) const CONTENT_KEY: &str = "hypertexture content";
/// Value of that line for [`Content::SignedDistance`].
pub(crate) const SIGNED_DISTANCE: &str = "signed distance";

/// Supported numbers of dimensions.
const DIMENSIONS: RangeInclusive<usize> = 3..=16;
const SIDES: [&str; 6] = ["right", "left", "anterior", "posterior", "superior", "inferior"];

/// Names of the supported types.
const NAMES: [(SampleType, &[&str]); 10] = [
    (SampleType::I8, &["signed char", "int8", "int8_t"]),
    (SampleType::U8, &["uchar", "unsigned char", "uint8", "uint8_t"]),
    (SampleType::I16, &["short", "short int", "signed short", "signed short int", "int16", "int16_t"]),
    (SampleType::U16, &["ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"]),
    (SampleType::I32, &["int", "signed int", "int32", "int32_t"]),
    (SampleType::U32, &["uint", "unsigned int", "uint32", "uint32_t"]),
    (
        SampleType::I64,
        &["longlong", "long long", "long long int", "signed long long", "signed long long int", "int64", "int64_t"],
    ),
    (SampleType::U64, &["ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"]),
    (SampleType::F32, &["float"]),
    (SampleType::F64, &["double"]),
];

/// Whether the file begins with the magic number of versions 1 to 5.
pub(crate) fn recognizes(start: &[u8], _len: u64) -> bool {
    start.starts_with(b"NRRD000") && matches!(start.get(7), Some(b'1'..=b'5'))
}

/// Reads a volume: raw, gzip, bzip2, hexadecimal or text, attached or in files beside it; integers of 8 to 64 bits, float or
/// double, both byte orders, converted to f32 (integers above 2^24 and doubles are rounded).
pub(crate) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    if !recognizes(source.peek()?, 0) {
        let start = source.peek()?.to_vec();
        source.line = 1;
        return Err(source.malformed("`NRRD0001` to `NRRD0005`", &start));
    }
    let mut header = NrrdHeader::read(source)?;
    let size = header.size(source)?;
    let fields = &header.fields;
    if !header.of_axes("kinds").is_none_or(|kinds| kinds.iter().all(|kind| is_spatial(kind))) {
        return Err(fields.unsupported("kinds", "every axis must be a direction in space: extract one component"));
    }
    let kind = header.kind()?;
    let compression = match header.required("encoding", "`encoding: raw` or another")?.to_ascii_lowercase().as_str() {
        "raw" => Compression::None,
        "gzip" | "gz" => Compression::Gzip,
        "bzip2" | "bz2" => Compression::Bzip2,
        "hex" => Compression::Hex,
        "ascii" | "text" | "txt" => Compression::Text,
        _ => {
            let remedy = "save it as raw, gzip, bzip2, hex or ascii (`unu save -f nrrd -e gzip`)";
            return Err(fields.unsupported("encoding", remedy));
        }
    };
    let big_endian = match fields.get("endian").map(str::to_ascii_lowercase).as_deref() {
        Some("little") => false,
        Some("big") => true,
        None if kind.bytes() == 1 || compression == Compression::Text => false,
        _ => return Err(fields.malformed("endian", "`endian: little` or `endian: big`")),
    };
    let space = header.space(source)?;
    let geometry = header.geometry(source)?;
    let content = match header.keys.get(CONTENT_KEY) {
        None => Content::Scalar,
        Some(SIGNED_DISTANCE) => Content::SignedDistance,
        Some(_) => return Err(header.keys.malformed(CONTENT_KEY, "`hypertexture content:=signed distance`")),
    };
    source.unit.set(header.unit());
    let data = header.data(size, compression, source)?;
    let placement = Placement::new(space, size, geometry, content);
    Raster { kind, big_endian, compression, scale: None, placement }.read(source, &data)
}

struct NrrdHeader {
    /// Lines `name: value`; names in lower case without spaces.
    fields: Fields,
    /// Lines `key:=value`.
    keys: Fields,
    /// Axes of the file that are those of the volume.
    axes: [usize; 3],
}

impl NrrdHeader {
    /// The unit of space, if all axes have the same known one.
    fn unit(&self) -> Option<Unit> {
        let text = self.fields.get("spaceunits")?;
        let mut units = text.split('"').skip(1).step_by(2).map(Unit::named);
        let first = units.next()??;
        units.all(|unit| unit == Some(first)).then_some(first)
    }

    /// Reads up to the empty line before the data.
    fn read(source: &mut Source) -> Result<NrrdHeader, ShapeError> {
        let mut read = NrrdHeader { fields: Fields::new(source), keys: Fields::new(source), axes: [0, 1, 2] };
        let mut line = Vec::new();
        source.next_line(&mut line)?; // the magic number
        loop {
            if !source.next_line(&mut line)? {
                if read.fields.get("datafile").is_some() {
                    return Ok(read);
                }
                return Err(source.ended("an empty line and then data"));
            }
            let text = String::from_utf8_lossy(&line);
            if text.is_empty() {
                return Ok(read);
            }
            let is_new = if text.starts_with('#') {
                true
            } else if let Some((key, value)) = text.split_once(":=") {
                if !read.keys.insert(source, key.to_owned(), value) {
                    source.note(format!("the key {} is there twice: its last value counts", quoted(key.as_bytes())));
                }
                true
            } else if let Some((name, value)) = text.split_once(": ") {
                read.fields.insert(source, name.to_ascii_lowercase().replace(' ', ""), value)
            } else {
                return Err(source.malformed("`field: value`, `key:=value`, a comment or an empty line", &line));
            };
            if !is_new {
                return Err(source.malformed("each field once", &line));
            }
            if read.fields.words("datafile").first() == Some(&"LIST") {
                return Ok(read); // file names follow
            }
        }
    }

    fn required(&self, name: &str, expected: &'static str) -> Result<&str, ShapeError> {
        self.fields.get(name).ok_or_else(|| self.fields.malformed(name, expected))
    }

    fn data(&self, size: [u32; 3], compression: Compression, source: &mut Source) -> Result<Data, ShapeError> {
        let lines = match self.fields.get("lineskip").map(str::parse) {
            None => 0,
            Some(Ok(lines)) => lines,
            Some(Err(_)) => return Err(self.fields.malformed("lineskip", "a number of lines")),
        };
        let (before, inside) = match (self.fields.get("byteskip").map(str::parse::<i64>), compression) {
            (None, _) => (Some(0), Some(0)),
            (Some(Ok(-1)), Compression::None) => (None, Some(0)),
            (Some(Ok(-1)), Compression::Text | Compression::Hex) => {
                return Err(self.fields.unsupported("byteskip", "only binary data can be found from its end"));
            }
            (Some(Ok(-1)), _) => (Some(0), None),
            (Some(Ok(bytes @ 0..)), Compression::None | Compression::Text | Compression::Hex) => {
                (Some(bytes as u64), Some(0))
            }
            // The skipped bytes are compressed too.
            (Some(Ok(bytes @ 0..)), _) if bytes as u64 <= MAX_UNPACKED_SKIP => (Some(0), Some(bytes as u64)),
            _ => {
                return Err(self
                    .fields
                    .malformed("byteskip", "a number of bytes (at most 2^28 of compressed data), or -1"));
            }
        };
        let files = self.fields.get("datafile").map(|files| DataFiles::read(files, size, source)).transpose()?;
        Ok(Data { files, lines, before, inside })
    }

    fn kind(&self) -> Result<SampleType, ShapeError> {
        let name = self.required("type", "a `type` field")?.to_ascii_lowercase();
        let known = NAMES.iter().find(|(_, names)| names.contains(&name.as_str()));
        let remedy = "convert it to an integer type, float or double (`unu convert -t float`)";
        known.map(|(kind, _)| *kind).ok_or_else(|| self.fields.unsupported("type", remedy))
    }

    /// Checked sizes of the axes of the volume.
    fn size(&mut self, source: &Source) -> Result<[u32; 3], ShapeError> {
        let dimensions = self.required("dimension", "`dimension: 3`")?.parse().unwrap_or(0);
        let expected = "`sizes` with 3 whole numbers, or as many as `dimension` says";
        if !DIMENSIONS.contains(&dimensions) {
            return Err(self.fields.unsupported("dimension", "extract one volume of 3 dimensions"));
        }
        self.required("sizes", expected)?;
        let sizes = self.fields.integers("sizes").filter(|sizes| sizes.len() == dimensions);
        let sizes = sizes.ok_or_else(|| self.fields.malformed("sizes", expected))?;
        let (directions, kinds) = (self.vectors("spacedirections")?, self.fields.words("kinds"));
        let is_last = |axis: usize| {
            let is_kind = kinds.get(axis).is_none_or(|kind| is_spatial(kind));
            matches!(directions.get(axis), Some(None)) || !is_kind
        };
        self.axes = three_axes(source, &sizes, is_last)
            .ok_or_else(|| self.fields.unsupported("dimension", "extract one volume of 3 dimensions"))?;
        let size = self.axes.map(|axis| sizes[axis]);
        let Location::Line(line) = self.fields.place("sizes") else {
            return Err(self.fields.malformed("sizes", expected));
        };
        if size.contains(&0) {
            return Err(ShapeError::ZeroSize { file: source.file.clone(), line, size });
        }
        placement::checked(&source.file, size)
    }

    /// Space of positions and directions.
    fn space(&self, source: &Source) -> Result<Space, ShapeError> {
        let Some(space) = self.fields.get("space").map(str::to_ascii_lowercase) else { return Ok(Space::RAS) };
        let without_time = match space.len() {
            4 => space.strip_suffix('t'),
            _ => space.strip_suffix("-time"),
        };
        let space = without_time.unwrap_or(&space);
        match space {
            "scanner-xyz" | "3d-right-handed" => Ok(Space::RAS),
            "3d-left-handed" => {
                source.note("its space is left-handed: its z is turned around".into());
                Ok(Space::LEFT_HANDED)
            }
            _ => {
                let is_long = space.contains('-');
                let letters: String = if is_long {
                    space.split('-').filter_map(|word| word.chars().next()).collect()
                } else {
                    space.into()
                };
                let known = |word: &str| SIDES.contains(&word) || !is_long;
                let found = Space::of(&letters).filter(|_| space.split('-').all(known));
                found.ok_or_else(|| {
                    let remedy = "three sides of a patient are read, as right-anterior-superior or RAS, scanner-xyz, \
                        3D-right-handed and 3D-left-handed";
                    self.fields.unsupported("space", remedy)
                })
            }
        }
    }

    /// Position of the first sample in this space, and the step along each axis.
    fn geometry(&self, source: &Source) -> Result<(DVec3, DMat3), ShapeError> {
        let directed = self.fields.get("spacedirections").is_some();
        let steps = match (directed, self.fields.get("spacings").is_some()) {
            (true, true) => {
                return Err(self.fields.malformed("spacings", "`spacings` or `space directions`, not both"));
            }
            (true, false) => self.directions()?,
            (false, true) => {
                let spacings = or_usual(source, "spacings", self.three("spacings")?, f64::NAN, 1.0);
                if spacings.min_element() < 0.0 {
                    source.note("spacings below 0: these axes run backwards".into());
                }
                DMat3::from_diagonal(spacings)
            }
            (false, false) if self.fields.get("axismaxs").is_some() => self.between_ends(source)?,
            (false, false) => DMat3::IDENTITY,
        };
        if !placement::are_lengths(axes::lengths(&steps)) {
            let name = if directed { "spacedirections" } else { "spacings" };
            return Err(self.fields.malformed(name, placement::STEPS));
        }
        if self.fields.get("spaceorigin").is_some() {
            let origin = self.vectors("spaceorigin")?;
            let [Some(origin)] = origin[..] else {
                return Err(self.fields.malformed("spaceorigin", "one vector, as (0,0,0)"));
            };
            return Ok((origin, steps));
        }
        if self.fields.get("axismins").is_none() {
            return Ok((DVec3::ZERO, steps));
        }
        // `axis mins` is the first sample, or half a step before it for cell-centered samples.
        let half = DVec3::from([0, 1, 2].map(|axis| if self.is_cell(axis) { 0.5 } else { 0.0 }));
        let first = or_usual(source, "axis mins", self.three("axismins")?, f64::NAN, 0.0);
        Ok((first + steps * half, steps))
    }

    /// Whether samples are the centers of cells, by the axis of the volume. Axes with two ends are so unless they say otherwise, as
    /// in teem.
    fn is_cell(&self, axis: usize) -> bool {
        let center = self.of_axes("centers").or_else(|| self.of_axes("centerings")).map(|centers| centers[axis]);
        match center {
            Some("cell") => true,
            Some("node") => false,
            _ => self.fields.get("axismaxs").is_some() && self.fields.get("spacings").is_none(),
        }
    }

    /// Steps from `axis mins` and `axis maxs`.
    fn between_ends(&self, source: &Source) -> Result<DMat3, ShapeError> {
        if self.fields.get("axismins").is_none() {
            return Err(self.fields.unsupported("axismaxs", "write `axis mins` too, or `spacings`"));
        }
        let (first, last) = (self.three("axismins")?, self.three("axismaxs")?);
        let sizes = self.fields.integers("sizes").unwrap_or_default();
        let step = |axis: usize| {
            let count = sizes.get(self.axes[axis]).map_or(1.0, |count| *count as f64);
            (last[axis] - first[axis]) / if self.is_cell(axis) { count } else { (count - 1.0).max(1.0) }
        };
        let steps = [0, 1, 2].map(step);
        if steps.iter().any(|step| !step.is_finite() || *step == 0.0) {
            return Err(self.fields.malformed("axismaxs", "3 numbers other than those of `axis mins`"));
        }
        source.note(format!("its spacings follow from `axis mins` and `axis maxs`: {}", listed(&steps)));
        Ok(DMat3::from_diagonal(steps.into()))
    }

    /// Steps from `space directions`.
    fn directions(&self) -> Result<DMat3, ShapeError> {
        let directions = self.vectors("spacedirections")?;
        let of_axis = |axis: usize| directions.get(axis).copied().flatten();
        match self.axes.map(of_axis) {
            [Some(x), Some(y), Some(z)] => Ok(DMat3::from_cols(x, y, z)),
            _ => Err(self.fields.malformed("spacedirections", "3 vectors of 3 numbers, as (1,0,0) (0,1,0) (0,0,1)")),
        }
    }

    /// Words of a field for the axes of the volume.
    fn of_axes(&self, name: &str) -> Option<[&str; 3]> {
        let words = self.fields.words(name);
        let [x, y, z] = self.axes.map(|axis| words.get(axis).copied());
        Some([x?, y?, z?])
    }

    /// Numbers of a field for the axes of the volume; NaN is allowed and means unknown.
    fn three(&self, name: &str) -> Result<[f64; 3], ShapeError> {
        let numbers = self.of_axes(name).map(|words| words.map(finite_or_nan));
        let numbers = numbers.and_then(|[x, y, z]| Some([x?, y?, z?]));
        numbers.ok_or_else(|| self.fields.malformed(name, "3 numbers"))
    }

    /// Vectors `(x,y,z) (x,y,z)...`; each may be `none`.
    fn vectors(&self, name: &str) -> Result<Vec<Option<DVec3>>, ShapeError> {
        let mut text = self.fields.get(name).unwrap_or_default().trim();
        let mut vectors = Vec::new();
        while !text.is_empty() {
            let (vector, rest) = match text.strip_prefix("none") {
                Some(rest) => (None, rest),
                None => {
                    let parts = text.strip_prefix('(').and_then(|text| text.split_once(')'));
                    let parts = parts.and_then(|(inner, rest)| Some((vector(inner)?, rest)));
                    let (vector, rest) =
                        parts.ok_or_else(|| self.fields.malformed(name, "vectors of 3 numbers, as (1,0,0)"))?;
                    (Some(vector), rest)
                }
            };
            vectors.push(vector);
            text = rest.trim_start();
        }
        Ok(vectors)
    }
}

/// Three finite numbers between commas; a fourth one, of time, must be 0.
fn vector(text: &str) -> Option<DVec3> {
    let finite = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    match text.split(',').map(finite).collect::<Option<Vec<f64>>>()?[..] {
        [x, y, z] | [x, y, z, 0.0] => Some(DVec3::new(x, y, z)),
        _ => None,
    }
}

/// Whether an axis kind is a direction in space.
fn is_spatial(kind: &str) -> bool {
    matches!(kind, "domain" | "space" | "none" | "???")
}
