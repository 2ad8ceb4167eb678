//! Painting of the groom: its versions, and the current stroke.
//!
//! Role: a stroke becomes a new file in the cache, which the scene names, so that undo, other processes and the next start have
//! it. Invariant: the groom that a scene names is that of its file.

use hypertexture::glam::Vec3;
use hypertexture::render::Subject;
use hypertexture::scene::Scene;
use hypertexture::shape::{Brush, BrushKind, Groom};
use hypertexture_support::{disk_cache, write_whole_by};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// Versions in memory; others are read from their files.
const IN_MEMORY: usize = 8;
/// Versions on disk: more than undo steps.
const FILES: usize = 1024;
/// Voxels along a side of a new groom.
const SIDE: u32 = 96;
/// Distance between touches of a stroke, in radii of the brush.
const STEP: f32 = 0.25;
/// Most touches between two frames. Higher: a fast stroke of a small brush stalls.
const TOUCHES: f32 = 48.0;

/// Why a scene of several objects has no groom.
pub(crate) const SEVERAL: &str = "a groom needs a scene of one object: remove the others to paint";

/// The brush, the versions of the groom and the current stroke.
pub struct Painting {
    /// Whether a drag paints.
    pub is_on: bool,
    /// The brush.
    pub brush: Brush,
    /// Versions by their files, the latest last.
    kept: Vec<(String, Arc<Groom>)>,
    stroke: Option<Stroke>,
    /// The latest object with its groom.
    latest: Option<(Arc<Subject>, Arc<Subject>)>,
    /// The touches of the last stroke.
    trace: Option<Arc<Trace>>,
    /// Number of changes of the groom.
    revision: u64,
}

/// A touch of the brush.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Touch {
    at: Vec3,
    radius: f32,
    is_mirrored: bool,
}

impl Touch {
    /// Centers of the touched places, and their radius, object units.
    pub(crate) fn places(&self) -> impl Iterator<Item = (Vec3, f32)> + use<> {
        let Touch { at, radius, is_mirrored } = *self;
        let other = is_mirrored.then_some(Vec3::new(-at.x, at.y, at.z));
        [Some(at), other].into_iter().flatten().map(move |at| (at, radius))
    }
}

/// The touches of a stroke, and the names of the grooms before and after it.
#[derive(Clone, Debug)]
pub(crate) struct Trace {
    before: Option<String>,
    file: String,
    touches: Vec<Touch>,
}

impl Trace {
    /// Number of touches in a groom, by the name that a scene has for it; `None` for a groom that is not of this stroke.
    fn count(&self, groom: Option<&str>) -> Option<usize> {
        if groom == self.before.as_deref() {
            return Some(0);
        }
        match groom?.strip_prefix(self.file.as_str())? {
            "" => Some(self.touches.len()),
            number => number.strip_prefix('#')?.parse().ok(),
        }
    }

    /// The touches by which two grooms differ, by the names that scenes have for them; `None` if one is not of this
    /// stroke.
    pub(crate) fn between(&self, one: Option<&str>, other: Option<&str>) -> Option<&[Touch]> {
        let (one, other) = (self.count(one)?, self.count(other)?);
        self.touches.get(one.min(other)..one.max(other))
    }
}

struct Stroke {
    groom: Arc<Groom>,
    file: String,
    touches: u64,
    last: Vec3,
}

impl Default for Painting {
    fn default() -> Painting {
        let brush = Brush { kind: BrushKind::default(), radius: 0.15, strength: 0.3, color: [1.0; 3], mirrored: false };
        Painting { is_on: false, brush, kept: Vec::new(), stroke: None, latest: None, trace: None, revision: 0 }
    }
}

impl Painting {
    /// The groom that a scene names.
    fn groom(&mut self, scene: &Scene) -> Result<Option<Arc<Groom>>, String> {
        let Some(file) = &scene.groom else { return Ok(None) };
        if let Some(found) = self.kept.iter().position(|(known, _)| known == file) {
            let last = self.kept.remove(found);
            self.kept.push(last);
        } else {
            let groom = Groom::read(Path::new(file)).map_err(|error| error.to_string())?;
            self.keep(file.clone(), Arc::new(groom));
        }
        Ok(self.kept.last().map(|(_, groom)| groom.clone()))
    }

    fn keep(&mut self, file: String, groom: Arc<Groom>) {
        self.kept.push((file, groom));
        if self.kept.len() > IN_MEMORY {
            self.kept.remove(0);
        }
    }

    /// The object of a scene with its groom, or with that of the stroke, of which the scene then names the last touch.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(crate) fn on(&mut self, subject: Arc<Subject>, scene: &mut Scene) -> Result<Arc<Subject>, String> {
        let groom = match &self.stroke {
            Some(stroke) if scene.groom.as_ref() == Some(&stroke.file) => {
                scene.groom = Some(format!("{}#{}", stroke.file, stroke.touches));
                Some(stroke.groom.clone())
            }
            _ => self.groom(scene)?,
        };
        let Some(groom) = groom else { return Ok(subject) };
        let same = |own: &Subject| own.groom.as_ref().is_some_and(|own| Arc::ptr_eq(own, &groom));
        match &self.latest {
            Some((base, own)) if Arc::ptr_eq(base, &subject) && same(own) => Ok(own.clone()),
            _ => {
                let own = Arc::new(Subject { groom: Some(groom), ..(*subject).clone() });
                self.latest = Some((subject, own.clone()));
                Ok(own)
            }
        }
    }

    /// Number of changes of the groom: touches, and ends of strokes.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    /// The touches of the last stroke.
    pub(crate) fn trace(&self) -> Option<Arc<Trace>> {
        self.trace.clone()
    }

    /// Whether a stroke is being painted.
    pub(crate) fn is_stroke(&self) -> bool {
        self.stroke.is_some()
    }

    /// The groom of the stroke that is being painted.
    pub(crate) fn stroke(&self) -> Option<Arc<Groom>> {
        self.stroke.as_ref().map(|stroke| stroke.groom.clone())
    }

    /// Begins a stroke at a place of the surface. Returns the file that the scene is to name.
    ///
    /// # Errors
    /// The scene's groom cannot be read, or there is no cache.
    pub(crate) fn begin(&mut self, scene: &Scene, at: Vec3, normal: Vec3) -> Result<String, String> {
        let groom = self.groom(scene)?;
        let groom = groom.unwrap_or_else(|| Arc::new(Groom::unpainted(&scene.object.input, SIDE)));
        let file = new_file().ok_or("there is no cache folder for the groom; set HYPERTEXTURE_CACHE")?;
        let file = file.display().to_string();
        self.stroke = Some(Stroke { groom, file: file.clone(), touches: 0, last: at });
        let before = scene.groom.clone();
        self.trace = Some(Arc::new(Trace { before, file: file.clone(), touches: Vec::new() }));
        self.touch(at, normal, Vec3::ZERO);
        Ok(file)
    }

    /// Continues a stroke to a place of the surface.
    pub(crate) fn go(&mut self, at: Vec3, normal: Vec3) {
        let Some(stroke) = &self.stroke else { return };
        let (from, way) = (stroke.last, at - stroke.last);
        let touches = (way.length() / (STEP * self.brush.radius)).floor().min(TOUCHES);
        for touch in 1..=touches as u32 {
            self.touch(from + way * (touch as f32 / touches), normal, way);
        }
    }

    fn touch(&mut self, at: Vec3, normal: Vec3, motion: Vec3) {
        let Some(stroke) = &mut self.stroke else { return };
        self.brush.touch(Arc::make_mut(&mut stroke.groom), at, normal, motion);
        (stroke.last, stroke.touches) = (at, stroke.touches + 1);
        self.revision += 1;
        if let Some(trace) = &mut self.trace {
            let Brush { radius, mirrored, .. } = self.brush;
            Arc::make_mut(trace).touches.push(Touch { at, radius, is_mirrored: mirrored });
        }
    }

    /// Drops the stroke.
    pub(crate) fn cancel(&mut self) {
        (self.stroke, self.trace) = (None, None);
        self.revision += 1;
    }

    /// Ends the stroke, and writes its file.
    ///
    /// # Errors
    /// The file cannot be written; the groom stays in memory.
    pub(crate) fn end(&mut self) -> Result<(), String> {
        let Some(Stroke { groom, file, .. }) = self.stroke.take() else { return Ok(()) };
        self.revision += 1;
        self.keep(file.clone(), groom.clone());
        let path = Path::new(&file);
        let folder = fs::create_dir_all(path.parent().unwrap_or(Path::new(".")));
        let written = folder.and_then(|()| write_whole_by(path, |to| groom.write(to)));
        sweep();
        written.map_err(|error| format!("{file}: {error}; the stroke is not kept"))
    }
}

/// Whether a groom is a version in the cache, which saving copies beside the scene.
pub(crate) fn is_version(file: &str) -> bool {
    folder().is_some_and(|folder| Path::new(file).starts_with(folder))
}

/// A version in the cache of the groom in another file, or that file.
pub(crate) fn adopted(file: &str) -> String {
    let linked = new_file().filter(|own| {
        let folder = fs::create_dir_all(own.parent().unwrap_or(Path::new(".")));
        folder.and_then(|()| fs::hard_link(file, own).or_else(|_| fs::copy(file, own).map(drop))).is_ok()
    });
    linked.map_or_else(|| file.into(), |own| own.display().to_string())
}

fn folder() -> Option<PathBuf> {
    Some(disk_cache::default_folder()?.join("grooms"))
}

/// Removes the oldest versions on disk.
fn sweep() {
    let entries = folder().and_then(|folder| fs::read_dir(folder).ok()).into_iter().flatten();
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.sort();
    files.truncate(files.len().saturating_sub(FILES));
    files.iter().filter_map(|file| fs::remove_file(file).err()).for_each(|error| log::debug!("{error}"));
}

/// A file name that no version has.
fn new_file() -> Option<PathBuf> {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    Some(folder()?.join(format!("{}.nrrd", now.as_nanos())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grooms_of_a_stroke_differ_by_its_touches() {
        let touch = |x: f32| Touch { at: Vec3::new(x, 0.0, 0.0), radius: 0.1, is_mirrored: false };
        let touches: Vec<Touch> = [0.1, 0.2, 0.3].map(touch).into();
        let trace = Trace { before: Some("a.nrrd".into()), file: "b.nrrd".into(), touches: touches.clone() };
        let between = |one: &str, other: &str| trace.between(Some(one), Some(other)).map(<[Touch]>::to_vec);
        assert_eq!(between("a.nrrd", "b.nrrd#2"), Some(touches[..2].to_vec()));
        assert_eq!(between("b.nrrd#2", "b.nrrd"), Some(touches[2..].to_vec()));
        assert_eq!(between("b.nrrd", "a.nrrd"), Some(touches.clone()), "undone");
        assert_eq!(between("b.nrrd#3", "b.nrrd"), Some(Vec::new()));
        assert_eq!(between("b.nrrd#4", "b.nrrd"), None);
        assert_eq!(between("c.nrrd", "b.nrrd"), None);
        assert_eq!(trace.between(None, Some("b.nrrd")), None);
        let mirrored = Touch { is_mirrored: true, ..touch(0.5) };
        assert_eq!(mirrored.places().map(|(at, _)| at.x).collect::<Vec<_>>(), [0.5, -0.5]);
    }
}
