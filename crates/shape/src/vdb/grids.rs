//! The grids of an OpenVDB file, and the one that is read.
//!
//! Role: which of several grids is the object: the one that is asked for, else `density`, else the first level set or fog volume,
//! else the first of no class. Invariant: every grid of the file is listed, and a note names those that are left out.

use super::super::error::{Location, ShapeError, quoted};
use super::super::source::Source;
use super::super::{Content, Shape};
use super::head::{Descriptor, Metadata};
use super::values::Coding;
use super::{Head, flags, volume};
use support::memory;

/// The name of the grid of a fog volume or smoke that is matter, by custom.
const DENSITY: &str = "density";
/// Grids that are named in a message.
const NAMED: usize = 4;
/// What to do where no grid is read.
const REMEDY: &str = "a grid of floats or doubles of the class `level set` or `fog volume` is read: set its class";

/// A grid that can be read.
pub(super) struct Grid {
    pub about: Descriptor,
    pub coding: Coding,
    /// What its values mean; none where the file does not say so.
    pub content: Option<Content>,
    pub metadata: Metadata,
}

/// The bytes of a grid that is read if none goes before it, and where they are.
struct Kept {
    grid: Grid,
    rank: usize,
    offset: u64,
    bytes: Vec<u8>,
}

/// Reads the grid that is the object.
pub(super) fn read(source: &mut Source, head: &Head) -> Result<Shape, ShapeError> {
    let count = u32::from_le_bytes(source.array("the number of grids")?);
    let (mut shape, mut kept): (Option<(String, Shape)>, Option<Kept>) = (None, None);
    for index in 0..count {
        let about = Descriptor::read(source)?;
        let (name, end, place) = (about.name.clone(), about.end, about.place.clone());
        let is_named = source.grid.as_deref().is_none_or(|grid| about.is_called(grid));
        let (grid, kind) = described(source, head, about)?;
        source.grids.push(format!("{} ({kind})", quoted(name.as_bytes())));
        let rank = grid.as_ref().filter(|_| is_named && shape.is_none()).map(|grid| match grid.content {
            _ if source.grid.is_some() || grid.about.is_density() => 0,
            Some(_) => 1,
            None => 2,
        });
        let is_better = rank.is_some_and(|rank| kept.as_ref().is_none_or(|kept| rank < kept.rank));
        let left = end.checked_sub(source.offset).filter(|_| head.has_offsets);
        let is_last = index + 1 == count;
        match (grid, left) {
            (Some(grid), left) if is_better && (rank == Some(0) || is_last || left.is_none()) => {
                shape = Some((name, volume(source, grid, head.has_offsets)?));
            }
            (grid, Some(left)) if !is_last || is_better => match (grid, rank) {
                (Some(grid), Some(rank)) if is_better => {
                    if memory::available().is_some_and(|free| left > free / 2) {
                        return Err(ShapeError::OutOfMemory { file: source.file.clone(), bytes: left });
                    }
                    let (offset, bytes) = (source.offset, source.block(left, "a grid")?);
                    kept = Some(Kept { grid, rank, offset, bytes });
                }
                _ => source.skip(left, "a grid")?,
            },
            (_, None) if shape.is_some() => break, // what follows is nowhere told
            (_, None) if !is_last => {
                let expected = "the offset of the end of a grid behind it";
                return Err(source.malformed_at(place, expected, end.to_string()));
            }
            _ => {}
        }
    }
    if let (None, Some(Kept { grid, offset, bytes, .. })) = (&shape, kept) {
        let mut reader = &bytes[..];
        let mut inner = Source::new(source.file.clone(), offset + bytes.len() as u64, None, &mut reader);
        inner.offset = offset;
        let name = grid.about.name.clone();
        let read = volume(&mut inner, grid, head.has_offsets)?;
        inner.notes.take().into_iter().for_each(|note| source.note(note));
        shape = Some((name, read));
    }
    let Some((name, shape)) = shape else { return Err(nothing(source)) };
    if count > 1 {
        let own = quoted(name.as_bytes());
        let mut others: Vec<&str> = source.grids.iter().map(|grid| &**grid).collect();
        if let Some(at) = others.iter().position(|grid| grid.starts_with(&own)) {
            others.remove(at);
        }
        source.note(format!(
            "its grid {own} is read, left out: {} (--grid NAME or object.grid reads another)",
            some(&others)
        ));
    }
    Ok(shape)
}

/// What a grid is, if it can be read, and words for it: its metadata is read then.
fn described(source: &mut Source, head: &Head, about: Descriptor) -> Result<(Option<Grid>, String), ShapeError> {
    let is_double = match &*about.kind {
        _ if about.is_instance => return Ok((None, "the tree of another grid".into())),
        "Tree_float_5_4_3" => false,
        "Tree_double_5_4_3" => true,
        kind => return Ok((None, quoted(kind.as_bytes()))),
    };
    let flags = flags(source, head)?;
    let metadata = Metadata::read(source)?;
    let content = match &*metadata.class {
        "level set" if metadata.is_distance => Some(Content::SignedDistance),
        "level set" => Some(Content::LevelSet),
        "fog volume" => Some(Content::Scalar),
        "" | "unknown" => None,
        class => return Ok((None, format!("class {}", quoted(class.as_bytes())))),
    };
    let class = if content.is_none() { "no class" } else { &metadata.class };
    let kind = format!("{class}, {}", if is_double { "doubles" } else { "floats" });
    let coding = Coding { version: head.version, is_double, is_half: about.is_half, flags, background: 0.0 };
    Ok((Some(Grid { about, coding, content, metadata }), kind))
}

/// Why no grid is read.
fn nothing(source: &Source) -> ShapeError {
    let file = source.file.clone();
    let all: Vec<&str> = source.grids.iter().map(|grid| &**grid).collect();
    let own = source.grid.as_deref().map(|grid| quoted(grid.as_bytes()));
    match own.map(|own| (all.iter().find(|grid| grid.starts_with(&own)), own)) {
        Some((None, name)) => ShapeError::NoGrid { file, name, known: some(&all) },
        Some((Some(grid), _)) => {
            let found = (*grid).into();
            ShapeError::Unsupported { file, place: Location::Header, what: "the grid", found, remedy: REMEDY }
        }
        None => {
            let found = if all.is_empty() { "of no grids".into() } else { format!("of {}", some(&all)) };
            ShapeError::Unsupported { file, place: Location::Header, what: "a file", found, remedy: REMEDY }
        }
    }
}

/// The first few of them.
fn some(grids: &[&str]) -> String {
    let more = if grids.len() > NAMED { ", ..." } else { "" };
    format!("{}{more}", grids[..grids.len().min(NAMED)].join(", "))
}

impl Descriptor {
    /// Whether this is its name, with or without the number that tells it from others of the same name.
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
