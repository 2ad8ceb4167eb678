//! A DICOM file around its image.
//!
//! Role: the mark, the header that says how the rest is written, and the rest as if it were not deflated. Invariant: one of
//! the four ways that leave pixels as they are, or a name for the other one. Source: NEMA PS3.10, 7, and PS3.5, annex A.

use super::super::error::{Location, ShapeError, quoted};
use super::super::source::Source;
use super::elements::{Elements, Syntax, shown};
use super::image::Image;
use flate2::bufread::DeflateDecoder;
use std::io::BufReader;

/// Where the mark of a file is, and the mark.
pub(super) const MARK_AT: usize = 128;
pub(super) const MARK: &[u8] = b"DICM";
/// Most bytes that one byte of deflate can become.
const MAX_DEFLATE_RATIO: u64 = 1032;
/// What is read here, for messages.
const HEADER: &str = "a DICOM header";

/// How a file is written.
#[derive(PartialEq)]
enum Packing {
    Plain(Syntax),
    Deflated,
    /// The pixels are compressed, and how.
    Compressed(String),
}

/// How elements are written where nothing else is said.
const EXPLICIT: Syntax = Syntax { is_implicit: false, big_endian: false };

/// Reads what a file says of its image and calls `then`, the pixels being next in the source.
pub(super) fn with_image<T>(
    source: &mut Source,
    then: impl FnOnce(&mut Source, Image) -> Result<T, ShapeError>,
) -> Result<T, ShapeError> {
    let (syntax, compression) = match packing(source)? {
        Packing::Plain(syntax) => (syntax, None),
        Packing::Compressed(name) => (EXPLICIT, Some(name)),
        Packing::Deflated => {
            return inflated(source, |source| {
                let image = Image::read(source, EXPLICIT, None)?;
                then(source, image)
            });
        }
    };
    let image = Image::read(source, syntax, compression)?;
    then(source, image)
}

/// Calls `read` with what is left of a source, no longer deflated.
fn inflated<T>(source: &mut Source, read: impl FnOnce(&mut Source) -> Result<T, ShapeError>) -> Result<T, ShapeError> {
    let (offset, file) = (source.offset, source.file.clone());
    let len = source.remaining().saturating_mul(MAX_DEFLATE_RATIO);
    let mut reader = BufReader::new(DeflateDecoder::new(&mut *source.reader));
    let mut inflated = Source { file, len, offset: 0, line: 0, folder: None, reader: &mut reader };
    let read = read(&mut inflated);
    let decoded = inflated.offset;
    read.map_err(|error| match error {
        ShapeError::Unreadable { file, reason } => ShapeError::Packed { file, offset, decoded, reason },
        other => other,
    })
}

/// Reads up to the data set; how that is written.
fn packing(source: &mut Source) -> Result<Packing, ShapeError> {
    let start: [u8; MARK_AT + 4] = source.array(HEADER)?;
    if &start[MARK_AT..] != MARK {
        let (file, place) = (source.file.clone(), Location::Byte(MARK_AT as u64));
        let (found, remedy) =
            ("without the mark `DICM`".into(), "rewrite it with `dcmconv` of DCMTK, which adds a header");
        return Err(ShapeError::Unsupported { file, place, what: "a DICOM file", found, remedy });
    }
    let mut elements = Elements::new(source, EXPLICIT);
    let (mut end, mut syntax) = (None, None);
    while end.is_none_or(|end| elements.source.offset < end) {
        let place = Location::Byte(elements.source.offset);
        let Some(head) = elements.next()? else { break };
        match head.tag {
            0x0002_0000 if head.length == 4 => {
                let length = u32::from_le_bytes(elements.source.array(HEADER)?);
                end = Some(elements.source.offset + u64::from(length));
            }
            0x0002_0010 => syntax = Some(elements.text(&head)?),
            tag if tag >> 16 == 2 && end.is_some() => elements.skip(&head)?,
            tag => {
                let expected = "a header that begins with its length (0002,0000)";
                return Err(source.malformed_at(place, expected, shown(tag)));
            }
        }
    }
    let plain = |is_implicit, big_endian| Packing::Plain(Syntax { is_implicit, big_endian });
    match syntax.as_deref() {
        Some("1.2.840.10008.1.2") => Ok(plain(true, false)),
        Some("1.2.840.10008.1.2.1") => Ok(plain(false, false)),
        Some("1.2.840.10008.1.2.2") => Ok(plain(false, true)),
        Some("1.2.840.10008.1.2.1.99") => Ok(Packing::Deflated),
        Some(syntax) => Ok(Packing::Compressed(compression(syntax))),
        None => Err(source.malformed_at(Location::Header, "a transfer syntax (0002,0010)", "none".into())),
    }
}

/// A transfer syntax for a message.
fn compression(syntax: &str) -> String {
    let number = syntax.strip_prefix("1.2.840.10008.1.2.").unwrap_or_default();
    let name = match number {
        "4.50" | "4.51" | "4.57" | "4.70" => "JPEG",
        "4.80" | "4.81" => "JPEG-LS",
        "4.90" | "4.91" | "4.92" | "4.93" => "JPEG 2000",
        "4.201" | "4.202" | "4.203" => "HTJ2K",
        "5" => "RLE",
        _ if number.starts_with("4.10") => "MPEG",
        _ => return quoted(syntax.as_bytes()),
    };
    format!("{name} ({syntax})")
}
