//! Package of a 3MF file: a ZIP archive of XML parts.
//!
//! Invariant: no more is unpacked than a factor of the length of the file; entities of XML are never expanded.

use super::malformed;
use crate::error::{Location, ShapeError, quoted};
use crate::source::Source;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::io::{self, BufRead, BufReader, Cursor, Read};
use zip::ZipArchive;

/// Bytes unpacked from one byte of the file, on average; real models have 3 to 20.
const MAX_RATIO: u64 = 100;
/// Bytes that a small file may unpack to.
const SLACK: u64 = 1 << 20;
/// Most bytes of a tag, or of a text between two.
const MAX_TAG: u64 = 1 << 16;
/// Type of the relationship that names the model.
const MODEL: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
/// The part with the relationships of the package.
const RELATIONSHIPS: &str = "_rels/.rels";

/// An open package.
pub(super) struct Package {
    archive: ZipArchive<Cursor<Vec<u8>>>,
    /// Bytes that may still be unpacked, of `limit`.
    left: u64,
    limit: u64,
}

/// The start or the end of an element of XML.
pub(super) enum Step<'a> {
    Start(Element<'a>),
    End(&'a [u8]),
}

/// The start of an element, with its place.
pub(super) struct Element<'a> {
    tag: &'a BytesStart<'a>,
    part: &'a str,
    byte: u64,
}

impl Package {
    pub fn open(source: &mut Source) -> Result<Package, ShapeError> {
        let limit = source.remaining().saturating_mul(MAX_RATIO) + SLACK;
        let bytes = source.block(source.remaining(), "the package")?;
        let damaged = |error: &dyn std::fmt::Display| {
            source.malformed_at(Location::Header, "a whole ZIP archive", quoted(error.to_string().as_bytes()))
        };
        let archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(&error))?;
        Ok(Package { archive, left: limit, limit })
    }

    /// The part with the model.
    pub fn root(&mut self, source: &Source) -> Result<String, ShapeError> {
        let mut found = None;
        self.each(source, RELATIONSHIPS, &mut |step| {
            if let Step::Start(element) = step
                && element.name() == b"Relationship"
                && element.text(source, "Type")?.as_deref() == Some(MODEL)
            {
                found = element.text(source, "Target")?;
            }
            Ok(())
        })?;
        let target = found.map(|path| name(&path));
        target.ok_or_else(|| malformed(source, (RELATIONSHIPS, 0), "a relationship to the model", "none"))
    }

    /// Calls `on` for the start and the end of each element of a part.
    pub fn each(
        &mut self,
        source: &Source,
        part: &str,
        on: &mut dyn FnMut(Step) -> Result<(), ShapeError>,
    ) -> Result<(), ShapeError> {
        // Names of parts are the same in any case of letters.
        let alike = |name: &str| name.eq_ignore_ascii_case(part);
        let index = self.archive.file_names().position(alike);
        let missing = || malformed(source, (part, 0), "this part of the package", "none");
        let damaged = |byte: u64, error: String| malformed(source, (part, byte), "readable XML", &error);
        let entry = self.archive.by_index(index.ok_or_else(missing)?).map_err(|error| damaged(0, error.to_string()))?;
        let mut xml = Reader::from_reader(Metered { inner: BufReader::new(entry), left: self.left, tag: MAX_TAG });
        let mut buffer = Vec::new();
        let outcome = loop {
            buffer.clear();
            xml.get_mut().tag = MAX_TAG;
            let byte = xml.buffer_position();
            match xml.read_event_into(&mut buffer) {
                Ok(Event::Start(tag)) => on(Step::Start(Element { tag: &tag, part, byte }))?,
                Ok(Event::Empty(tag)) => {
                    on(Step::Start(Element { tag: &tag, part, byte }))?;
                    on(Step::End(tag.local_name().into_inner()))?;
                }
                Ok(Event::End(tag)) => on(Step::End(tag.local_name().into_inner()))?,
                Ok(Event::DocType(_)) => break Err(damaged(byte, "a document type".into())),
                Ok(Event::Eof) => break Ok(()),
                Ok(_) => {}
                Err(_) if xml.get_ref().left == 0 => {
                    break Err(source.too_large("bytes of XML for the size of this file", "more", self.limit));
                }
                Err(error) => break Err(damaged(byte, error.to_string())),
            }
        };
        self.left = xml.get_ref().left;
        outcome
    }
}

impl Element<'_> {
    /// Name without the prefix of its namespace.
    pub fn name(&self) -> &[u8] {
        self.tag.local_name().into_inner()
    }

    /// An error at this element.
    pub fn malformed(&self, source: &Source, expected: &'static str, found: &str) -> ShapeError {
        malformed(source, (self.part, self.byte), expected, found)
    }

    /// The value of an attribute, named without the prefix of its namespace.
    pub fn text(&self, source: &Source, name: &str) -> Result<Option<String>, ShapeError> {
        for attribute in self.tag.attributes() {
            let attribute = attribute.map_err(|error| self.malformed(source, "attributes", &error.to_string()))?;
            if attribute.key.local_name().into_inner() == name.as_bytes() {
                let value = attribute.normalized_value(quick_xml::XmlVersion::Explicit1_0);
                let value =
                    value.map_err(|error| self.malformed(source, "the value of an attribute", &error.to_string()))?;
                return Ok(Some(value.into_owned()));
            }
        }
        Ok(None)
    }

    /// An attribute that is a number.
    pub fn number<T: std::str::FromStr>(&self, source: &Source, name: &'static str) -> Result<Option<T>, ShapeError> {
        let Some(text) = self.text(source, name)? else { return Ok(None) };
        let value = text.trim().parse();
        value.map(Some).map_err(|_| self.malformed(source, "a number", &format!("{name}={text}")))
    }

    /// An attribute that must be there.
    pub fn needed<T: std::str::FromStr>(&self, source: &Source, name: &'static str) -> Result<T, ShapeError> {
        let missing = || {
            let own = String::from_utf8_lossy(self.name());
            self.malformed(source, "each attribute that the element needs", &format!("{own} without {name}"))
        };
        self.number(source, name)?.ok_or_else(missing)
    }
}

/// The name of a part in the archive: without the root.
pub(super) fn name(path: &str) -> String {
    path.trim_start_matches('/').into()
}

/// A reader that ends with an error where a limit is reached.
struct Metered<R> {
    inner: BufReader<R>,
    /// Bytes left of the package.
    left: u64,
    /// Bytes left of the tag.
    tag: u64,
}

impl<R: Read> BufRead for Metered<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        match self.left.min(self.tag) {
            0 => Err(io::Error::other("a tag or text above 64 KiB")),
            _ => self.inner.fill_buf(),
        }
    }

    fn consume(&mut self, bytes: usize) {
        self.left = self.left.saturating_sub(bytes as u64);
        self.tag = self.tag.saturating_sub(bytes as u64);
        self.inner.consume(bytes);
    }
}

impl<R: Read> Read for Metered<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let bytes = self.fill_buf()?.read(into)?;
        self.consume(bytes);
        Ok(bytes)
    }
}
