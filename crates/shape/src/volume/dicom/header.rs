//! Header of a DICOM file.
//!
//! Role: the preamble, and the transfer syntax of the rest of the file. Source: NEMA PS3.10, 7, and PS3.5, annex A.

use super::elements::{Elements, Syntax, shown};
use super::frames::PixelEncoding;
use crate::error::{Location, ShapeError, quoted};
use crate::source::Source;

/// Unsupported part, its value, and the remedy.
pub(super) type Refusal = (&'static str, String, &'static str);

/// Offset and bytes of the prefix of a file.
pub(super) const MARK_AT: usize = 128;
pub(super) const MARK: &[u8] = b"DICM";
/// Encoding of the header.
const EXPLICIT: Syntax = Syntax { is_implicit: false, big_endian: false };
/// Class of a DICOMDIR.
const DIRECTORY: &str = "1.2.840.10008.1.3.10";
/// Transfer syntax of a deflated file.
const DEFLATED: &str = "1.2.840.10008.1.2.1.99";
/// Noun for messages.
const HEADER: &str = "a DICOM header";

pub(super) struct DicomHeader {
    pub syntax: Syntax,
    pub encoding: PixelEncoding,
    /// Whether the rest of the file is deflated.
    pub is_deflated: bool,
    /// Reason why the pixels are not supported.
    pub refused: Option<Refusal>,
}

impl DicomHeader {
    /// Reads up to the data set.
    pub fn read(source: &mut Source) -> Result<DicomHeader, ShapeError> {
        let start: [u8; MARK_AT + 4] = source.array(HEADER)?;
        if &start[MARK_AT..] != MARK {
            let (place, remedy) =
                (Location::Byte(MARK_AT as u64), "rewrite it with `dcmconv` of DCMTK, which adds a header");
            return Err(source.unsupported(place, "a DICOM file", "without the mark `DICM`", remedy));
        }
        let mut elements = Elements::new(source, EXPLICIT);
        let (mut end, mut syntax, mut is_directory) = (None, None, false);
        while end.is_none_or(|end| elements.source.offset < end) {
            let place = Location::Byte(elements.source.offset);
            let Some(head) = elements.next()? else { break };
            match head.tag {
                0x0002_0000 if head.length == 4 => {
                    let length = u32::from_le_bytes(elements.source.array(HEADER)?);
                    end = Some(elements.source.offset + u64::from(length));
                }
                0x0002_0002 => is_directory = elements.text(&head)? == DIRECTORY,
                0x0002_0010 => syntax = Some(elements.text(&head)?),
                tag if tag >> 16 == 2 && end.is_some() => elements.skip(&head)?,
                tag => {
                    let expected = "a header that begins with its length (0002,0000)";
                    return Err(source.malformed_at(place, expected, shown(tag)));
                }
            }
        }
        let Some(syntax) = syntax else {
            return Err(source.malformed_at(Location::Header, "a transfer syntax (0002,0010)", "none".into()));
        };
        let plain = |is_implicit, big_endian| (Syntax { is_implicit, big_endian }, PixelEncoding::Plain, None);
        let packed = |encoding| (EXPLICIT, encoding, None);
        let is_deflated = syntax == DEFLATED;
        let (syntax, encoding, refused) = match &*syntax {
            "1.2.840.10008.1.2" => plain(true, false),
            "1.2.840.10008.1.2.1" | DEFLATED => plain(false, false),
            "1.2.840.10008.1.2.2" => plain(false, true),
            "1.2.840.10008.1.2.5" => packed(PixelEncoding::Rle),
            "1.2.840.10008.1.2.4.50" | "1.2.840.10008.1.2.4.51" => packed(PixelEncoding::LossyJpeg),
            "1.2.840.10008.1.2.4.57" | "1.2.840.10008.1.2.4.70" => packed(PixelEncoding::LosslessJpeg),
            other => (EXPLICIT, PixelEncoding::Plain, Some(compressed(other))),
        };
        let remedy = "it only names files: open the folder that the slices are in, or one of them";
        let refused = if is_directory { Some(("the", "DICOMDIR".into(), remedy)) } else { refused };
        Ok(DicomHeader { syntax, encoding, is_deflated, refused })
    }
}

/// Reason why a transfer syntax is not supported.
fn compressed(syntax: &str) -> Refusal {
    let number = syntax.strip_prefix("1.2.840.10008.1.2.").unwrap_or_default();
    let name = match number {
        "4.80" | "4.81" => "JPEG-LS",
        "4.90" | "4.91" | "4.92" | "4.93" => "JPEG 2000",
        "4.201" | "4.202" | "4.203" => "HTJ2K",
        _ if number.starts_with("4.10") => "MPEG",
        _ => "unknown",
    };
    let found = format!("{name} ({})", quoted(syntax.as_bytes()));
    let remedy = "unpack it with `gdcmconv --raw`, or `dcmdjpls` or `dcmconv +te` of DCMTK";
    ("the transfer syntax", found, remedy)
}
