//! The header of an NRRD file.
//!
//! Role: text fields into a [`Header`] that has been checked. Invariant: a field that changes what the values mean or
//! where they are is understood or refused, never passed over. Source: G. Kindlmann, "Definition of NRRD file format",
//! teem.sourceforge.net/nrrd/format.html.

use super::error::{Location, ShapeError, quoted};
use super::files::Files;
use super::placement::{self, Placement};
use super::raster::{Data, MAX_UNPACKED_SKIP, Packing, Raster, Skip};
use super::source::Source;
use super::space::{Space, or_usual, three_axes};
use super::{Content, SampleType};
use glam::{DMat3, DVec3};
use std::collections::HashMap;
use std::ops::RangeInclusive;

/// Key of the key/value line that says what the values mean.
pub(super) const CONTENT_KEY: &str = "hypertexture content";
/// Its value for [`Content::SignedDistance`].
pub(super) const SIGNED_DISTANCE: &str = "signed distance";

/// What a header says.
pub(super) struct Header {
    /// The samples.
    pub raster: Raster,
    /// Where they are.
    pub data: Data,
}

/// Dimensions that an image may have.
const DIMENSIONS: RangeInclusive<usize> = 3..=16;
/// Sides of a patient.
const SIDES: [&str; 6] = ["right", "left", "anterior", "posterior", "superior", "inferior"];

/// All names of the format for the types that are read.
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

impl Header {
    /// Reads up to the empty line before the data.
    pub fn read(source: &mut Source) -> Result<Header, ShapeError> {
        let mut fields = Fields::read(source)?;
        let size = fields.size(source)?;
        if !fields.of_axes("kinds").is_none_or(|kinds| kinds.iter().all(|kind| is_spatial(kind))) {
            return Err(fields.unsupported("kinds", "every axis must be a direction in space: extract one component"));
        }
        let kind = fields.kind()?;
        let packing = match fields.required("encoding", "`encoding: raw` or another")?.to_ascii_lowercase().as_str() {
            "raw" => Packing::None,
            "gzip" | "gz" => Packing::Gzip,
            "bzip2" | "bz2" => Packing::Bzip2,
            "hex" => Packing::Hex,
            "ascii" | "text" | "txt" => Packing::Text,
            _ => {
                let remedy = "save it as raw, gzip, bzip2, hex or ascii (`unu save -f nrrd -e gzip`)";
                return Err(fields.unsupported("encoding", remedy));
            }
        };
        let big_endian = match fields.optional("endian").map(str::to_ascii_lowercase).as_deref() {
            Some("little") => false,
            Some("big") => true,
            None if kind.bytes() == 1 || packing == Packing::Text => false,
            found => {
                let found = quoted(found.unwrap_or("nothing").as_bytes());
                return Err(source.malformed_at(fields.place("endian"), "`endian: little` or `endian: big`", found));
            }
        };
        let space = fields.space(source)?;
        let place = fields.placement(source)?;
        let content = match fields.keys.get(CONTENT_KEY) {
            None => Content::Scalar,
            Some((_, value)) if value == SIGNED_DISTANCE => Content::SignedDistance,
            Some((line, value)) => {
                let found = quoted(value.as_bytes());
                return Err(source.malformed_at(
                    Location::Line(*line),
                    "`hypertexture content:=signed distance`",
                    found,
                ));
            }
        };
        let data = fields.data(size, packing, source)?;
        let placement = Placement::new(space, size, place, content);
        Ok(Header { raster: Raster { kind, big_endian, packing, scale: None, placement }, data })
    }
}

/// The lines of a header.
struct Fields {
    file: String,
    /// Line and value of `name: value`; names without spaces and in lower case.
    fields: HashMap<String, (u64, String)>,
    /// Line and value of `key:=value`.
    keys: HashMap<String, (u64, String)>,
    /// Its axes that are those of the volume.
    axes: [usize; 3],
}

impl Fields {
    fn read(source: &mut Source) -> Result<Fields, ShapeError> {
        let mut read =
            Fields { file: source.file.clone(), fields: HashMap::new(), keys: HashMap::new(), axes: [0, 1, 2] };
        let mut line = Vec::new();
        source.next_line(&mut line)?; // the magic number has been seen
        loop {
            if !source.next_line(&mut line)? {
                if read.fields.contains_key("datafile") {
                    return Ok(read); // nothing follows
                }
                let end = Location::Line(source.line);
                return Err(source.malformed_at(end, "an empty line and then data", "the end of the file".into()));
            }
            let text = String::from_utf8_lossy(&line);
            if text.is_empty() {
                return Ok(read);
            }
            let value = |text: &str| (source.line, text.trim().to_owned());
            let repeated = if text.starts_with('#') {
                None
            } else if let Some((key, text)) = text.split_once(":=") {
                read.keys.insert(key.to_owned(), value(text))
            } else if let Some((name, text)) = text.split_once(": ") {
                read.fields.insert(name.to_ascii_lowercase().replace(' ', ""), value(text))
            } else {
                return Err(source.malformed("`field: value`, `key:=value`, a comment or an empty line", &line));
            };
            if repeated.is_some() {
                return Err(source.malformed("each field once", &line));
            }
            if read.optional("datafile").is_some_and(|file| file.split_whitespace().next() == Some("LIST")) {
                return Ok(read); // the names follow
            }
        }
    }

    fn optional(&self, name: &str) -> Option<&str> {
        self.fields.get(name).map(|(_, value)| value.as_str())
    }

    fn place(&self, name: &str) -> Location {
        self.fields.get(name).map_or(Location::Header, |(line, _)| Location::Line(*line))
    }

    fn required(&self, name: &str, expected: &'static str) -> Result<&str, ShapeError> {
        self.optional(name).ok_or_else(|| self.malformed(name, expected))
    }

    /// Where the data is.
    fn data(&self, size: [u32; 3], packing: Packing, source: &mut Source) -> Result<Data, ShapeError> {
        let lines = match self.optional("lineskip").map(str::parse) {
            None => 0,
            Some(Ok(lines)) => lines,
            Some(Err(_)) => return Err(self.malformed("lineskip", "a number of lines")),
        };
        let (before, inside) = match (self.optional("byteskip").map(str::parse::<i64>), packing) {
            (None, _) => (Skip::Bytes(0), 0),
            (Some(Ok(-1)), Packing::None) => (Skip::ToData, 0),
            (Some(Ok(-1)), _) => return Err(self.unsupported("byteskip", "only raw data can be found from its end")),
            (Some(Ok(bytes @ 0..)), Packing::None | Packing::Text | Packing::Hex) => (Skip::Bytes(bytes as u64), 0),
            // What is skipped there is packed as well.
            (Some(Ok(bytes @ 0..)), _) if bytes as u64 <= MAX_UNPACKED_SKIP => (Skip::Bytes(0), bytes as u64),
            _ => return Err(self.malformed("byteskip", "a number of bytes (at most 2^28 of compressed data), or -1")),
        };
        let files = self.optional("datafile").map(|files| Files::read(files, size, source)).transpose()?;
        Ok(Data { files, lines, before, inside })
    }

    /// The value of `name`, or its absence, is not `expected`.
    fn malformed(&self, name: &str, expected: &'static str) -> ShapeError {
        let found = self.optional(name).map_or("nothing".into(), |value| quoted(value.as_bytes()));
        ShapeError::Malformed { file: self.file.clone(), place: self.place(name), expected, found }
    }

    fn unsupported(&self, name: &'static str, remedy: &'static str) -> ShapeError {
        let found = quoted(self.optional(name).unwrap_or_default().as_bytes());
        ShapeError::Unsupported { file: self.file.clone(), place: self.place(name), what: name, found, remedy }
    }

    fn kind(&self) -> Result<SampleType, ShapeError> {
        let name = self.required("type", "a `type` field")?.to_ascii_lowercase();
        let known = NAMES.iter().find(|(_, names)| names.contains(&name.as_str()));
        let remedy = "convert it to an integer type, float or double (`unu convert -t float`)";
        known.map(|(kind, _)| *kind).ok_or_else(|| self.unsupported("type", remedy))
    }

    /// `sizes` of the axes of the volume, checked.
    fn size(&mut self, source: &Source) -> Result<[u32; 3], ShapeError> {
        let dimensions = self.required("dimension", "`dimension: 3`")?.parse().unwrap_or(0);
        let expected = "`sizes` with 3 whole numbers, or as many as `dimension` says";
        if !DIMENSIONS.contains(&dimensions) {
            return Err(self.unsupported("dimension", "extract one volume of 3 dimensions"));
        }
        let parsed: Option<Vec<u64>> =
            self.required("sizes", expected)?.split_whitespace().map(|text| text.parse().ok()).collect();
        let sizes =
            parsed.filter(|sizes| sizes.len() == dimensions).ok_or_else(|| self.malformed("sizes", expected))?;
        let (directions, kinds) = (self.vectors("spacedirections")?, self.words("kinds"));
        let is_last = |axis: usize| {
            let is_kind = kinds.get(axis).is_none_or(|kind| is_spatial(kind));
            matches!(directions.get(axis), Some(None)) || !is_kind
        };
        self.axes = three_axes(source, &sizes, is_last)
            .ok_or_else(|| self.unsupported("dimension", "extract one volume of 3 dimensions"))?;
        let size = self.axes.map(|axis| sizes[axis]);
        let Location::Line(line) = self.place("sizes") else { return Err(self.malformed("sizes", expected)) };
        if size.contains(&0) {
            return Err(ShapeError::ZeroSize { file: self.file.clone(), line, size });
        }
        placement::checked(&self.file, size)
    }

    /// The space that positions and directions are in.
    fn space(&self, source: &Source) -> Result<Space, ShapeError> {
        let Some(space) = self.optional("space").map(str::to_ascii_lowercase) else { return Ok(Space::RAS) };
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
                let letters: String = match is_long {
                    true => space.split('-').filter_map(|word| word.chars().next()).collect(),
                    false => space.into(),
                };
                let known = |word: &str| SIDES.contains(&word) || !is_long;
                let found = Space::of(&letters).filter(|_| space.split('-').all(known));
                found.ok_or_else(|| {
                    let remedy = "three sides of a patient are read, as right-anterior-superior or RAS, scanner-xyz, \
                        3D-right-handed and 3D-left-handed";
                    self.unsupported("space", remedy)
                })
            }
        }
    }

    /// Position of the first sample in that space, and the steps to the next on each axis.
    fn placement(&self, source: &Source) -> Result<(DVec3, DMat3), ShapeError> {
        let directed = self.optional("spacedirections").is_some();
        let steps = match (directed, self.optional("spacings").is_some()) {
            (true, true) => return Err(self.malformed("spacings", "`spacings` or `space directions`, not both")),
            (true, false) => self.directions()?,
            (false, true) => {
                let spacings = or_usual(source, "spacings", self.three("spacings")?, f64::NAN, 1.0);
                if spacings.min_element() < 0.0 {
                    source.note("spacings below 0: these axes run backwards".into());
                }
                DMat3::from_diagonal(spacings)
            }
            (false, false) if self.optional("axismaxs").is_some() => {
                return Err(self.unsupported("axismaxs", "write `spacings` instead"));
            }
            (false, false) => DMat3::IDENTITY,
        };
        if !placement::are_lengths(super::axes::lengths(&steps)) {
            let name = if directed { "spacedirections" } else { "spacings" };
            return Err(self.malformed(name, placement::STEPS));
        }
        if self.optional("spaceorigin").is_some() {
            let origin = self.vectors("spaceorigin")?;
            let [Some(origin)] = origin[..] else {
                return Err(self.malformed("spaceorigin", "one vector, as (0,0,0)"));
            };
            return Ok((origin, steps));
        }
        if self.optional("axismins").is_none() {
            return Ok((DVec3::ZERO, steps));
        }
        // The axis begins at the first sample, or half a step before it where samples stand for cells.
        let centers = self.of_axes("centers");
        let cell = |axis: usize| centers.as_ref().is_some_and(|centers| centers[axis] == "cell");
        let half = DVec3::from([0, 1, 2].map(|axis| if cell(axis) { 0.5 } else { 0.0 }));
        let first = or_usual(source, "axis mins", self.three("axismins")?, f64::NAN, 0.0);
        Ok((first + steps * half, steps))
    }

    /// `space directions`: a step for each axis.
    fn directions(&self) -> Result<DMat3, ShapeError> {
        let directions = self.vectors("spacedirections")?;
        let of_axis = |axis: usize| directions.get(axis).copied().flatten();
        match self.axes.map(of_axis) {
            [Some(x), Some(y), Some(z)] => Ok(DMat3::from_cols(x, y, z)),
            _ => Err(self.malformed("spacedirections", "3 vectors of 3 numbers, as (1,0,0) (0,1,0) (0,0,1)")),
        }
    }

    /// The words of a field with one for each axis.
    fn words(&self, name: &str) -> Vec<&str> {
        self.optional(name).unwrap_or_default().split_whitespace().collect()
    }

    /// Those of the axes of the volume, if the field has them.
    fn of_axes(&self, name: &str) -> Option<[&str; 3]> {
        let words = self.words(name);
        let [x, y, z] = self.axes.map(|axis| words.get(axis).copied());
        Some([x?, y?, z?])
    }

    /// The numbers of the axes of the volume: finite, or NaN where nothing is known.
    fn three(&self, name: &str) -> Result<[f64; 3], ShapeError> {
        let number = |text: &str| text.parse().ok().filter(|number: &f64| !number.is_infinite());
        let numbers = self.of_axes(name).and_then(|[x, y, z]| Some([number(x)?, number(y)?, number(z)?]));
        numbers.ok_or_else(|| self.malformed(name, "3 numbers"))
    }

    /// The vectors `(x,y,z) (x,y,z)...`, of which some may be `none`.
    fn vectors(&self, name: &str) -> Result<Vec<Option<DVec3>>, ShapeError> {
        let mut text = self.optional(name).unwrap_or_default().trim();
        let mut vectors = Vec::new();
        while !text.is_empty() {
            let (vector, rest) = match text.strip_prefix("none") {
                Some(rest) => (None, rest),
                None => {
                    let parts = text.strip_prefix('(').and_then(|text| text.split_once(')'));
                    let parts = parts.and_then(|(inner, rest)| Some((vector(inner)?, rest)));
                    let (vector, rest) =
                        parts.ok_or_else(|| self.malformed(name, "vectors of 3 numbers, as (1,0,0)"))?;
                    (Some(vector), rest)
                }
            };
            vectors.push(vector);
            text = rest.trim_start();
        }
        Ok(vectors)
    }
}

/// Three finite numbers between commas, and a fourth one where it is of time.
fn vector(text: &str) -> Option<DVec3> {
    let finite = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    match text.split(',').map(finite).collect::<Option<Vec<f64>>>()?[..] {
        [x, y, z] | [x, y, z, 0.0] => Some(DVec3::new(x, y, z)),
        _ => None,
    }
}

/// Whether the kind of an axis is that of a direction in space.
fn is_spatial(kind: &str) -> bool {
    matches!(kind, "domain" | "space" | "none" | "???")
}
