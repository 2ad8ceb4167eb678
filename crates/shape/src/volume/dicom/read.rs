//! Reader of DICOM series.
//!
//! Role: the files of a series as one [`Volume`](crate::Volume), in mm, on the axes of NIfTI: x to the right of the patient, y
//! to the front, z up. Invariant: all headers are read before pixels, and memory is allocated once all slices have their
//! places. Source: NEMA PS3. The crate `dicom-object` overflows the stack on deeply nested sequences.

use super::deflated::inflated;
use super::frames::PixelEncoding;
use super::header::{MARK, MARK_AT};
use super::image::{Image, MAX_FRAMES};
use super::series::{Even, Layout, Member, layout, without_others};
use crate::error::{Location, ShapeError, first_few, quoted, shown};
use crate::shape::Shape;
use crate::source::Source;
use crate::unit::Unit;
use crate::volume::placement::Placement;
use hypertexture_support::open::Home;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Most files of a folder: five times the slices of a whole body.
const MAX_FILES: usize = 10_000;
/// Most folders that are looked through where a folder has no slices itself, and their deepest level: of a patient, a study, a series.
const MAX_FOLDERS: usize = 1000;
const MAX_DEPTH: usize = 6;

/// Whether the file has the prefix of DICOM after 128 bytes.
pub(crate) fn recognizes(start: &[u8], _len: u64) -> bool {
    start.get(MARK_AT..).is_some_and(|rest| rest.starts_with(MARK))
}

/// Reads the series of a slice from the files beside it, or the frames of a multi-frame file.
///
/// Integers of 8, 16 or 32 bits, each slice with its slope and intercept, become f32. Slices with an offset to each other, as
/// of a tilted gantry, keep their places; a few of another size or orientation, as localizers, are left out. Colors and
/// MONOCHROME1 are refused: programs disagree on whether the latter is inverted.
pub(crate) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    source.unit.set(Some(Unit::Millimeter));
    inflated(source, read_inflated)
}

fn read_inflated(source: &mut Source) -> Result<Shape, ShapeError> {
    let image = Image::read(source)?;
    if let Some(folder) = source.folder.clone().filter(|_| image.is_slice()) {
        let mut members = members(&source.file, &folder)?;
        members.retain(|member| member.image.series == image.series);
        source.others.borrow_mut().extend(members.iter().map(|member| member.path.clone()));
        return joined(source, members);
    }
    image.check(source, &source.file)?;
    let members = [Member { path: PathBuf::new(), image }];
    let Layout { placement, slices, even } = layout(source, &members)?;
    let mut values = placement.filled(&source.file, 0.0)?;
    fill(&mut values, source, &members[0].image, &slices[0])?;
    evened(source, placement, even, values)
}

/// Reads the series in a folder, with notes.
pub(crate) fn read_folder(name: &str, folder: &Path) -> Result<(Shape, Vec<String>), ShapeError> {
    let mut nothing = io::empty();
    let source = Source::new(name.into(), 0, None, &mut nothing);
    let shape = folder_series(&source, folder)?;
    Ok((shape, source.notes.take()))
}

fn folder_series(source: &Source, folder: &Path) -> Result<Shape, ShapeError> {
    let name = &*source.file;
    let mut members = members(name, folder)?;
    if members.is_empty() {
        let (mut inside, mut seen) = (folders_in(folder), 1);
        while let Some((path, depth)) = inside.pop() {
            if seen > MAX_FOLDERS {
                return Err(too_many(name, format!("more than {MAX_FOLDERS} folders")));
            }
            seen += 1;
            let own = self::members(name, &path)?;
            if !own.is_empty() {
                let place = path.strip_prefix(folder).unwrap_or(&path).to_string_lossy().into_owned();
                source.note(format!("its slices are in the folder {} in it", quoted(place.as_bytes())));
            }
            members.extend(own);
            if depth < MAX_DEPTH {
                inside.extend(folders_in(&path).into_iter().map(|(path, _)| (path, depth + 1)));
            }
            if members.len() > MAX_FILES {
                return Err(too_many(name, format!("more than {MAX_FILES} files")));
            }
        }
    }
    let Some(first) = members.first() else {
        return Err(ShapeError::NotAFile { file: name.into(), kind: "a directory" });
    };
    if members.iter().all(|member| member.image.series == first.image.series) {
        return joined(source, members);
    }
    let mut series: Vec<(&Member, usize)> = Vec::new();
    for member in &members {
        match series.iter_mut().find(|(first, _)| first.image.series == member.image.series) {
            Some((_, files)) => *files += 1,
            None => series.push((member, 1)),
        }
    }
    let all: Vec<String> =
        series.iter().map(|(first, files)| format!("{} and {} more", first.name(), files - 1)).collect();
    let found = format!("{} series ({})", all.len(), first_few(&all, "; "));
    let remedy = "name a file of the one that you want, all of its slices are read then";
    Err(ShapeError::unsupported(name, Location::Folder, "a folder of", found, remedy))
}

/// Folders in a folder, the first by name last, each one level deeper; links are left out.
fn folders_in(folder: &Path) -> Vec<(PathBuf, usize)> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let folders = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    let mut paths: Vec<PathBuf> = folders.map(|entry| entry.path()).collect();
    paths.sort_by(|a, b| b.cmp(a));
    paths.into_iter().map(|path| (path, 1)).collect()
}

/// All images in the files of a folder, sorted by file name.
fn members(name: &str, folder: &Path) -> Result<Vec<Member>, ShapeError> {
    let failed = |reason| ShapeError::Unreadable { file: name.into(), reason };
    // A bare file name is in the current folder.
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (mut paths, home) = (Vec::new(), Home::of(folder));
    for entry in fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let (path, is_link) = (entry.path(), entry.file_type().is_ok_and(|kind| kind.is_symlink()));
        if path.metadata().is_ok_and(|about| about.is_file() && about.len() > MARK_AT as u64) {
            if is_link && !home.holds(&path) {
                let link = path.file_name().unwrap_or_default().to_string_lossy();
                return Err(Source::link_outside(name, Location::Folder, &link));
            }
            paths.push(path);
        }
        if paths.len() > MAX_FILES {
            return Err(too_many(name, format!("more than {MAX_FILES} files")));
        }
    }
    paths.sort();
    let (mut members, mut frames) = (Vec::new(), 0);
    for path in paths {
        let image = Source::with_file(&path, |source| {
            let is_dicom = recognizes(source.peek()?, 0);
            is_dicom.then(|| inflated(source, Image::read)).transpose()
        })?;
        if let Some(image) = image.filter(Image::is_picture) {
            frames += image.frames.len();
            members.push(Member { path, image });
        }
        if frames > MAX_FRAMES {
            return Err(too_many(name, format!("more than {MAX_FRAMES} frames")));
        }
    }
    Ok(members)
}

fn too_many(name: &str, found: String) -> ShapeError {
    let remedy = "put the slices of the scan into a folder of their own";
    ShapeError::unsupported(name, Location::Folder, "a folder of", found, remedy)
}

/// Volume of all frames of `members` except a few deviating images.
fn joined(source: &Source, members: Vec<Member>) -> Result<Shape, ShapeError> {
    let name = &*source.file;
    let members = &without_others(source, members)[..];
    members.iter().try_for_each(|member| member.image.check(source, &shown(&member.path.to_string_lossy())))?;
    let Layout { placement, slices, even } = layout(source, members)?;
    let mut values = placement.filled(name, 0.0)?;
    for (member, slices) in members.iter().zip(&slices) {
        let again = |part: &mut Source| {
            let image = Image::read(part)?;
            if image != member.image {
                let found = "another one than before".into();
                return Err(part.malformed_at(Location::Header, "a file that stays as it is", found));
            }
            fill(&mut values, part, &image, slices)
        };
        Source::with_file(&member.path, |part| {
            inflated(part, again)?;
            source.adopt(part);
            Ok(())
        })?;
    }
    evened(source, placement, even, values)
}

/// The volume of slices, interpolated if their distances differ.
fn evened(source: &Source, placement: Placement, even: Option<Even>, values: Vec<f32>) -> Result<Shape, ShapeError> {
    let Some(even) = even else { return placement.volume(source, values).map(Shape::Volume) };
    let mut interpolated = even.placement.filled(&source.file, 0.0)?;
    let last = placement.size[2] as usize - 1;
    let pixels = values.len() / (last + 1);
    for (slice, at) in interpolated.chunks_exact_mut(pixels).zip(&even.places) {
        let below = (*at as usize).min(last - 1);
        let part = (at - below as f64) as f32;
        let [low, high] = [below, below + 1].map(|index| &values[index * pixels..][..pixels]);
        slice.iter_mut().zip(low.iter().zip(high)).for_each(|(value, (low, high))| {
            // Exact at both ends.
            *value = if part >= 1.0 { *high } else { low + part * (high - low) };
        });
    }
    even.placement.volume(source, interpolated).map(Shape::Volume)
}

/// Reads the frames of an image, whose pixels are next in the source, into their slices.
fn fill(values: &mut [f32], source: &mut Source, image: &Image, slices: &[usize]) -> Result<(), ShapeError> {
    let mut fragments = image.fragments(source)?;
    if image.encoding == PixelEncoding::LossyJpeg {
        source.note("its pixels are packed by a JPEG that changes values".into());
    }
    for (index, slice) in slices.iter().enumerate() {
        let own = &mut values[slice * image.pixels()..][..image.pixels()];
        image.values(source, fragments.as_mut(), index, own)?;
    }
    Ok(())
}
