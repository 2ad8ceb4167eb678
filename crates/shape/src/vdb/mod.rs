//! OpenVDB: sparse level sets and fog volumes.
//!
//! Role: a grid of a file that is one of these into a dense [`Volume`](super::Volume), and back. Invariant: nothing is allocated for a box
//! before the nodes that span it have been read. Read here and not by the crate `vdb-rs`, which knows no files before version
//! 224. Source: OpenVDB 10, `io/Archive.cc` and what the parts of this module name.

mod blosc;
mod grids;
mod head;
mod tree;
mod values;
mod write;

use super::error::{Location, ShapeError, quoted};
use super::placement::{self, Placement};
use super::source::Source;
use super::space::Space;
use super::{Content, Shape, axes};
use grids::Grid;
use head::Metadata;
use std::ops::RangeInclusive;
use tree::{Dense, Tree};
use values::{KNOWN_FLAGS, NODE_MASKS, ZIP};
pub(super) use write::write;

/// The first bytes of a file.
const MAGIC: &[u8] = b" BDV\0\0\0\0";
/// The versions that are read: 220 says what is compressed, 225 has further types of grids.
const VERSIONS: RangeInclusive<u32> = 220..=225;
/// The version that is written, of OpenVDB 6.2 and all behind it.
const WRITTEN: u32 = 224;
/// Most voxels of a box: as many for each byte of the file, or 256 MiB. Real level sets have less than a tenth, and two
/// voxels far from each other would take all memory.
const MAX_VOXELS_PER_BYTE: u64 = 1024;
const SMALL: u64 = 1 << 26;

/// Whether the file begins with the magic number.
pub(super) fn recognizes(start: &[u8], _len: u64) -> bool {
    start.starts_with(MAGIC)
}

/// Reads one grid of floats or doubles, see [`grids`]: the box around its active voxels and one voxel more on each side, or the
/// one that was written here, with all values that the tree has there. Values may be halves, masked, zip or Blosc; doubles are
/// rounded to f32.
pub(super) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    let head = header(source)?;
    Metadata::read(source)?;
    grids::read(source, &head)
}

/// What is said before the grids.
struct Head {
    version: u32,
    /// Whether the places of grids are told.
    has_offsets: bool,
    /// Whether all of the file is compressed.
    is_zip: bool,
}

fn header(source: &mut Source) -> Result<Head, ShapeError> {
    const WHAT: &str = "a VDB header";
    let magic: [u8; 8] = source.array(WHAT)?;
    if magic != MAGIC {
        return Err(source.malformed_at(Location::Byte(0), "` BDV`, the mark of OpenVDB", quoted(&magic)));
    }
    let version = u32::from_le_bytes(source.array(WHAT)?);
    if !VERSIONS.contains(&version) {
        let (file, place, found) = (source.file.clone(), Location::Byte(8), version.to_string());
        let remedy = "versions 220 to 225 are read: save it again with OpenVDB 3 to 13";
        return Err(ShapeError::Unsupported { file, place, what: "version", found, remedy });
    }
    source.skip(8, WHAT)?; // version of the library
    let has_offsets = source.array(WHAT)? != [0];
    let is_zip = version < NODE_MASKS && source.array(WHAT)? != [0];
    source.skip(36, WHAT)?; // an identifier
    Ok(Head { version, has_offsets, is_zip })
}

/// How the values of a grid are compressed.
fn flags(source: &mut Source, head: &Head) -> Result<u32, ShapeError> {
    if head.version < NODE_MASKS {
        return Ok(if head.is_zip { ZIP } else { 0 });
    }
    let place = Location::Byte(source.offset);
    let flags = u32::from_le_bytes(source.array("the compression of a grid")?);
    if flags & !KNOWN_FLAGS == 0 {
        return Ok(flags);
    }
    let (file, found) = (source.file.clone(), flags.to_string());
    let remedy = "none, zip, active mask and Blosc are read (0 to 7)";
    Err(ShapeError::Unsupported { file, place, what: "compression", found, remedy })
}

/// The grid behind its metadata, which may tell its corners; it says where its parts are if `has_offsets`.
fn volume(source: &mut Source, grid: Grid, has_offsets: bool) -> Result<Shape, ShapeError> {
    let Grid { about, mut coding, content, metadata } = grid;
    if metadata.is_half != about.is_half {
        let expected = "`is_saved_as_half_float` as the type of the grid says it";
        return Err(source.malformed_at(about.place, expected, format!("{}", metadata.is_half)));
    }
    let (zero, steps) = head::transform(source)?;
    let tree = Tree::read(source, &mut coding)?;
    let check = |source: &Source, offset: u64, expected| {
        if has_offsets && offset != source.offset {
            let found = format!("{offset} instead of {}", source.offset);
            return Err(source.malformed_at(about.place.clone(), expected, found));
        }
        Ok(())
    };
    check(source, about.blocks, "the offset of the leaves of a grid")?;
    let wrong = |expected, found: &str| Err(source.malformed_at(Location::Byte(source.offset), expected, found.into()));
    let (min, max) = match (metadata.corners, tree.active) {
        ([Some(min), Some(max)], active) => {
            let [low, high] = active.unwrap_or([min, max]);
            if !(min.cmple(low) & low.cmple(high) & high.cmple(max)).all() {
                return wrong("active voxels between the corners in the metadata", "others");
            }
            (min.as_i64vec3(), max.as_i64vec3())
        }
        (_, Some([min, max])) => (min.as_i64vec3() - 1, max.as_i64vec3() + 1),
        _ => return wrong("a grid with active voxels", "none"),
    };
    let size = (max - min + 1).to_array().map(|n| n as u64);
    let most = SMALL.max(source.len.saturating_mul(MAX_VOXELS_PER_BYTE));
    let size = placement::at_most(&source.file, "voxels in the box around the active ones", size, most)?;
    if !placement::are_lengths(axes::lengths(&steps)) {
        let found = format!("{:?}", steps.to_cols_array_2d());
        return Err(source.malformed_at(Location::Header, placement::STEPS, found));
    }
    let place = (zero + steps * min.as_dvec3(), steps);
    let mut placement = Placement::new(Space::RAS, size, place, content.unwrap_or(Content::Scalar));
    placement.check(&source.file)?;
    let mut values = placement.filled(&source.file, coding.background)?;
    tree.fill(source, &coding, Dense { min, size, values: &mut values })?;
    check(source, about.end, "the offset of the end of a grid")?;
    if content.is_none() {
        let is_distance = coding.background > 0.0 && values.iter().any(|value| *value < 0.0);
        let taken = if is_distance { "distances, negative inside" } else { "a density" };
        placement.content = if is_distance { Content::LevelSet } else { Content::Scalar };
        source.note(format!(
            "its grid {} says no class: its values are taken for {taken}",
            quoted(about.name.as_bytes())
        ));
    }
    placement.volume(source, values).map(Shape::Volume)
}
