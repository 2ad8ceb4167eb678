//! Header of an OpenVDB file.

use super::values::{KNOWN_FLAGS, NODE_MASKS, ZIP};
use crate::error::{Location, ShapeError, quoted};
use crate::source::Source;
use std::ops::RangeInclusive;

pub(crate) const MAGIC: &[u8] = b" BDV\0\0\0\0";
/// Supported versions: 220 added compression flags, 225 further types of grids.
const VERSIONS: RangeInclusive<u32> = 220..=225;
/// Written version, of OpenVDB 6.2 and later.
pub(crate) const WRITTEN: u32 = 224;
/// Whether the file begins with the magic number.
pub(crate) fn recognizes(start: &[u8], _len: u64) -> bool {
    start.starts_with(MAGIC)
}

pub(super) struct FileHeader {
    pub version: u32,
    /// Whether the offsets of grids are stored.
    pub has_offsets: bool,
    /// Whether the whole file is compressed.
    is_zip: bool,
}

impl FileHeader {
    pub fn read(source: &mut Source) -> Result<FileHeader, ShapeError> {
        const WHAT: &str = "a VDB header";
        let magic: [u8; 8] = source.array(WHAT)?;
        if magic != MAGIC {
            return Err(source.malformed_at(Location::Byte(0), "` BDV`, the mark of OpenVDB", quoted(&magic)));
        }
        let version = source.u32(WHAT)?;
        if !VERSIONS.contains(&version) {
            let remedy = "versions 220 to 225 are read: save it again with OpenVDB 3 to 13";
            return Err(source.unsupported(Location::Byte(8), "version", version.to_string(), remedy));
        }
        source.skip(8, WHAT)?; // version of the library
        let has_offsets = source.array(WHAT)? != [0];
        let is_zip = version < NODE_MASKS && source.array(WHAT)? != [0];
        source.skip(36, WHAT)?; // an identifier
        Ok(FileHeader { version, has_offsets, is_zip })
    }

    /// Compression flags of a grid.
    pub fn flags(&self, source: &mut Source) -> Result<u32, ShapeError> {
        if self.version < NODE_MASKS {
            return Ok(if self.is_zip { ZIP } else { 0 });
        }
        let place = Location::Byte(source.offset);
        let flags = source.u32("the compression of a grid")?;
        if flags & !KNOWN_FLAGS == 0 {
            return Ok(flags);
        }
        let remedy = "none, zip, active mask and Blosc are read (0 to 7)";
        Err(source.unsupported(place, "compression", flags.to_string(), remedy))
    }
}
