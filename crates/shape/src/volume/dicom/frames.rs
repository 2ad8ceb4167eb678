//! Decompression of frames.
//!
//! Role: fragments of encapsulated pixel data as the bytes of a frame, in little endian. Invariant: the size of a frame is known
//! before it is decompressed. Sources: NEMA PS3.5, annexes A.4 and G; ITU-T T.81 for the checks of JPEG.

use super::elements::{ITEM, SEQUENCE_END, shown};
use crate::error::{Location, ShapeError};
use crate::source::Source;
use jpeg_decoder::{Decoder, PixelFormat};
use std::io;

/// Encoding of the pixels of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum PixelEncoding {
    #[default]
    Plain,
    Rle,
    LosslessJpeg,
    LossyJpeg,
}

/// Highest expansion of run lengths: 128 bytes for 2.
const MAX_RLE_RATIO: u64 = 64;
/// Highest expansion of JPEG: a block of 64 pixels takes 2 bits at least.
const MAX_JPEG_RATIO: u64 = 256;
/// Header of run lengths: the number of segments and their offsets.
const RLE_HEADER: usize = 64;
/// JPEG markers: start of a lossless frame, restart interval, start of scan.
const LOSSLESS: u8 = 0xc3;
const RESTARTS: u8 = 0xdd;
const SCAN: u8 = 0xda;

/// Error of a frame.
pub(super) enum Fault {
    /// Damaged, or of the wrong size.
    Damaged(String),
    /// Valid, but not supported.
    Unsupported(String),
}

impl PixelEncoding {
    /// Highest expansion.
    pub(crate) fn max_ratio(self) -> u64 {
        match self {
            PixelEncoding::Plain => 1,
            PixelEncoding::Rle => MAX_RLE_RATIO,
            PixelEncoding::LosslessJpeg | PixelEncoding::LossyJpeg => MAX_JPEG_RATIO,
        }
    }

    /// Decompresses a frame of `columns` x `rows` pixels of `width` bytes.
    fn unpacked(self, packed: &[u8], [columns, rows]: [u16; 2], width: usize) -> Result<Vec<u8>, Fault> {
        let pixels = usize::from(columns) * usize::from(rows);
        match self {
            PixelEncoding::Plain => Ok(packed.to_vec()),
            PixelEncoding::Rle => runs(packed, pixels, width),
            PixelEncoding::LosslessJpeg | PixelEncoding::LossyJpeg => jpeg(packed, [columns, rows], width),
        }
    }
}

/// Reader of the fragments of a file.
pub(super) struct Fragments {
    /// Offsets of the first fragments of the frames, if the table is not empty.
    starts: Vec<u32>,
    /// Offset of the first fragment.
    first: u64,
    /// Offset and length of the next fragment, if its header has been read; the length is `None` at the end.
    next: Option<(u64, Option<u32>)>,
    frames: usize,
}

impl Fragments {
    /// Reads the offset table of `frames` frames.
    pub fn read(source: &mut Source, frames: usize) -> Result<Fragments, ShapeError> {
        let place = Location::Byte(source.offset);
        let (_, Some(length)) = head(source)? else {
            return Err(source.malformed_at(place, "a table of frames before packed pixels", "no item".into()));
        };
        if length != 0 && u64::from(length) != 4 * frames as u64 {
            let found = format!("{length} bytes for {frames} frames");
            return Err(source.malformed_at(place, "a table of frames with 4 bytes for each", found));
        }
        let table = source.block(u64::from(length), "a table of frames")?;
        let starts = table.as_chunks().0.iter().map(|&start| u32::from_le_bytes(start)).collect();
        Ok(Fragments { starts, first: source.offset, next: None, frames })
    }

    /// Decompresses the next frame, that of `index`.
    pub fn frame(
        &mut self,
        source: &mut Source,
        index: usize,
        encoding: PixelEncoding,
        sides: [u16; 2],
        width: usize,
    ) -> Result<Vec<u8>, ShapeError> {
        let mut packed = Vec::new();
        let offset = source.offset;
        loop {
            let (at, length) = match self.next.take() {
                Some(next) => next,
                None => head(source)?,
            };
            let is_next = match (self.starts.get(index + 1), packed.is_empty()) {
                (_, true) => false,
                (Some(start), _) => at - self.first >= u64::from(*start),
                (None, _) => self.starts.is_empty() && self.frames > 1,
            };
            match length {
                Some(length) if !is_next => packed.extend(source.block(u64::from(length), "packed pixels")?),
                _ => {
                    self.next = Some((at, length));
                    break;
                }
            }
        }
        if index + 1 == self.frames && self.next.is_some_and(|(_, length)| length.is_some()) {
            let expected = "one fragment of packed pixels for each frame, or a table of frames";
            return Err(source.malformed_here(expected, "more".into()));
        }
        encoding.unpacked(&packed, sides, width).map_err(|fault| match fault {
            Fault::Damaged(what) => source.packed(offset, 0, io::Error::other(what)),
            Fault::Unsupported(found) => {
                let remedy = "unpack it with `gdcmconv --raw`, or `dcmdjpeg` of DCMTK";
                source.unsupported(Location::Byte(offset), "JPEG with", found, remedy)
            }
        })
    }
}

/// Offset and length of the next item; the length is `None` at the end of the sequence.
fn head(source: &mut Source) -> Result<(u64, Option<u32>), ShapeError> {
    let at = source.offset;
    let [a, b, c, d, length @ ..] = source.array::<8>("packed pixels")?;
    let tag = u32::from(u16::from_le_bytes([a, b])) << 16 | u32::from(u16::from_le_bytes([c, d]));
    match tag {
        ITEM => Ok((at, Some(u32::from_le_bytes(length)))),
        SEQUENCE_END => Ok((at, None)),
        tag => Err(source.malformed_at(Location::Byte(at), "items of packed pixels and their end", shown(tag))),
    }
}

/// Decompresses run lengths: one segment per byte of a pixel, the highest first.
fn runs(packed: &[u8], pixels: usize, width: usize) -> Result<Vec<u8>, Fault> {
    let damaged = |what: &str| Fault::Damaged(what.into());
    let header: Vec<usize> =
        packed.as_chunks().0.iter().take(RLE_HEADER / 4).map(|&number| u32::from_le_bytes(number) as usize).collect();
    let [count, starts @ ..] = &header[..] else { return Err(damaged("no header of RLE")) };
    if *count != width || starts.len() < width {
        return Err(Fault::Damaged(format!("{count} segments of RLE for pixels of {width} bytes")));
    }
    let mut bytes = vec![0; pixels * width];
    for (plane, start) in starts[..width].iter().enumerate() {
        let mut rest = packed.get(*start.max(&RLE_HEADER)..).unwrap_or_default();
        let mut filled = 0;
        while filled < pixels {
            let short = || damaged("its runs end too early");
            let (&code, behind) = rest.split_first().ok_or_else(short)?;
            let (run, copies) = match code {
                0..128 => (usize::from(code) + 1, 1),
                128 => (0, 0), // no operation
                _ => (1, 257 - usize::from(code)),
            };
            let (run, behind) = behind.split_at_checked(run).ok_or_else(short)?;
            rest = behind;
            for byte in run.iter().cycle().take(run.len() * copies) {
                let place = filled * width + width - 1 - plane;
                *bytes.get_mut(place).ok_or_else(|| damaged("its runs are too long"))? = *byte;
                filled += 1;
            }
        }
    }
    Ok(bytes)
}

/// Decompresses a grayscale JPEG.
fn jpeg(packed: &[u8], sides: [u16; 2], width: usize) -> Result<Vec<u8>, Fault> {
    let fault = |error| match error {
        jpeg_decoder::Error::Unsupported(feature) => Fault::Unsupported(format!("{feature:?}")),
        jpeg_decoder::Error::Format(what) => Fault::Damaged(what),
        _ => Fault::Damaged("its JPEG ends too early".into()),
    };
    if let Some(feature) = beyond_crate(packed) {
        return Err(Fault::Unsupported(feature.into()));
    }
    let pixels = usize::from(sides[0]) * usize::from(sides[1]);
    let mut decoder = Decoder::new(packed);
    decoder.set_max_decoding_buffer_size(2 * pixels);
    decoder.read_info().map_err(fault)?;
    let info = decoder.info().ok_or_else(|| Fault::Damaged("no frame".into()))?;
    if [info.width, info.height] != sides || !matches!(info.pixel_format, PixelFormat::L8 | PixelFormat::L16) {
        let found = format!("{} x {} of {:?}", info.width, info.height, info.pixel_format);
        return Err(Fault::Damaged(format!("it holds {found} for {} x {} grey values", sides[0], sides[1])));
    }
    let found = decoder.decode().map_err(fault)?;
    match (found.len() / pixels.max(1), width) {
        (1, 1) => Ok(found),
        (1, _) => Ok(found.iter().flat_map(|byte| [*byte, 0]).collect()),
        (2, 2) => Ok(found.as_chunks().0.iter().flat_map(|&pair| u16::from_ne_bytes(pair).to_le_bytes()).collect()),
        (found, _) => Err(Fault::Damaged(format!("values of {found} bytes for pixels of {width}"))),
    }
}

/// Feature of lossless JPEG that the crate decodes wrongly without an error.
fn beyond_crate(packed: &[u8]) -> Option<&'static str> {
    let (mut rest, mut is_lossless, mut has_restarts) = (packed.get(2..)?, false, false);
    while let [0xff, marker, high, low, ..] = *rest {
        let length = usize::from(u16::from_be_bytes([high, low]));
        let content = rest.get(4..2 + length)?;
        is_lossless |= marker == LOSSLESS;
        has_restarts |= marker == RESTARTS && content != [0, 0];
        if marker == SCAN {
            let is_shifted = content.last().is_some_and(|last| last & 0xf != 0);
            return match (is_lossless, has_restarts, is_shifted) {
                (true, true, _) => Some("restarts in lossless data"),
                (true, _, true) => Some("a point transform of lossless data"),
                _ => None,
            };
        }
        rest = rest.get(2 + length..)?;
    }
    None
}
