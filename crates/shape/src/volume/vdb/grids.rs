//! Selection of a grid of an OpenVDB file.
//!
//! Role: reads the requested grid, else `density`, else the first level set or fog volume, else the first without a class.
//! Invariant: every grid of the file is listed, and a note names those left out. Source: OpenVDB 10, `io/Archive.cc`. The crate
//! vdb-rs panics on damaged files.

use super::grid::Grid;
use super::header::FileHeader;
use super::metadata::{self, Descriptor, Metadata};
use crate::error::{Location, ShapeError, first_few, quoted};
use crate::shape::Shape;
use crate::source::Source;
use hypertexture_support::memory;

/// Conventional name of the grid of a fog volume.
const DENSITY: &str = "density";
const REMEDY: &str = "a grid of floats or doubles of the class `level set` or `fog volume` is read: set its class";

/// A grid of a file in memory.
struct Held {
    unique: String,
    name: String,
    /// Description.
    kind: String,
    /// Rank among the grids that are asked for, if it is supported.
    rank: Option<usize>,
    grid: Option<Grid>,
    /// Byte after its metadata.
    start: u64,
}

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
    let count = source.u32("the number of grids")?;
    let fits = |bytes: u64| memory::available().is_none_or(|free| bytes < free / 2);
    if count > 1 && header.has_offsets && fits(source.remaining()) {
        select_held(source, &header, count)
    } else {
        select(source, &header, count)
    }
}

/// Reads a grid of a file in memory, where the tree of another grid can be found, and another grid if one is empty.
fn select_held(source: &mut Source, header: &FileHeader, count: u32) -> Result<Shape, ShapeError> {
    let base = source.offset;
    let bytes = source.block(source.remaining(), "grids")?;
    let (file, len) = (source.file.clone(), source.len);
    let mut at = base;
    let mut all: Vec<Held> = Vec::new();
    for index in 0..count {
        let mut reader = &bytes[(at - base) as usize..];
        let mut inner = Source::new(file.clone(), len, None, &mut reader);
        inner.offset = at;
        let about = Descriptor::read(&mut inner)?;
        let (name, unique, end, place) = (about.name.clone(), about.unique.clone(), about.end, about.place.clone());
        let is_named = source.grid.as_deref().is_none_or(|grid| about.is_called(grid));
        let (grid, kind) = Grid::describe(&mut inner, header, about)?;
        source.grids.push(format!("{} ({kind})", quoted(name.as_bytes())));
        let rank = grid.as_ref().filter(|_| is_named).map(|grid| rank(source, grid));
        let start = inner.offset;
        all.push(Held { unique, name, kind, rank, grid, start });
        if index + 1 < count && !(start..=len).contains(&end) {
            let expected = "the offset of the end of a grid after it";
            return Err(source.malformed_at(place, expected, end.to_string()));
        }
        at = end;
    }
    let mut order: Vec<&Held> = all.iter().filter(|held| held.rank.is_some()).collect();
    order.sort_by_key(|held| held.rank);
    let mut empty: Vec<String> = Vec::new();
    for held in order {
        let Some(grid) = &held.grid else { continue };
        let named = |name: &str| all.iter().find(|other| other.unique == name);
        // The bytes after the metadata of a grid.
        let within = |start: u64| (&bytes[(start - base) as usize..], start);
        let inner = |(reader, start): (&mut &[u8], u64),
                     read: &dyn Fn(&mut Source) -> Result<Option<Shape>, ShapeError>| {
            let mut inner = Source::new(file.clone(), len, None, reader);
            inner.offset = start;
            let found = read(&mut inner)?;
            Ok((found, inner.notes.take()))
        };
        let (mut reader, start) = within(held.start);
        let (found, notes) = if grid.about.parent.is_empty() {
            inner((&mut reader, start), &|inner| grid.volume(inner, true))?
        } else {
            let tree = named(&grid.about.parent).and_then(|held| Some((held.grid.as_ref()?, held.start)));
            let Some((tree, place)) = tree.filter(|(tree, _)| tree.about.parent.is_empty()) else {
                let found = quoted(grid.about.parent.as_bytes());
                return Err(source.malformed_at(
                    grid.about.place.clone(),
                    "a grid whose tree another one shares",
                    found,
                ));
            };
            let mut own = Source::new(file.clone(), len, None, &mut reader);
            own.offset = start;
            let transform = metadata::transform(&mut own)?;
            let shared = tree.shared_with(grid);
            let (mut reader, start) = within(place);
            inner((&mut reader, start), &|inner| shared.instance(inner, transform))?
        };
        let Some(shape) = found else {
            empty.push(quoted(held.name.as_bytes()));
            continue;
        };
        notes.into_iter().for_each(|note| source.note(note));
        if !empty.is_empty() {
            source.note(format!("empty, without active voxels: {}", first_few(&empty, ", ")));
        }
        note_others(source, &held.name);
        return Ok(shape);
    }
    if empty.is_empty() {
        return Err(no_readable_grid(source));
    }
    let others: Vec<String> = all
        .iter()
        .filter(|held| held.grid.is_some() && !empty.contains(&quoted(held.name.as_bytes())))
        .map(|held| format!("{} ({})", quoted(held.name.as_bytes()), held.kind))
        .collect();
    Err(no_voxels(source, &empty, &others))
}

/// Preference of a grid: lower is better.
fn rank(source: &Source, grid: &Grid) -> usize {
    match grid.content {
        _ if source.grid.is_some() || grid.about.is_density() => 0,
        Some(_) => 1,
        None => 2,
    }
}

/// Error of grids without active voxels.
fn no_voxels(source: &Source, empty: &[String], others: &[String]) -> ShapeError {
    let own = format!("{} without active voxels", first_few(empty, ", "));
    let (found, remedy) = if others.is_empty() {
        (own, "export it with a grid that has some")
    } else {
        (format!("{own} (others: {})", first_few(others, ", ")), "choose another one by --grid NAME or object.grid")
    };
    source.unsupported(Location::Header, "the grid", found, remedy)
}

/// Notes the grids that are not read.
fn note_others(source: &Source, name: &str) {
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

/// Reads a grid on the way through the file.
fn select(source: &mut Source, header: &FileHeader, count: u32) -> Result<Shape, ShapeError> {
    let (mut shape, mut deferred): (Option<(String, Shape)>, Option<Deferred>) = (None, None);
    for index in 0..count {
        let about = Descriptor::read(source)?;
        let (name, end, place) = (about.name.clone(), about.end, about.place.clone());
        let is_named = source.grid.as_deref().is_none_or(|grid| about.is_called(grid));
        let (grid, kind) = Grid::describe(source, header, about)?;
        let grid = grid.filter(|grid| grid.about.parent.is_empty()); // the tree has gone by, or follows
        source.grids.push(format!("{} ({kind})", quoted(name.as_bytes())));
        let rank = grid.as_ref().filter(|_| is_named && shape.is_none()).map(|grid| rank(source, grid));
        let is_better = rank.is_some_and(|rank| deferred.as_ref().is_none_or(|deferred| rank < deferred.rank));
        let left = end.checked_sub(source.offset).filter(|_| header.has_offsets);
        let is_last = index + 1 == count;
        match (grid, left) {
            (Some(grid), left) if is_better && (rank == Some(0) || is_last || left.is_none()) => {
                let found = grid.volume(source, header.has_offsets)?;
                shape = Some((name.clone(), found.ok_or_else(|| no_voxels(source, &[quoted(name.as_bytes())], &[]))?));
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
        let read = read.ok_or_else(|| no_voxels(source, &[quoted(name.as_bytes())], &[]))?;
        shape = Some((name, read));
    }
    let Some((name, shape)) = shape else { return Err(no_readable_grid(source)) };
    if count > 1 {
        note_others(source, &name);
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
