//! DICOM: the slices of a scan, one a file or several in one.
//!
//! Role: the files of a series in a folder into one [`Volume`] in the coordinates of the patient (left, posterior, superior;
//! mm). Invariant: heads are read before pixels, and memory is taken once all slices have their places. Read here and not by
//! the crate `dicom-object`, because sequences inside each other overflow its stack and end the program. Source: NEMA PS3.

mod elements;
mod file;
mod image;
mod series;

use super::error::{Location, ShapeError, shown};
use super::source::Source;
use super::{Content, Shape, Volume, grid};
use crate::support::open;
use file::{MARK, MARK_AT, with_image};
use glam::Vec3;
use image::Image;
use series::{Layout, Member, layout};
use std::collections::HashMap;
use std::fs;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// Most files of a folder that are looked at: a whole body in slices of half a millimeter.
const MAX_FILES: usize = 4096;

/// Whether the mark of DICOM is behind the first 128 bytes.
pub(super) fn recognizes(start: &[u8], _len: u64) -> bool {
    start.get(MARK_AT..).is_some_and(|rest| rest.starts_with(MARK))
}

/// Reads the series that the slice is of from the files beside it, or the frames of a file that has several.
///
/// Integers of 8 to 32 bits with their slopes and intercepts become f32; pixels that are compressed are refused.
pub(super) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    let (name, folder) = (source.file.clone(), source.folder.clone());
    let read = with_image(source, |source, image| {
        if image.frames.len() < 2 && folder.is_some() {
            return Ok(Err(image.series)); // one slice of several
        }
        image.check(&source.file)?;
        let members = [Member { path: PathBuf::new(), image }];
        let mut volume = Filled::new(&source.file, layout(&source.file, &members)?)?;
        volume.fill(source, &members[0].image, 0)?;
        Ok(Ok(volume))
    })?;
    match (read, folder) {
        (Ok(volume), _) => volume.finish(&name),
        (Err(series), folder) => {
            let folder = folder.unwrap_or_default();
            let mut members = members(&name, &folder)?;
            members.retain(|member| member.image.series == series);
            joined(&name, &members)
        }
    }
}

/// Reads the series with the most slices in a folder, the first by the names of its files where several have as many.
pub(super) fn read_folder(name: &str, folder: &Path) -> Result<Shape, ShapeError> {
    let mut members = members(name, folder)?;
    let mut counts = HashMap::new();
    members
        .iter()
        .for_each(|member| *counts.entry(member.image.series.clone()).or_insert(0) += member.image.frames.len());
    let most = counts.values().max().copied();
    let Some(most) =
        members.iter().map(|member| &member.image.series).find(|series| counts.get(*series).copied() == most)
    else {
        return Err(ShapeError::NotAFile { file: name.into(), kind: "a directory" });
    };
    let most = most.clone();
    members.retain(|member| member.image.series == most);
    joined(name, &members)
}

/// All pictures in the files of a folder, by the names of the files.
fn members(name: &str, folder: &Path) -> Result<Vec<Member>, ShapeError> {
    let unreadable = |reason| ShapeError::Unreadable { file: name.into(), reason };
    // A file that is named alone is in the current folder.
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if fs::metadata(&path).is_ok_and(|about| about.is_file()) {
            paths.push(path);
        }
        if paths.len() > MAX_FILES {
            let (place, found) = (Location::Header, format!("more than {MAX_FILES} files"));
            let remedy = "its series are not looked for: put the slices into a folder of their own";
            return Err(ShapeError::Unsupported { file: name.into(), place, what: "a folder of", found, remedy });
        }
    }
    paths.sort();
    let mut members = Vec::new();
    for path in paths {
        let image = with_file(&path, |source| {
            let is_dicom = recognizes(source.peek()?, 0);
            if is_dicom { with_image(source, |_, image| Ok(Some(image))) } else { Ok(None) }
        })?;
        if let Some(image) = image.filter(Image::is_picture) {
            members.push(Member { path, image });
        }
    }
    Ok(members)
}

/// The volume of all frames of `members`.
fn joined(name: &str, members: &[Member]) -> Result<Shape, ShapeError> {
    members.iter().try_for_each(|member| member.image.check(&shown(&member.path.to_string_lossy())))?;
    let mut volume = Filled::new(name, layout(name, members)?)?;
    for (index, member) in members.iter().enumerate() {
        with_file(&member.path, |source| {
            with_image(source, |source, image| {
                if image != member.image {
                    let found = "another one than before".into();
                    return Err(source.malformed_at(Location::Header, "a file that stays as it is", found));
                }
                volume.fill(source, &image, index)
            })
        })?;
    }
    volume.finish(name)
}

fn with_file<T>(path: &Path, read: impl FnOnce(&mut Source) -> Result<T, ShapeError>) -> Result<T, ShapeError> {
    let file = shown(&path.to_string_lossy());
    let opened = open::open(path, u64::MAX);
    let (opened, len) = opened.map_err(|error| ShapeError::Unreadable { file: file.clone(), reason: error.into() })?;
    let mut reader = BufReader::new(opened);
    read(&mut Source { file, len, offset: 0, line: 0, folder: None, reader: &mut reader })
}

/// A volume that is being filled.
struct Filled {
    layout: Layout,
    origin: Vec3,
    spacing: Vec3,
    values: Vec<f32>,
}

impl Filled {
    fn new(file: &str, layout: Layout) -> Result<Filled, ShapeError> {
        let (origin, spacing) = grid::place(file, layout.size, layout.origin, layout.steps)?;
        let values = grid::filled(file, layout.size, 0.0)?;
        Ok(Filled { layout, origin, spacing, values })
    }

    /// Reads the frames of a file, the pixels of which are next in the source, into their slices.
    fn fill(&mut self, source: &mut Source, image: &Image, file: usize) -> Result<(), ShapeError> {
        let pixels = self.layout.size[0] as usize * self.layout.size[1] as usize;
        for (frame, slice) in image.frames.iter().zip(&self.layout.slices[file]) {
            image.values(source, frame, &mut self.values[slice * pixels..][..pixels])?;
        }
        Ok(())
    }

    fn finish(self, file: &str) -> Result<Shape, ShapeError> {
        grid::check_finite(file, &self.values)?;
        let Filled { layout, origin, spacing, values } = self;
        Ok(Shape::Volume(Volume { size: layout.size, origin, spacing, values, content: Content::Scalar }))
    }
}
