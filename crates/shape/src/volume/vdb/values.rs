//! Values of a node of an OpenVDB tree.
//!
//! Invariant: memory is allocated only for the values of one node, whatever length the file declares. Source: OpenVDB 10,
//! `io/Compression.h`.

use super::blosc::{self, Fault};
use crate::error::{Found, Location, ShapeError};
use crate::sample_type::SampleType;
use crate::source::{Source, read_block};
use flate2::bufread::ZlibDecoder;
use half::f16;
use std::io;

/// Version since which nodes store only some of their values.
pub(super) const NODE_MASKS: u32 = 222;
/// Compression flags of a grid.
pub(crate) const ZIP: u32 = 1;
pub(crate) const ACTIVE_ONLY: u32 = 2;
const BLOSC: u32 = 4;
pub(super) const KNOWN_FLAGS: u32 = ZIP | ACTIVE_ONLY | BLOSC;
/// Node code: all values are stored.
const ALL: u8 = 6;
/// Noun for messages.
const WHAT: &str = "values of a node";

/// Encoding of the values of a grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct ValueEncoding {
    pub version: u32,
    /// F32 or F64.
    pub kind: SampleType,
    /// Whether nodes store 16-bit floats.
    pub is_half: bool,
    /// Bytes of a value outside of nodes: those of the type, or 2.
    pub single: u64,
    /// Compression flags.
    pub flags: u32,
    pub background: f32,
}

/// Whether bit `index` of `mask` is set.
pub(super) fn is_on(mask: &[u8], index: usize) -> bool {
    mask.get(index / 8).is_some_and(|byte| byte >> (index % 8) & 1 == 1)
}

/// Number of set bits.
pub(super) fn count(mask: &[u8]) -> usize {
    mask.iter().map(|byte| byte.count_ones() as usize).sum()
}

impl ValueEncoding {
    /// Reads one value outside of a node.
    pub fn value(&self, source: &mut Source) -> Result<f32, ShapeError> {
        let bytes = source.block(self.single, WHAT)?;
        Ok(match bytes[..] {
            [low, high] => f16::from_le_bytes([low, high]).to_f32(),
            _ => self.kind.value(&bytes, false) as f32,
        })
    }

    /// Reads the values of a node of `places` values with an active mask.
    pub fn values(&self, source: &mut Source, active: &[u8], places: usize) -> Result<Vec<f32>, ShapeError> {
        let place = Location::Byte(source.offset);
        let code = if self.version < NODE_MASKS { ALL } else { source.array::<1>(WHAT)?[0] };
        let (outside, inside) = (self.background, -self.background);
        let inactive = match code {
            0 | ALL => [outside; 2],
            1 | 3 => [inside, outside],
            2 => [self.value(source)?; 2],
            4 => [self.value(source)?, outside],
            5 => [self.value(source)?, self.value(source)?],
            _ => return Err(source.malformed_at(place, "a code of a node from 0 to 6", code.to_string())),
        };
        let is_second = if matches!(code, 3..=5) { source.block(active.len() as u64, WHAT)? } else { Vec::new() };
        if self.flags & ACTIVE_ONLY == 0 || code == ALL {
            return self.stored(source, places);
        }
        let mut stored = self.stored(source, count(active))?.into_iter();
        let value = |index| {
            if is_on(active, index) {
                stored.next().unwrap_or(outside)
            } else {
                inactive[usize::from(is_on(&is_second, index))]
            }
        };
        Ok((0..places).map(value).collect())
    }

    /// Skips values stored plain or in zip.
    pub fn skip(&self, source: &mut Source, places: usize) -> Result<(), ShapeError> {
        ValueEncoding { flags: self.flags & ZIP, ..*self }.stored(source, places).map(drop)
    }

    /// Reads `places` stored values.
    fn stored(&self, source: &mut Source, places: usize) -> Result<Vec<f32>, ShapeError> {
        if self.is_half && self.single != 2 && places == 0 {
            return Ok(Vec::new()); // of floats saved as halfs, the length is left out too
        }
        if self.is_half {
            let bytes = self.data(source, 2 * places)?;
            return Ok(bytes.as_chunks().0.iter().map(|&value| f16::from_le_bytes(value).to_f32()).collect());
        }
        let mut values = Vec::with_capacity(places);
        self.kind.append(&self.data(source, self.kind.bytes() as usize * places)?, false, None, &mut values);
        Ok(values)
    }

    /// Reads `bytes` bytes, decompressed.
    fn data(&self, source: &mut Source, bytes: usize) -> Result<Vec<u8>, ShapeError> {
        if self.flags & (ZIP | BLOSC) == 0 {
            return source.block(bytes as u64, WHAT);
        }
        let place = Location::Byte(source.offset);
        let length = i64::from_le_bytes(source.array(WHAT)?);
        // Compressed data exceeds its values by a header at most; a negative length marks plain values.
        let is_plain = length <= 0;
        if is_plain && length.unsigned_abs() != bytes as u64 || length > 2 * bytes as i64 + 1024 {
            return Err(source.malformed_at(place, "the length of the values of a node", format!("{length} bytes")));
        }
        let (offset, packed) = (source.offset, source.block(length.unsigned_abs(), WHAT)?);
        if is_plain {
            return Ok(packed);
        }
        if self.flags & BLOSC != 0 {
            return blosc::decode(&packed, bytes).map_err(|fault| match fault {
                Fault::Damaged(what) => source.packed(offset, 0, io::Error::other(what)),
                Fault::Unsupported(found) => {
                    let remedy = "save it with the compression of OpenVDB itself (zip, or Blosc with LZ4)";
                    source.unsupported(Location::Byte(offset), "Blosc", found, remedy)
                }
            });
        }
        let mut data = vec![0; bytes + 1]; // one more to detect surplus data
        let found = read_block(&mut ZlibDecoder::new(&packed[..]), &mut data)
            .map_err(|reason| source.packed(offset, 0, reason))?;
        data.truncate(bytes);
        if found == bytes {
            return Ok(data);
        }
        let found = if found > bytes { Found::More } else { Found::Bytes(found as u64) };
        Err(source.data_size(bytes as u64, WHAT.into(), found))
    }
}
