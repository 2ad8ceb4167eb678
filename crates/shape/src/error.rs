//! Errors of opening and reading shapes.
//!
//! Invariant: every message is one line with the file, the place if it is known, the value found, the limit, and the remedy.

use crate::built_in::BUILT_IN;
use hypertexture_support::open::OpenError;
use hypertexture_support::words;
use std::{fmt, io};

/// Reason why a name or a file gives no [`Shape`](super::Shape).
///
/// `file` is the path as the caller passed it, with control characters escaped, so that a message stays on one line.
#[allow(missing_docs)] // the messages explain the fields
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// Neither a built-in object nor an existing file; the name does not look like a path.
    #[error("no built-in object and no file is called `{name}`; {}built in: {}; files: {known}",
        nearest.map_or(String::new(), |near| format!("did you mean `{near}`? ")), BUILT_IN.join(", "))]
    UnknownName { name: String, nearest: Option<&'static str>, known: String },
    /// Invalid contents of a shape that a program built in memory.
    #[error("a shape in memory: {what}: found {found}, needed {needed}")]
    Contents { what: String, found: String, needed: String },
    /// The object was never in a file.
    #[error("{name}: the object was in the memory of the program that rendered it; set object.input to a file")]
    InMemory { name: String },
    /// The file at this path is missing.
    #[error("{file}: no such file; check the path, or use a built-in object: {}", BUILT_IN.join(", "))]
    Missing { file: String },
    /// A directory, a device or a pipe.
    #[error("{file}: is {kind}, not a file; name the mesh or volume file itself, or a folder with slices of DICOM")]
    NotAFile { file: String, kind: &'static str },
    /// The operating system refused to open or read the file.
    #[error("{file}: cannot be read: {reason}{}", remedy(reason))]
    Unreadable { file: String, reason: io::Error },
    /// The file has no bytes.
    #[error("{file}: is empty (0 bytes); export or copy it again")]
    Empty { file: String },
    /// Neither the content nor the extension belongs to a known format.
    #[error("{file}: not a known format, it begins with {start}; known files: {known}")]
    UnknownFormat { file: String, start: String, known: String },
    /// The file breaks the rules of its format.
    #[error("{file}: {place}: expected {expected}, found {found}; correct it there or export the file again")]
    Malformed { file: String, place: Location, expected: &'static str, found: String },
    /// The file is valid, but uses an unsupported part of its format.
    #[error("{file}: {place}: {what} {found} is not supported; {remedy}")]
    Unsupported { file: String, place: Location, what: &'static str, found: String, remedy: &'static str },
    /// A face names a missing vertex. `index` is as written, `count` vertices are defined above.
    #[error("{file}: line {line}: vertex index {index} is out of range, {}; export the mesh again", defined(*count))]
    IndexOutOfRange { file: String, line: u64, index: i64, count: usize },
    /// The header and the length of the data do not agree: truncated, or wrong sizes.
    #[error(
        "{file}: byte {offset}: the header declares {declared} bytes of data ({what}), the file holds {found}; \
        copy or export it again"
    )]
    DataSize { file: String, offset: u64, declared: u64, what: String, found: Found },
    /// More than this program accepts from any file.
    #[error(
        "{file}: {found} {what}, the limit is {limit}; reduce it (decimate the mesh, or crop or resample the volume)"
    )]
    TooLarge { file: String, what: &'static str, found: String, limit: u64 },
    /// A file of raw values without a layout; `guess` is a likely layout, or empty.
    #[error(
        "{file}: {bytes} bytes of raw values without a layout{guess}; \
        `hypertexture convert` reads it with --dims X,Y,Z --type uint16 (uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32 or float64)"
    )]
    NoLayout { file: String, bytes: u64, guess: String },
    /// A volume with no samples along some axis.
    #[error("{file}: line {line}: a volume of {} x {} x {} has no samples, every size must be at least 1; \
        export it again", size[0], size[1], size[2])]
    ZeroSize { file: String, line: u64, size: [u64; 3] },
    /// The file does not have the requested grid.
    #[error("{file}: no grid is called {name}; it has {known}")]
    NoGrid { file: String, name: String, known: String },
    /// NaN or infinite coordinates or voxels; `first` is the index of the first one.
    #[error(
        "{file}: {count} of {total} {what} are NaN, infinite or beyond 32-bit floats, the first has index {first} \
        (from 0); remove or replace them"
    )]
    NotFinite { file: String, what: &'static str, count: usize, total: usize, first: usize },
    /// A coordinate so large that squared distances would overflow.
    #[error("{file}: {what} {index} (from 0) reaches {value:e}, the limit is {limit:e}; scale the object down")]
    CoordinateRange { file: String, what: &'static str, index: usize, value: f32, limit: f32 },
    /// A mesh without a triangle of nonzero area; `holds` describes its contents.
    #[error("{file}: no triangles ({holds}); a mesh needs at least 1 face, export it again")]
    NoTriangles { file: String, holds: String },
    /// Damaged compressed data, which begins at byte `offset`.
    #[error(
        "{file}: byte {offset}: compressed data damaged after {decoded} good bytes: {reason}; copy or export it again"
    )]
    Decompression { file: String, offset: u64, decoded: u64, reason: io::Error },
    /// The system did not give the memory for the values.
    #[error("{file}: no memory for {bytes} bytes of values; crop or resample the volume, or free memory")]
    OutOfMemory { file: String, bytes: u64 },
}

impl ShapeError {
    /// [`ShapeError::Unsupported`] of a file.
    pub(super) fn unsupported(
        file: &str,
        place: Location,
        what: &'static str,
        found: impl Into<String>,
        remedy: &'static str,
    ) -> ShapeError {
        ShapeError::Unsupported { file: file.into(), place, what, found: found.into(), remedy }
    }

    /// Replaces a place that is only "header" by a more exact one.
    pub(super) fn placed(mut self, at: Location) -> ShapeError {
        if let ShapeError::Malformed { place: place @ Location::Header, .. }
        | ShapeError::Unsupported { place: place @ Location::Header, .. } = &mut self
        {
            *place = at;
        }
        self
    }
}

/// Place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Location {
    /// A line of text, from 1.
    Line(u64),
    /// The header as a whole: a part is missing.
    Header,
    /// The files of a folder.
    Folder,
    /// The layout given for a raw file.
    Layout,
    /// A byte, from 0.
    Byte(u64),
    /// A face or strip of a mesh, from 0.
    Face(u64),
    /// A material of a mesh, in backquotes.
    Material(String),
    /// A path in JSON, as `accessors[3].count`.
    Json(String),
    /// A part of a 3MF package, and a byte in it from 0.
    Part(String, u64),
}

/// Length of the data in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// Exactly this many.
    Bytes(u64),
    /// More than declared.
    More,
    /// Upper bound of the length after decompression.
    AtMost(u64),
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Location::Line(line) => write!(f, "line {line}"),
            Location::Header => write!(f, "header"),
            Location::Folder => write!(f, "folder"),
            Location::Layout => write!(f, "layout"),
            Location::Byte(byte) => write!(f, "byte {byte}"),
            Location::Face(face) => write!(f, "face {face} (from 0)"),
            Location::Material(name) => write!(f, "material {name}"),
            Location::Json(path) => write!(f, "{path}"),
            Location::Part(part, byte) => write!(f, "{}, byte {byte}", words::line(part)),
        }
    }
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Found::Bytes(bytes) => write!(f, "{bytes}"),
            Found::More => write!(f, "more"),
            Found::AtMost(bytes) => write!(f, "at most {bytes} once decompressed"),
        }
    }
}

/// Range of valid vertex indices.
fn defined(count: usize) -> String {
    match count {
        0 => "no vertices are defined above this line: they come before the faces".into(),
        _ => {
            format!("{count} vertices are defined above this line (1 to {count}, or -{count} to -1 counted backwards)")
        }
    }
}

/// Remedy for an error of the operating system; other errors name their own.
fn remedy(reason: &io::Error) -> &'static str {
    if reason.kind() == io::ErrorKind::Other { "" } else { "; check its permissions and the disk it is on" }
}

/// `bytes` in backquotes, on one line: control characters escaped, cut after 40 characters.
pub(super) fn quoted(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(160)]);
    let mut shown: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    if text.chars().nth(40).is_some() {
        shown.push_str("...");
    }
    format!("`{shown}`")
}

/// The first four names, for a message.
pub(super) fn first_few(names: &[impl AsRef<str>], separator: &str) -> String {
    let mut shown: Vec<&str> = names.iter().take(4).map(AsRef::as_ref).collect();
    shown.extend((names.len() > 4).then_some("..."));
    shown.join(separator)
}

/// A file name for a message, never cut.
pub(super) fn shown(name: &str) -> String {
    words::line(name).into_owned()
}

/// Error of a file that cannot be opened.
pub(super) fn unreadable(file: String, error: OpenError) -> ShapeError {
    match error {
        OpenError::Missing => ShapeError::Missing { file },
        OpenError::NotAFile(kind) => ShapeError::NotAFile { file, kind },
        OpenError::Denied => ShapeError::Unreadable { file, reason: io::ErrorKind::PermissionDenied.into() },
        other => ShapeError::Unreadable { file, reason: other.into() },
    }
}
