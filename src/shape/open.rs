//! A name or a path into a shape.
//!
//! Role: recognize what a file holds, and hand it to its reader. Invariant: a reader sees the bytes of a regular file of
//! bounded size, and nothing is allocated on the word of a header alone.

use super::error::{quoted, shown};
use super::generated::built_in;
use super::{BUILT_IN, Shape, ShapeError, nrrd, obj, stl};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The largest file that is read: more does not fit beside its field in the memory of most machines.
const MAX_BYTES: u64 = 8 << 30;

/// A file format: how its content begins, if that can be told, how its name ends, and its reader.
struct Format {
    begins: &'static [u8],
    extensions: &'static [&'static str],
    read: fn(&str, Vec<u8>) -> Result<Shape, ShapeError>,
}

/// Every format, in the order in which they are tried.
const FORMATS: [Format; 3] = [
    Format { begins: b"NRRD000", extensions: &["nrrd"], read: nrrd::read },
    Format { begins: b"", extensions: &["stl"], read: stl::read },
    Format { begins: b"", extensions: &["obj"], read: obj::read },
];

/// The extensions of all formats, for messages.
pub(super) fn known_extensions() -> String {
    let all: Vec<String> = FORMATS.iter().flat_map(|format| format.extensions).map(|end| format!(".{end}")).collect();
    all.join(", ")
}

/// Opens a built-in object or a file.
///
/// # Errors
/// The name is unknown, or the file cannot be read: one line with what, where, the value, the limit and the remedy.
pub fn open(name: &str) -> Result<Shape, ShapeError> {
    if let Some(shape) = built_in(name) {
        return Ok(shape);
    }
    let bytes = bytes(name)?;
    let extension = Path::new(name).extension().map(|end| end.to_string_lossy().to_lowercase()).unwrap_or_default();
    let by_content = FORMATS.iter().find(|format| !format.begins.is_empty() && bytes.starts_with(format.begins));
    let by_name = || FORMATS.iter().find(|format| format.extensions.contains(&extension.as_str()));
    match by_content.or_else(by_name) {
        Some(format) => (format.read)(&shown(name), bytes),
        None => Err(ShapeError::UnknownFormat { file: shown(name), start: quoted(&bytes[..bytes.len().min(16)]) }),
    }
}

/// All bytes of a regular file.
fn bytes(name: &str) -> Result<Vec<u8>, ShapeError> {
    let unreadable = |reason| ShapeError::Unreadable { file: shown(name), reason };
    let file = match File::open(name) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Err(missing(name)),
        Err(error) => return Err(unreadable(error)),
    };
    let about = file.metadata().map_err(unreadable)?;
    if !about.is_file() {
        let kind = if about.is_dir() { "a folder" } else { "a device or a pipe" };
        return Err(ShapeError::NotAFile { file: shown(name), kind });
    }
    if about.len() > MAX_BYTES {
        let found = about.len().to_string();
        return Err(ShapeError::TooLarge { file: shown(name), what: "bytes", found, limit: MAX_BYTES });
    }
    let mut bytes = Vec::new();
    file.take(MAX_BYTES).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.is_empty() {
        return Err(ShapeError::Empty { file: shown(name) });
    }
    Ok(bytes)
}

/// A path gets a word about paths, anything else the nearest built-in name.
fn missing(name: &str) -> ShapeError {
    if name.contains(['/', '\\', '.']) {
        return ShapeError::Missing { file: shown(name) };
    }
    let similar = |known: &&str| strsim::damerau_levenshtein(name, known);
    let nearest = BUILT_IN.iter().copied().min_by_key(similar).unwrap_or_default();
    ShapeError::UnknownName { name: shown(name), nearest }
}
