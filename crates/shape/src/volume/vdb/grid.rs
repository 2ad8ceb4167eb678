//! One grid of an OpenVDB file as a dense volume.
//!
//! Invariant: no memory is allocated for a box before the nodes that span it have been read.

use super::header::FileHeader;
use super::metadata::{self, Descriptor, Metadata};
use super::tree::{Dense, Tree};
use super::values::ValueEncoding;
use crate::error::{Location, ShapeError, quoted};
use crate::sample_type::SampleType;
use crate::shape::{Content, Shape, axes};
use crate::source::Source;
use crate::volume::placement::{self, Placement};
use crate::volume::space::Space;
use glam::{DMat3, DVec3};

/// Most voxels of a box: this many per byte of the file, or `SMALL` (256 MiB). Real level sets have less than a tenth; two
/// distant voxels would take all memory.
const MAX_VOXELS_PER_BYTE: u64 = 1024;
const SMALL: u64 = 1 << 26;

/// Type of a tree whose values have 16 bits.
const HALF: &str = "Tree_half_5_4_3";

/// A supported grid.
#[derive(Clone)]
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
            "Tree_float_5_4_3" => (SampleType::F32, "floats"),
            "Tree_double_5_4_3" => (SampleType::F64, "doubles"),
            HALF => (SampleType::F32, "halfs"),
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
        let is_half = about.is_half || about.kind == HALF;
        let single = if about.kind == HALF { 2 } else { kind.bytes() };
        let encoding = ValueEncoding { version: header.version, kind, is_half, single, flags, background: 0.0 };
        Ok((Some(Grid { about, encoding, content, metadata }), words))
    }

    /// Reads the grid after its metadata, which may hold the corners; offsets are checked if `has_offsets`. `None`: it has no active
    /// voxels.
    pub fn volume(&self, source: &mut Source, has_offsets: bool) -> Result<Option<Shape>, ShapeError> {
        let transform = metadata::transform(source)?;
        if self.about.kind != HALF || !has_offsets {
            return self.placed(source, has_offsets, transform);
        }
        self.halfs(source, transform)
    }

    fn halfs(&self, source: &mut Source, transform: (DVec3, DMat3)) -> Result<Option<Shape>, ShapeError> {
        // OpenVDB 13 stores single values in 2 bytes; other writers of this type take the 4 of a float saved as half.
        let offset = source.offset;
        let left = self.about.end.saturating_sub(offset);
        let bytes = source.block(left, "a grid")?;
        let with = |single| {
            let mut reader = &bytes[..];
            let mut inner = Source::new(source.file.clone(), offset + left, None, &mut reader);
            inner.offset = offset;
            let grid = Grid { encoding: ValueEncoding { single, ..self.encoding }, ..self.clone() };
            let found = grid.placed(&mut inner, true, transform)?;
            Ok((found, inner.notes.take()))
        };
        let (found, notes) = with(2).or_else(|error: ShapeError| with(4).map_err(|_| error))?;
        notes.into_iter().for_each(|note| source.note(note));
        Ok(found)
    }

    /// The tree of this grid with the meaning of an instance.
    pub(crate) fn shared_with(&self, instance: &Grid) -> Grid {
        Grid { content: instance.content, ..self.clone() }
    }

    /// Reads the tree with another transform, after that of the grid itself.
    pub fn instance(&self, source: &mut Source, transform: (DVec3, DMat3)) -> Result<Option<Shape>, ShapeError> {
        metadata::transform(source)?;
        if self.about.kind == HALF { self.halfs(source, transform) } else { self.placed(source, true, transform) }
    }

    /// Reads the tree with the transform of this grid or of another one that shares it.
    pub fn placed(
        &self,
        source: &mut Source,
        has_offsets: bool,
        (zero, steps): (DVec3, DMat3),
    ) -> Result<Option<Shape>, ShapeError> {
        let Grid { about, mut encoding, content, metadata } = self.clone();
        if metadata.is_half != about.is_half && about.kind != HALF {
            let expected = "`is_saved_as_half_float` as the type of the grid says it";
            return Err(source.malformed_at(about.place, expected, format!("{}", metadata.is_half)));
        }
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
            _ => return Ok(None),
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
        placement.volume(source, values).map(|volume| Some(Shape::Volume(volume)))
    }
}
