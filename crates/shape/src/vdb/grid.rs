//! One grid of an OpenVDB file as a dense volume.
//!
//! Invariant: no memory is allocated for a box before the nodes that span it have been read.

use super::header::FileHeader;
use super::metadata::{self, Descriptor, Metadata};
use super::tree::{Dense, Tree};
use super::values::ValueEncoding;
use crate::error::{Location, ShapeError, quoted};
use crate::placement::{self, Placement};
use crate::source::Source;
use crate::space::Space;
use crate::{Content, SampleType, Shape, axes};

/// Most voxels of a box: this many per byte of the file, or `SMALL` (256 MiB). Real level sets have less than a tenth; two
/// distant voxels would take all memory.
const MAX_VOXELS_PER_BYTE: u64 = 1024;
const SMALL: u64 = 1 << 26;

/// A supported grid.
pub(super) struct Grid {
    pub about: Descriptor,
    pub encoding: ValueEncoding,
    /// Meaning of the values, if the class tells.
    pub content: Option<Content>,
    pub metadata: Metadata,
}

impl Grid {
    /// Reads the metadata of a grid: the grid if it is supported, and a description.
    pub fn describe(
        source: &mut Source,
        header: &FileHeader,
        about: Descriptor,
    ) -> Result<(Option<Grid>, String), ShapeError> {
        let (kind, words) = match &*about.kind {
            _ if about.is_instance => return Ok((None, "the tree of another grid".into())),
            "Tree_float_5_4_3" => (SampleType::F32, "floats"),
            "Tree_double_5_4_3" => (SampleType::F64, "doubles"),
            kind => return Ok((None, quoted(kind.as_bytes()))),
        };
        let flags = header.flags(source)?;
        let metadata = Metadata::read(source)?;
        let content = match &*metadata.class {
            "level set" if metadata.is_distance => Some(Content::SignedDistance),
            "level set" => Some(Content::LevelSet),
            "fog volume" => Some(Content::Scalar),
            "" | "unknown" => None,
            class => return Ok((None, format!("class {}", quoted(class.as_bytes())))),
        };
        let class = if content.is_none() { "no class" } else { &metadata.class };
        let words = format!("{class}, {words}");
        let encoding = ValueEncoding { version: header.version, kind, is_half: about.is_half, flags, background: 0.0 };
        Ok((Some(Grid { about, encoding, content, metadata }), words))
    }

    /// Reads the grid after its metadata, which may hold the corners; offsets are checked if `has_offsets`.
    pub fn volume(self, source: &mut Source, has_offsets: bool) -> Result<Shape, ShapeError> {
        let Grid { about, mut encoding, content, metadata } = self;
        if metadata.is_half != about.is_half {
            let expected = "`is_saved_as_half_float` as the type of the grid says it";
            return Err(source.malformed_at(about.place, expected, format!("{}", metadata.is_half)));
        }
        let (zero, steps) = metadata::transform(source)?;
        let tree = Tree::read(source, &mut encoding)?;
        let check = |source: &Source, offset: u64, expected| {
            if has_offsets && offset != source.offset {
                let found = format!("{offset} instead of {}", source.offset);
                return Err(source.malformed_at(about.place.clone(), expected, found));
            }
            Ok(())
        };
        check(source, about.blocks, "the offset of the leaves of a grid")?;
        let wrong = |expected, found: &str| Err(source.malformed_here(expected, found.into()));
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
        let mut values = placement.filled(&source.file, encoding.background)?;
        tree.fill(source, &encoding, Dense { min, size, values: &mut values })?;
        check(source, about.end, "the offset of the end of a grid")?;
        if content.is_none() {
            let is_distance = encoding.background > 0.0 && values.iter().any(|value| *value < 0.0);
            let taken = if is_distance { "distances, negative inside" } else { "a density" };
            placement.content = if is_distance { Content::LevelSet } else { Content::Scalar };
            source.note(format!(
                "its grid {} has no class: its values are read as {taken}",
                quoted(about.name.as_bytes())
            ));
        }
        placement.volume(source, values).map(Shape::Volume)
    }
}
