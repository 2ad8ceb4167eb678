//! The header of an NRRD file.
//!
//! Role: text fields into a [`Header`] that has been checked. Invariant: a field that changes what the values mean or
//! where they are is understood or refused, never passed over. Source: G. Kindlmann, "Definition of NRRD file format",
//! teem.sourceforge.net/nrrd/format.html.

use super::error::{Location, ShapeError, quoted};
use super::raster::{Packing, Raster, Skip, Type};
use super::source::Source;
use super::{Content, MAX_COORDINATE, MAX_VOXELS};
use glam::DVec3;
use std::collections::HashMap;

/// Key of the key/value line that says what the values mean.
pub(super) const CONTENT_KEY: &str = "hypertexture content";
/// Its value for [`Content::SignedDistance`].
pub(super) const SIGNED_DISTANCE: &str = "signed distance";

/// What a header says.
pub(super) struct Header {
    /// The samples.
    pub raster: Raster,
    /// The file that holds them, if not this one, and what is before them in it.
    pub side: Option<(String, Skip)>,
}

/// All names of the format for the types that are read.
const NAMES: [(Type, &[&str]); 8] = [
    (Type::I8, &["signed char", "int8", "int8_t"]),
    (Type::U8, &["uchar", "unsigned char", "uint8", "uint8_t"]),
    (Type::I16, &["short", "short int", "signed short", "signed short int", "int16", "int16_t"]),
    (Type::U16, &["ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"]),
    (Type::I32, &["int", "signed int", "int32", "int32_t"]),
    (Type::U32, &["uint", "unsigned int", "uint32", "uint32_t"]),
    (Type::F32, &["float"]),
    (Type::F64, &["double"]),
];

impl Header {
    /// Reads up to the empty line before the data.
    pub fn read(source: &mut Source) -> Result<Header, ShapeError> {
        let fields = Fields::read(source)?;
        if fields.optional("lineskip").is_some_and(|lines| lines != "0") {
            return Err(fields.unsupported("lineskip", "save the file without it"));
        }
        if fields.required("dimension", "`dimension: 3`")? != "3" {
            return Err(fields.unsupported("dimension", "extract one volume of 3 dimensions"));
        }
        if let Some(kinds) = fields.optional("kinds")
            && !kinds.split_whitespace().all(|kind| matches!(kind, "domain" | "space" | "none" | "???"))
        {
            return Err(fields.unsupported("kinds", "every axis must be a direction in space: extract one component"));
        }
        let kind = fields.kind()?;
        let big_endian = match fields.optional("endian").map(str::to_ascii_lowercase).as_deref() {
            Some("little") => false,
            Some("big") => true,
            None if kind.bytes() == 1 => false,
            found => {
                let found = quoted(found.unwrap_or("nothing").as_bytes());
                return Err(source.malformed_at(fields.place("endian"), "`endian: little` or `endian: big`", found));
            }
        };
        let packing =
            match fields.required("encoding", "`encoding: raw` or `encoding: gzip`")?.to_ascii_lowercase().as_str() {
                "raw" => Packing::None,
                "gzip" | "gz" => Packing::Gzip,
                _ => return Err(fields.unsupported("encoding", "save it as raw or gzip (`unu save -f nrrd -e gzip`)")),
            };
        let size = fields.size()?;
        let (origin, step) = fields.placement()?;
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
        let side = fields.side()?;
        let raster = Raster { kind, big_endian, packing, size, origin, step, content };
        Ok(Header { raster, side })
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

    /// The file that holds the data, and what is before it there.
    fn side(&self) -> Result<Option<(String, Skip)>, ShapeError> {
        let skip = match self.optional("byteskip").map(str::parse::<i64>) {
            None => Skip::Bytes(0),
            Some(Ok(-1)) => Skip::ToData,
            Some(Ok(bytes @ 0..)) => Skip::Bytes(bytes as u64),
            Some(_) => return Err(self.malformed("byteskip", "a number of bytes, or -1")),
        };
        match self.optional("datafile") {
            None if skip == Skip::Bytes(0) => Ok(None),
            None => Err(self.unsupported("byteskip", "save the file without it")),
            Some(file) if file.starts_with("LIST") || file.contains('%') => {
                Err(self.unsupported("datafile", "join its files (`unu save -f nrrd -i in.nhdr -o out.nrrd`)"))
            }
            Some(file) => Ok(Some((file.into(), skip))),
        }
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

    fn kind(&self) -> Result<Type, ShapeError> {
        let name = self.required("type", "a `type` field")?.to_ascii_lowercase();
        let known = NAMES.iter().find(|(_, names)| names.contains(&name.as_str()));
        let remedy = "convert it to an integer type of at most 32 bits, float or double (`unu convert -t float`)";
        known.map(|(kind, _)| *kind).ok_or_else(|| self.unsupported("type", remedy))
    }

    /// `sizes`, checked against [`MAX_VOXELS`].
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
        let voxels = size.iter().try_fold(1_u64, |product, &n| product.checked_mul(n));
        if voxels.is_none_or(|voxels| voxels > MAX_VOXELS) {
            let found = size.map(|n| n.to_string()).join(" x ");
            return Err(ShapeError::TooLarge { file: self.file.clone(), what: "voxels", found, limit: MAX_VOXELS });
        }
        Ok(size.map(|n| n as u32)) // each is at most the product
    }

    /// World position of the first sample and the step to the next on each axis, possibly negative.
    fn placement(&self) -> Result<(DVec3, DVec3), ShapeError> {
        let directed = self.optional("spacedirections").is_some();
        let step = match (directed, self.optional("spacings").is_some()) {
            (true, true) => return Err(self.malformed("spacings", "`spacings` or `space directions`, not both")),
            (true, false) => self.directions()?,
            (false, true) => self.three("spacings", "3 numbers")?,
            (false, false) if self.optional("axismaxs").is_some() => {
                return Err(self.unsupported("axismaxs", "write `spacings` instead"));
            }
            (false, false) => DVec3::ONE,
        };
        let name = if directed { "spacedirections" } else { "spacings" };
        // What f32 cannot hold as a normal number is no distance between samples.
        let tiny = DVec3::splat(f64::from(f32::MIN_POSITIVE));
        if !(step.abs().cmpge(tiny) & step.abs().cmple(DVec3::splat(f64::from(MAX_COORDINATE)))).all() {
            return Err(self.malformed(name, "steps between samples from 1.2e-38 to 1e18"));
        }
        if self.optional("spaceorigin").is_some() {
            let origin = self.vectors("spaceorigin")?;
            let [origin] = origin[..] else { return Err(self.malformed("spaceorigin", "one vector, as (0,0,0)")) };
            return Ok((origin, step));
        }
        if self.optional("axismins").is_none() {
            return Ok((DVec3::ZERO, step));
        }
        // The axis begins at the first sample, or half a step before it where samples stand for cells.
        let centers: Vec<&str> = self.optional("centers").unwrap_or_default().split_whitespace().collect();
        let cell = |axis: usize| centers.get(axis).is_some_and(|&center| center == "cell");
        let half = DVec3::from([0, 1, 2].map(|axis| if cell(axis) { 0.5 } else { 0.0 }));
        Ok((self.three("axismins", "3 numbers")? + half * step, step))
    }

    /// `space directions` that lie along the axes.
    fn directions(&self) -> Result<DVec3, ShapeError> {
        let directions = self.vectors("spacedirections")?;
        let [x, y, z] = directions[..] else {
            return Err(self.malformed("spacedirections", "3 vectors, as (1,0,0) (0,1,0) (0,0,1)"));
        };
        let step = DVec3::new(x.x, y.y, z.z);
        let aligned = [x, y, z] == [DVec3::X * step, DVec3::Y * step, DVec3::Z * step];
        let remedy =
            "the axes must not be oblique or exchanged: resample onto the axes (`unu axdelete`, `unu permute`)";
        if aligned { Ok(step) } else { Err(self.unsupported("spacedirections", remedy)) }
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
