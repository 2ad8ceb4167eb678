//! Deflated DICOM: everything after the header is one deflate stream.
//!
//! Invariant: a file that expands beyond a bound or half of the free memory is refused. Source: NEMA PS3.5, A.5.

use super::header::DicomHeader;
use crate::error::{Location, ShapeError};
use crate::source::Source;
use crate::volume::raster::MAX_DEFLATE_RATIO;
use flate2::bufread::DeflateDecoder;
use hypertexture_support::memory;
use std::io::Read;

/// Most bytes of an inflated file.
const MAX_BYTES: u64 = 1 << 32;

/// Calls `read` with a source from the start of the file on, inflated if it is deflated.
pub(super) fn inflated<T>(
    source: &mut Source,
    read: impl FnOnce(&mut Source) -> Result<T, ShapeError>,
) -> Result<T, ShapeError> {
    let start = source.peek()?.to_vec();
    let mut reader = &start[..];
    // A header that is longer than the start is read, and refused, by `read`.
    let mut inner = Source::new(source.file.clone(), start.len() as u64, None, &mut reader);
    let header = DicomHeader::read(&mut inner).ok().filter(|header| header.is_deflated);
    let end = inner.offset;
    if header.is_none() {
        return read(source);
    }
    let mut bytes = source.block(end, "a DICOM header")?;
    let free = memory::available().map_or(MAX_BYTES, |free| free / 2);
    let most = MAX_BYTES.min(free).min(source.remaining().saturating_mul(MAX_DEFLATE_RATIO));
    let mut inflated = DeflateDecoder::new(&mut *source.reader).take(most + 1);
    let count = inflated.read_to_end(&mut bytes).map_err(|reason| ShapeError::Decompression {
        file: source.file.clone(),
        offset: end,
        decoded: bytes.len() as u64 - end,
        reason,
    })?;
    if count as u64 > most {
        let (found, remedy) = (format!("of more than {most} bytes"), "inflate it with `dcmconv +te` of DCMTK");
        return Err(source.unsupported(Location::Byte(end), "deflated data", found, remedy));
    }
    let mut reader = &bytes[..];
    let mut whole = Source::new(source.file.clone(), bytes.len() as u64, source.folder.clone(), &mut reader);
    let found = read(&mut whole)?;
    source.adopt(&whole);
    Ok(found)
}
