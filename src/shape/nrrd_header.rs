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
use super::{Content, SampleType};
use glam::{DMat3, DVec3};
use std::collections::HashMap;

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
        let fields = Fields::read(source)?;
        if fields.required("dimension", "`dimension: 3`")? != "3" {
            return Err(fields.unsupported("dimension", "extract one volume of 3 dimensions"));
        }
        if let Some(kinds) = fields.optional("kinds")
            && !kinds.split_whitespace().all(|kind| matches!(kind, "domain" | "space" | "none" | "???"))
        {
            return Err(fields.unsupported("kinds", "every axis must be a direction in space: extract one component"));
        }
        let kind = fields.kind()?;
        let packing = match fields.required("encoding", "`encoding: raw` or another")?.to_ascii_lowercase().as_str() {
            "raw" => Packing::None,
            "gzip" | "gz" => Packing::Gzip,
            "bzip2" | "bz2" => Packing::Bzip2,
            "ascii" | "text" | "txt" => Packing::Text,
            _ => {
                let remedy = "save it as raw, gzip, bzip2 or ascii (`unu save -f nrrd -e gzip`)";
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
        let size = fields.size()?;
        let (origin, steps) = fields.placement()?;
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
        let placement = Placement { size, origin, steps, content };
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
}

impl Fields {
    fn read(source: &mut Source) -> Result<Fields, ShapeError> {
        let mut read = Fields { file: source.file.clone(), fields: HashMap::new(), keys: HashMap::new() };
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
            (Some(Ok(bytes @ 0..)), Packing::None | Packing::Text) => (Skip::Bytes(bytes as u64), 0),
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

    /// `sizes`, checked.
    fn size(&self) -> Result<[u32; 3], ShapeError> {
        let expected = "`sizes` with 3 whole numbers";
        let parsed: Option<Vec<u64>> =
            self.required("sizes", expected)?.split_whitespace().map(|text| text.parse().ok()).collect();
        let size: [u64; 3] =
            parsed.and_then(|sizes| sizes.try_into().ok()).ok_or_else(|| self.malformed("sizes", expected))?;
        let Location::Line(line) = self.place("sizes") else { return Err(self.malformed("sizes", expected)) };
        if size.contains(&0) {
            return Err(ShapeError::ZeroSize { file: self.file.clone(), line, size });
        }
        placement::checked(&self.file, size)
    }

    /// World position of the first sample, and the steps to the next on each axis.
    fn placement(&self) -> Result<(DVec3, DMat3), ShapeError> {
        let directed = self.optional("spacedirections").is_some();
        let steps = match (directed, self.optional("spacings").is_some()) {
            (true, true) => return Err(self.malformed("spacings", "`spacings` or `space directions`, not both")),
            (true, false) => self.directions()?,
            (false, true) => DMat3::from_diagonal(self.three("spacings", "3 numbers")?),
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
            let [origin] = origin[..] else { return Err(self.malformed("spaceorigin", "one vector, as (0,0,0)")) };
            return Ok((origin, steps));
        }
        if self.optional("axismins").is_none() {
            return Ok((DVec3::ZERO, steps));
        }
        // The axis begins at the first sample, or half a step before it where samples stand for cells.
        let centers: Vec<&str> = self.optional("centers").unwrap_or_default().split_whitespace().collect();
        let cell = |axis: usize| centers.get(axis).is_some_and(|&center| center == "cell");
        let half = DVec3::from([0, 1, 2].map(|axis| if cell(axis) { 0.5 } else { 0.0 }));
        Ok((self.three("axismins", "3 numbers")? + steps * half, steps))
    }

    /// `space directions`: a step for each axis.
    fn directions(&self) -> Result<DMat3, ShapeError> {
        let directions = self.vectors("spacedirections")?;
        let [x, y, z] = directions[..] else {
            return Err(self.malformed("spacedirections", "3 vectors, as (1,0,0) (0,1,0) (0,0,1)"));
        };
        Ok(DMat3::from_cols(x, y, z))
    }

    fn three(&self, name: &str, expected: &'static str) -> Result<DVec3, ShapeError> {
        let text = self.optional(name).unwrap_or_default();
        numbers(text.split_whitespace()).ok_or_else(|| self.malformed(name, expected))
    }

    /// The vectors `(x,y,z) (x,y,z)...`.
    fn vectors(&self, name: &str) -> Result<Vec<DVec3>, ShapeError> {
        let text = self.optional(name).unwrap_or_default().trim();
        let inner = text.strip_prefix('(').and_then(|text| text.strip_suffix(')'));
        let parts = inner.map(|inner| inner.split(')').map(|part| part.trim_start().trim_start_matches('(')));
        let vectors = parts.and_then(|parts| parts.map(|part| numbers(part.split(',').map(str::trim))).collect());
        vectors.ok_or_else(|| self.malformed(name, "vectors of 3 numbers, as (1,0,0)"))
    }
}

/// Exactly three finite numbers.
fn numbers<'a>(texts: impl Iterator<Item = &'a str>) -> Option<DVec3> {
    let parsed: Option<Vec<f64>> = texts.map(|text| text.parse().ok().filter(|x: &f64| x.is_finite())).collect();
    let array: [f64; 3] = parsed?.try_into().ok()?;
    Some(DVec3::from(array))
}
