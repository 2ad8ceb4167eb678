//! Input of a format reader.
//!
//! Role: lines and blocks with their place in the file, and checks shared by all formats. Invariant: no memory is allocated for
//! a count that is only declared.

use crate::error::{Found, Location, ShapeError, quoted, shown, unreadable};
use crate::shape::{MAX_COORDINATE, MAX_TRIANGLES, Mesh, Shape};
use crate::unit::Unit;
use glam::DVec3;
use hypertexture_support::open::{self, Home, MARK, OpenError};
use std::cell::{Cell, RefCell};
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Component, Path, PathBuf};
use std::str::FromStr;

/// Longest line in bytes, with its end.
pub(super) const MAX_LINE: usize = 1 << 20;
/// Longest relative path of a data file, in bytes.
const MAX_NAME: usize = 1024;
/// Longest file or folder name, in bytes.
const MAX_PART: usize = 255;

/// An open file, or a file in memory.
pub(super) struct Source<'a> {
    /// Name for messages.
    pub file: String,
    /// Length in bytes.
    pub len: u64,
    /// Bytes consumed so far.
    pub offset: u64,
    /// Lines consumed so far by `Source::next_line`.
    pub line: u64,
    /// Line terminator, detected in the first line.
    end: u8,
    /// Folder of the file; `None` for a file in memory.
    pub folder: Option<PathBuf>,
    /// Requested grid of an OpenVDB file.
    pub grid: Option<String>,
    /// Whether colors and textures of materials are asked for.
    pub is_painted: bool,
    /// Names and types of the grids of an OpenVDB file.
    pub grids: Vec<String>,
    /// Names of the objects of a 3MF file.
    pub names: Vec<String>,
    /// Unit of the coordinates, if the file or its format has one.
    pub unit: Cell<Option<Unit>>,
    /// Notes for the user, see [`Source::note`].
    pub notes: RefCell<Vec<String>>,
    /// Other files of the shape.
    pub others: RefCell<Vec<PathBuf>>,
    pub reader: &'a mut dyn BufRead,
}

impl<'a> Source<'a> {
    pub fn new(file: String, len: u64, folder: Option<PathBuf>, reader: &'a mut dyn BufRead) -> Source<'a> {
        Source {
            file,
            len,
            offset: 0,
            line: 0,
            end: b'\n',
            folder,
            grid: None,
            is_painted: false,
            grids: Vec::new(),
            names: Vec::new(),
            unit: Cell::default(),
            notes: RefCell::default(),
            others: RefCell::default(),
            reader,
        }
    }

    /// Reads a file by its path.
    pub fn with_file<T>(path: &Path, read: impl FnOnce(&mut Source) -> Result<T, ShapeError>) -> Result<T, ShapeError> {
        let file = shown(&path.to_string_lossy());
        let (opened, len) = open::open(path, u64::MAX).map_err(|error| unreadable(file.clone(), error))?;
        read(&mut Source::new(file, len, None, &mut BufReader::new(opened)))
    }

    /// Reads a data file in the folder of this file or below. Links may lead only into that folder or the current one.
    pub fn beside<T>(
        &self,
        name: &str,
        read: impl FnOnce(&mut Source<'_>) -> Result<T, ShapeError>,
    ) -> Result<T, ShapeError> {
        // The system refuses longer names.
        let is_below = name.len() <= MAX_NAME
            && !is_absolute(name)
            && Path::new(name).components().all(|part| match part {
                Component::Normal(part) => part.len() <= MAX_PART,
                part => part == Component::CurDir,
            });
        let folder = self.folder.as_deref().filter(|_| is_below).ok_or_else(|| {
            let (found, remedy) = (quoted(name.as_bytes()), "put the file of the data beside this one");
            self.unsupported(Location::Header, "the data file", found, remedy)
        })?;
        let path = folder.join(name);
        if !Home::of(folder).holds(&path) {
            return Err(Source::link_outside(&self.file, Location::Header, name));
        }
        let file = shown(&path.to_string_lossy());
        let (opened, len) = open::open(&path, u64::MAX).map_err(|error| ShapeError::Unreadable {
            file: format!("{}: its data file {file}", self.file),
            reason: match error {
                OpenError::Missing => io::Error::other("there is no such file; copy it there, or correct its name"),
                other => other.into(),
            },
        })?;
        self.others.borrow_mut().push(path);
        let mut reader = BufReader::new(opened);
        let mut part = Source::new(file, len, None, &mut reader);
        let found = read(&mut part)?;
        self.adopt(&part);
        Ok(found)
    }

    /// The name of a data file as [`Source::beside`] takes it: where it leads out of the folder or to no file, the file of its last
    /// part beside this one, in any case of letters, with a note.
    pub fn found(&self, name: &str) -> String {
        let Some(folder) = &self.folder else { return name.into() };
        let is_elsewhere = is_absolute(name);
        if name.is_empty() || !is_elsewhere && folder.join(name).is_file() {
            return name.into();
        }
        let last = name.rsplit('/').next().unwrap_or(name);
        let alike = || {
            let entries = std::fs::read_dir(if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
            let names = entries.into_iter().flatten().flatten().map(|entry| entry.file_name());
            names.filter_map(|own| own.into_string().ok()).filter(|own| own.eq_ignore_ascii_case(last)).min()
        };
        let own = if folder.join(last).is_file() { Some(last.to_string()) } else { alike() };
        match own.filter(|own| !own.is_empty() && folder.join(own).is_file()) {
            Some(own) => {
                self.note(format!("{} is read from {} beside it", quoted(name.as_bytes()), quoted(own.as_bytes())));
                own
            }
            None => name.into(),
        }
    }

    /// Takes over the notes and files of a part of this source.
    pub(crate) fn adopt(&self, part: &Source) {
        part.notes.take().into_iter().for_each(|note| self.note(note));
        self.others.borrow_mut().append(&mut part.others.borrow_mut());
    }

    /// Records an assumption or omission, once: a short sentence without the name of the file.
    pub fn note(&self, text: String) {
        let mut notes = self.notes.borrow_mut();
        if !notes.contains(&text) {
            notes.push(text);
        }
    }

    /// Notes zero padding after compressed data.
    pub(crate) fn note_padding(&self, zeros: u64) {
        if zeros > 0 {
            self.note(format!("{zeros} zeros after the compressed data are left out"));
        }
    }

    pub fn remaining(&self) -> u64 {
        self.len.saturating_sub(self.offset)
    }

    /// Up to 1024 bytes at the current place without consuming them; fewer only near the end of the file.
    pub fn peek(&mut self) -> Result<&[u8], ShapeError> {
        let unreadable = |reason| ShapeError::Unreadable { file: self.file.clone(), reason };
        self.reader.fill_buf().map(|bytes| &bytes[..bytes.len().min(1024)]).map_err(unreadable)
    }

    /// Skips a byte order mark; returns whether there was one.
    pub(crate) fn skip_mark(&mut self) -> Result<bool, ShapeError> {
        let is_marked = self.peek()?.starts_with(MARK);
        if is_marked {
            self.skip(MARK.len() as u64, "a byte order mark")?;
        }
        Ok(is_marked)
    }

    /// Replaces `line` by the next line without its end (LF, CRLF, or CR if all lines end in CR); `false` at the end of the file.
    /// A line longer than [`MAX_LINE`] is an error: a file without line ends would be read into memory.
    pub(crate) fn next_line(&mut self, line: &mut Vec<u8>) -> Result<bool, ShapeError> {
        line.clear();
        if self.line == 0 {
            // Two CR before the first LF are line ends, a single one is a typo; without any LF each is one.
            let left = self.remaining();
            let start = self.peek()?;
            let first = start.split(|byte| *byte == b'\n').next().unwrap_or_default();
            let is_alone = first.len() as u64 == left;
            let first = if first.len() < start.len() { first.strip_suffix(b"\r").unwrap_or(first) } else { first };
            let count = first.iter().filter(|byte| **byte == b'\r').count();
            self.end = if count > usize::from(!is_alone) { b'\r' } else { b'\n' };
        }
        let read = (&mut *self.reader).take(MAX_LINE as u64 + 1).read_until(self.end, line);
        let bytes = read.map_err(|reason| self.unreadable(reason))?;
        self.offset += bytes as u64;
        self.line += u64::from(bytes > 0);
        if bytes > MAX_LINE {
            return Err(self.malformed("a line of at most 1 MiB", line));
        }
        if line.last() == Some(&self.end) {
            line.pop();
        }
        if line.last() == Some(&b'\r') {
            line.pop();
        }
        Ok(bytes > 0)
    }

    /// Fills `bytes`; the caller has checked the length.
    pub fn fill(&mut self, bytes: &mut [u8]) -> Result<(), ShapeError> {
        self.reader.read_exact(bytes).map_err(|reason| self.unreadable(reason))?;
        self.offset += bytes.len() as u64;
        Ok(())
    }

    /// Next `N` bytes; `what` describes them in the error of a short file.
    pub fn array<const N: usize>(&mut self, what: &str) -> Result<[u8; N], ShapeError> {
        self.expect(N as u64, what)?;
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    /// Next 32-bit integer in little endian.
    pub fn u32(&mut self, what: &str) -> Result<u32, ShapeError> {
        self.array(what).map(u32::from_le_bytes)
    }

    /// Next `bytes` bytes, a declared number: memory is allocated only for bytes present.
    pub fn block(&mut self, bytes: u64, what: &str) -> Result<Vec<u8>, ShapeError> {
        self.expect(bytes, what)?;
        let mut block = Vec::new();
        let read = (&mut *self.reader).take(bytes).read_to_end(&mut block);
        self.consumed(read.map(|read| read as u64), bytes, what)?;
        Ok(block)
    }

    /// Skips `bytes` bytes.
    pub fn skip(&mut self, bytes: u64, what: &str) -> Result<(), ShapeError> {
        self.expect(bytes, what)?;
        let skipped = io::copy(&mut (&mut *self.reader).take(bytes), &mut io::sink());
        self.consumed(skipped, bytes, what)
    }

    /// Checks that `bytes` bytes are left.
    fn expect(&self, bytes: u64, what: &str) -> Result<(), ShapeError> {
        let left = self.remaining();
        if bytes <= left { Ok(()) } else { Err(self.data_size(bytes, what.into(), Found::Bytes(left))) }
    }

    /// Advances by `bytes`; an error if fewer were read.
    fn consumed(&mut self, read: io::Result<u64>, bytes: u64, what: &str) -> Result<(), ShapeError> {
        let read = read.map_err(|reason| self.unreadable(reason))?;
        if read < bytes {
            return Err(self.data_size(bytes, what.into(), Found::Bytes(read)));
        }
        self.offset += bytes;
        Ok(())
    }

    pub fn unreadable(&self, reason: io::Error) -> ShapeError {
        ShapeError::Unreadable { file: self.file.clone(), reason }
    }

    /// Violation of the format in the current line.
    pub fn malformed(&self, expected: &'static str, found: &[u8]) -> ShapeError {
        self.malformed_at(Location::Line(self.line), expected, quoted(found))
    }

    /// Violation of the format at `place`.
    pub(crate) fn malformed_at(&self, place: Location, expected: &'static str, found: String) -> ShapeError {
        ShapeError::Malformed { file: self.file.clone(), place, expected, found }
    }

    /// Violation of the format at the current byte.
    pub(crate) fn malformed_here(&self, expected: &'static str, found: String) -> ShapeError {
        self.malformed_at(Location::Byte(self.offset), expected, found)
    }

    /// End of a text file where the format expects more.
    pub fn ended(&self, expected: &'static str) -> ShapeError {
        self.malformed_at(Location::Line(self.line), expected, "the end of the file".into())
    }

    /// A valid part of the format at `place` that is not supported.
    pub fn unsupported(
        &self,
        place: Location,
        what: &'static str,
        found: impl Into<String>,
        remedy: &'static str,
    ) -> ShapeError {
        ShapeError::unsupported(&self.file, place, what, found, remedy)
    }

    /// More than `limit` of something that is counted.
    pub(crate) fn too_large(&self, what: &'static str, found: impl ToString, limit: u64) -> ShapeError {
        ShapeError::TooLarge { file: self.file.clone(), what, found: found.to_string(), limit }
    }

    /// Compressed data from byte `offset` on that is damaged after `decoded` bytes.
    pub fn packed(&self, offset: u64, decoded: u64, reason: io::Error) -> ShapeError {
        ShapeError::Decompression { file: self.file.clone(), offset, decoded, reason }
    }

    /// The header declares `declared` bytes from here on, which is not the length of the data.
    pub(crate) fn data_size(&self, declared: u64, what: String, found: Found) -> ShapeError {
        ShapeError::DataSize { file: self.file.clone(), offset: self.offset, declared, what, found }
    }

    /// Checks a number of triangles against [`MAX_TRIANGLES`].
    pub(crate) fn check_triangles(&self, triangles: u64) -> Result<(), ShapeError> {
        if triangles <= MAX_TRIANGLES { Ok(()) } else { Err(self.too_large("triangles", triangles, MAX_TRIANGLES)) }
    }

    /// A link in `file` that leads out of the folder.
    pub(crate) fn link_outside(file: &str, place: Location, name: &str) -> ShapeError {
        let remedy = "it leads out of the folder, and out of the current one: put the file itself in its place, \
                  or run this in a folder that has both in it";
        ShapeError::unsupported(file, place, "the link", quoted(name.as_bytes()), remedy)
    }

    /// A cleaned mesh as a shape; an error with what the file `holds` instead if the mesh is empty.
    pub fn finish(&self, (mesh, zero_area): (Mesh, usize), holds: impl Into<String>) -> Result<Shape, ShapeError> {
        if mesh.triangles.is_empty() {
            let holds = if zero_area > 0 { format!("{zero_area} of zero area were dropped") } else { holds.into() };
            return Err(ShapeError::NoTriangles { file: self.file.clone(), holds });
        }
        if zero_area > 0 {
            log::info!("{}: {zero_area} triangles of zero area are dropped", self.file);
        }
        Ok(Shape::Mesh(mesh))
    }
}

/// Checks that coordinates are finite and at most [`MAX_COORDINATE`].
pub(super) fn check_positions(
    file: &str,
    what: &'static str,
    positions: &[impl Copy + Into<DVec3>],
) -> Result<(), ShapeError> {
    let near = || positions.iter().map(|&position| -> DVec3 { position.into() }).map(DVec3::as_vec3);
    if let Some(first) = near().position(|p| !p.is_finite()) {
        let count = near().filter(|p| !p.is_finite()).count();
        return Err(ShapeError::NotFinite { file: file.into(), what, count, total: positions.len(), first });
    }
    let mut sizes = near().map(|p| p.abs().max_element()).enumerate();
    match sizes.find(|(_, size)| *size > MAX_COORDINATE) {
        Some((index, value)) => {
            Err(ShapeError::CoordinateRange { file: file.into(), what, index, value, limit: MAX_COORDINATE })
        }
        None => Ok(()),
    }
}

/// Whether a path with `/` begins at a root, a drive of Windows or an address of files, or leads out of its folder.
pub(super) fn is_absolute(path: &str) -> bool {
    let is_drive = |path: &str| matches!(path.as_bytes(), [letter, b':', ..] if letter.is_ascii_alphabetic());
    path.starts_with('/') || path.starts_with("file:") || is_drive(path) || path.split('/').any(|part| part == "..")
}

/// Parses a token; NaN and infinities pass and are rejected later.
pub(super) fn number<T: FromStr>(token: &[u8]) -> Option<T> {
    std::str::from_utf8(token).ok()?.parse().ok()
}

/// Whitespace-separated tokens.
pub(super) fn tokens(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|token| !token.is_empty())
}

/// Reads until `block` is full or the input ends; returns the number of bytes.
pub(super) fn read_block(reader: &mut dyn Read, block: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < block.len() {
        match reader.read(&mut block[filled..]) {
            Ok(0) => break,
            Ok(bytes) => filled += bytes,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}
