//! Selection of a grid of an OpenVDB file.
//!
//! Role: reads the requested grid, else `density`, else the first level set or fog volume, else the first without a class.
//! Invariant: every grid of the file is listed, and a note names those left out. Source: OpenVDB 10, `io/Archive.cc`. The crate
//! vdb-rs panics on damaged files.

use super::grid::Grid;
use super::header::FileHeader;
use super::metadata::{Descriptor, Metadata};
use crate::Shape;
use crate::error::{Location, ShapeError, first_few, quoted};
use crate::source::Source;
use hypertexture_support::memory;

/// Conventional name of the grid of a fog volume.
const DENSITY: &str = "density";
const REMEDY: &str = "a grid of floats or doubles of the class `level set` or `fog volume` is read: set its class";

/// Bytes of a grid that is read if no better one follows.
struct Deferred {
    grid: Grid,
    rank: usize,
    offset: u64,
    bytes: Vec<u8>,
}

/// Reads one grid of floats or doubles: the box around its active voxels with a margin of one voxel, or the box in the metadata
/// of files of this program. Values may be halves, masked, zip or Blosc; doubles are rounded to f32.
pub(crate) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    let header = FileHeader::read(source)?;
    Metadata::read(source)?;
    select(source, &header)
}

fn select(source: &mut Source, header: &FileHeader) -> Result<Shape, ShapeError> {
    let count = source.u32("the number of grids")?;
    let (mut shape, mut deferred): (Option<(String, Shape)>, Option<Deferred>) = (None, None);
    for index in 0..count {
        let about = Descriptor::read(source)?;
        let (name, end, place) = (about.name.clone(), about.end, about.place.clone());
        let is_named = source.grid.as_deref().is_none_or(|grid| about.is_called(grid));
        let (grid, kind) = Grid::describe(source, header, about)?;
        source.grids.push(format!("{} ({kind})", quoted(name.as_bytes())));
        let rank = grid.as_ref().filter(|_| is_named && shape.is_none()).map(|grid| match grid.content {
            _ if source.grid.is_some() || grid.about.is_density() => 0,
            Some(_) => 1,
            None => 2,
        });
        let is_better = rank.is_some_and(|rank| deferred.as_ref().is_none_or(|deferred| rank < deferred.rank));
        let left = end.checked_sub(source.offset).filter(|_| header.has_offsets);
        let is_last = index + 1 == count;
        match (grid, left) {
            (Some(grid), left) if is_better && (rank == Some(0) || is_last || left.is_none()) => {
                shape = Some((name, grid.volume(source, header.has_offsets)?));
            }
            (grid, Some(left)) if !is_last || is_better => match (grid, rank) {
                (Some(grid), Some(rank)) if is_better => {
                    if memory::available().is_some_and(|free| left > free / 2) {
                        return Err(ShapeError::OutOfMemory { file: source.file.clone(), bytes: left });
                    }
                    let (offset, bytes) = (source.offset, source.block(left, "a grid")?);
                    deferred = Some(Deferred { grid, rank, offset, bytes });
                }
                _ => source.skip(left, "a grid")?,
            },
            (_, None) if shape.is_some() => break, // without offsets the next grid cannot be found
            (_, None) if !is_last => {
                let expected = "the offset of the end of a grid after it";
                return Err(source.malformed_at(place, expected, end.to_string()));
            }
            _ => {}
        }
    }
    if let (None, Some(Deferred { grid, offset, bytes, .. })) = (&shape, deferred) {
        let mut reader = &bytes[..];
        let mut inner = Source::new(source.file.clone(), offset + bytes.len() as u64, None, &mut reader);
        inner.offset = offset;
        let name = grid.about.name.clone();
        let read = grid.volume(&mut inner, header.has_offsets)?;
        let notes = inner.notes;
        source.notes.borrow_mut().extend(notes.take());
        shape = Some((name, read));
    }
    let Some((name, shape)) = shape else { return Err(no_readable_grid(source)) };
    if count > 1 {
        let own = quoted(name.as_bytes());
        let mut others: Vec<&str> = source.grids.iter().map(|grid| &**grid).collect();
        if let Some(at) = others.iter().position(|grid| grid.starts_with(&own)) {
            others.remove(at);
        }
        source.note(format!(
            "its grid {own} is read, left out: {} (--grid NAME or object.grid reads another)",
            first_few(&others, ", ")
        ));
    }
    Ok(shape)
}

/// Error of a file without a readable grid.
fn no_readable_grid(source: &Source) -> ShapeError {
    let all: Vec<&str> = source.grids.iter().map(|grid| &**grid).collect();
    let own = source.grid.as_deref().map(|grid| quoted(grid.as_bytes()));
    match own.map(|own| (all.iter().find(|grid| grid.starts_with(&own)), own)) {
        Some((None, name)) => ShapeError::NoGrid { file: source.file.clone(), name, known: first_few(&all, ", ") },
        Some((Some(grid), _)) => source.unsupported(Location::Header, "the grid", *grid, REMEDY),
        None => {
            let found = if all.is_empty() { "of no grids".into() } else { format!("of {}", first_few(&all, ", ")) };
            source.unsupported(Location::Header, "a file", found, REMEDY)
        }
    }
}

impl Descriptor {
    /// Whether `name` is the name of the grid, with or without its number.
    fn is_called(&self, name: &str) -> bool {
        self.name == name || self.base() == name
    }

    fn is_density(&self) -> bool {
        self.base().eq_ignore_ascii_case(DENSITY)
    }

    fn base(&self) -> &str {
        &self.name[..self.base]
    }
}
