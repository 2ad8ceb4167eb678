//! Raw files: volumes without a header.

use super::placement::{self, Placement};
use super::raster::{Compression, Data, Raster, sides};
use super::space::Space;
use crate::error::{Found, Location, ShapeError, quoted};
use crate::sample_type::SampleType;
use crate::shape::{Content, Shape};
use crate::source::Source;
use glam::{DMat3, DVec3};
use std::path::Path;

/// Layout of a raw file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawLayout {
    /// Samples per axis, x fastest, each at least 1.
    pub size: [u32; 3],
    /// Type of a value.
    pub kind: SampleType,
    /// Byte order.
    pub big_endian: bool,
    /// World distances between neighboring samples on each axis, positive.
    pub spacing: [f64; 3],
    /// Bytes before the values; `None` if the values are at the end of the file.
    pub skip: Option<u64>,
}

/// Opens a raw file as a scalar volume whose first sample is at the world origin.
///
/// Integers above 2^24 and doubles are rounded to f32; assumptions are logged as warnings.
///
/// # Errors
/// Any [`ShapeError`], also for a layout that does not fit the length of the file.
pub fn open_raw(path: &str, layout: &RawLayout) -> Result<Shape, ShapeError> {
    Source::with_file(Path::new(path), |source| read(source, layout))
}

fn read(source: &mut Source, layout: &RawLayout) -> Result<Shape, ShapeError> {
    let wrong = |expected, found: String| source.malformed_at(Location::Layout, expected, quoted(found.as_bytes()));
    if layout.size.contains(&0) {
        return Err(wrong("3 sizes of at least 1", sides(layout.size)));
    }
    let size = placement::checked(&source.file, layout.size.map(u64::from))?;
    let spacing = DVec3::from(layout.spacing);
    if !placement::are_lengths(spacing) {
        return Err(wrong(placement::STEPS, layout.spacing.map(|step| step.to_string()).join(" ")));
    }
    let (steps, content) = (DMat3::from_diagonal(spacing), Content::Scalar);
    let placement = Placement::new(Space::RAS, size, (DVec3::ZERO, steps), content);
    // No header says what the bytes behind are: the layout is wrong more often than the file is longer.
    let (declared, left) =
        (placement.voxels() * layout.kind.bytes(), layout.skip.map(|skip| (skip, source.len.saturating_sub(skip))));
    if let Some((offset, left)) = left.filter(|(_, left)| *left > declared) {
        let what = format!("{} voxels of {} bytes", sides(size), layout.kind.bytes());
        return Err(ShapeError::DataSize {
            file: source.file.clone(),
            offset,
            declared,
            what,
            found: Found::Bytes(left),
        });
    }
    let (kind, big_endian) = (layout.kind, layout.big_endian);
    let raster = Raster { kind, big_endian, compression: Compression::None, scale: None, placement };
    let data = Data { before: layout.skip, ..Data::HERE };
    let shape = raster.read(source, &data)?;
    source.notes.take().iter().for_each(|note| log::warn!("{}: {note}", source.file));
    Ok(shape)
}

/// Error of a raw file without a layout, with a guess.
pub(crate) fn refuse(source: &mut Source) -> Result<Shape, ShapeError> {
    let bytes = source.len;
    let side = |kind: &SampleType| (1..1291).find(|side: &u64| side.pow(3) * kind.bytes() == bytes).filter(|n| *n > 1);
    let usual = [SampleType::U8, SampleType::U16, SampleType::F32, SampleType::F64];
    let guess = usual.iter().find_map(|kind| Some((side(kind)?, kind)));
    let guess = guess.map_or(String::new(), |(n, kind)| format!(" ({n} x {n} x {n} of {kind}?)"));
    Err(ShapeError::NoLayout { file: source.file.clone(), bytes, guess })
}
