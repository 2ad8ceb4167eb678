//! Unsaved work, kept in the cache within seconds of a change, and when the window closes or fails.
//!
//! Role: the newest work -> a folder that appears whole and replaces the one before it. Invariant: a version of the work is on
//! disk from a few seconds after the first change until it is saved.

mod latest;
#[cfg(test)]
mod tests;

pub(crate) use latest::Latest;

use super::author::Author;
use super::model::Model;
use super::painting;
use hypertexture::scene::{self, GLSL, Scene};
use hypertexture::shader::{self, Library};
use hypertexture::shape::Groom;
use hypertexture_support::{open, write_whole, write_whole_by};
use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};
use std::time::SystemTime;

/// Shipped modules.
static SHIPPED: LazyLock<Library> = LazyLock::new(shader::shipped);

/// Files of a folder: the scene, its groom, the path of its own file, the lock of a window that is open.
const SCENE: &str = "scene.toml";
const GROOM: &str = "groom.nrrd";
const ORIGIN: &str = "file";
const LOCK: &str = "window";
/// File of a folder whose work another window has taken over.
const RESTORED: &str = "restored";
/// Size limit of the path of a file, bytes.
const MAX_PATH: u64 = 1 << 14;
/// Extension of a folder that is being written.
const PART: &str = "part";

/// Unsaved work: a scene with its groom and its file, and texts of modules by path.
#[derive(Clone, Default)]
pub struct Unsaved {
    scene: Option<Arc<Scene>>,
    /// The file of the scene.
    origin: Option<PathBuf>,
    /// The groom of a stroke that goes on, whose file is not written yet.
    groom: Option<Arc<Groom>>,
    texts: BTreeMap<String, String>,
}

impl Unsaved {
    /// The current unsaved work.
    pub fn of(model: &Model, author: &Author) -> Unsaved {
        let scene = model.is_dirty().then(|| model.shared_scene().clone());
        let origin = model.file().and_then(|file| std::path::absolute(file).ok());
        Unsaved { scene, origin, groom: None, texts: texts(model, author) }
    }

    fn is_empty(&self) -> bool {
        self.scene.is_none() && self.texts.is_empty()
    }

    /// Writes the unsaved work to a new folder, which appears whole; returns whether there is any. The scene names its files
    /// by whole paths, and its groom and custom modules in that folder.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn keep(&self, folder: &Path) -> Result<bool, String> {
        Ok(self.keep_locked(folder)?.is_some())
    }

    /// As [`Unsaved::keep`]; returns the lock that marks the folder as that of an open window.
    fn keep_locked(&self, folder: &Path) -> Result<Option<File>, String> {
        if self.is_empty() {
            return Ok(None);
        }
        let part = folder.with_extension(PART);
        let fail = |error: io::Error| format!("{}: {error}", part.display());
        fs::create_dir_all(&part).map_err(fail)?;
        let lock = File::create(part.join(LOCK)).map_err(fail)?;
        // Some file systems have no locks; the folder is then offered while its window is open.
        let _ = lock.try_lock();
        let mut files = self.texts.clone();
        if let Some(mut scene) = self.scene.as_deref().cloned() {
            absolute(&mut scene);
            for path in files.keys().filter(|path| SHIPPED.source(path).is_none()) {
                let module = path.strip_suffix(".glsl").unwrap_or(path);
                scene.modules.insert(module.into(), folder.join(path).display().to_string());
            }
            if let Some(file) = scene.groom.as_deref().filter(|file| painting::is_version(file)) {
                let own = part.join(GROOM);
                let kept = match &self.groom {
                    Some(groom) => write_whole_by(&own, |to| groom.write(to)),
                    None => fs::hard_link(file, &own).or_else(|_| fs::copy(file, &own).map(drop)),
                };
                kept.map_err(fail)?;
                scene.groom = Some(folder.join(GROOM).display().to_string());
            }
            files.insert(SCENE.into(), scene::to_text(&scene));
            if let Some(origin) = &self.origin {
                files.insert(ORIGIN.into(), origin.display().to_string());
            }
        }
        for (name, text) in &files {
            let path = part.join(name);
            fs::create_dir_all(path.parent().unwrap_or(&part)).map_err(fail)?;
            write_whole(&path, text.as_bytes()).map_err(fail)?;
        }
        fs::rename(&part, folder).map_err(fail)?;
        Ok(Some(lock))
    }
}

/// Makes the paths of existing files whole, since the next window may start in another folder.
fn absolute(scene: &mut Scene) {
    let inputs = scene.parts.values_mut().map(|part| &mut part.object.input).chain([&mut scene.object.input]);
    for file in inputs.chain(scene.modules.values_mut()).chain(&mut scene.groom) {
        let is_file = !file.starts_with(GLSL) && Path::new(file.as_str()).exists();
        let is_built_in = hypertexture::shape::BUILT_IN.contains(&file.as_str());
        if let (true, false, Ok(whole)) = (is_file, is_built_in, std::path::absolute(file.as_str())) {
            *file = whole.display().to_string();
        }
    }
}

fn remove(folder: &Path) {
    if let Err(error) = fs::remove_dir_all(folder)
        && error.kind() != io::ErrorKind::NotFound
    {
        log::info!("{}: {error}", folder.display());
    }
}

/// Ends the offer of restored work. Its modules stay, since the scene names their files.
fn take_over(folder: &Path) {
    if modules(folder).is_empty() {
        remove(folder);
    } else {
        let _ = fs::write(folder.join(RESTORED), ""); // if this fails, the work is offered again
    }
}

/// Folders with unsaved work of windows that are closed, the newest first.
pub(crate) fn kept() -> Vec<PathBuf> {
    root().map_or(Vec::new(), |root| kept_in(&root))
}

fn kept_in(root: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(root).into_iter().flatten();
    let holds = |folder: &PathBuf| {
        let is_open =
            File::open(folder.join(LOCK)).is_ok_and(|lock| matches!(lock.try_lock(), Err(TryLockError::WouldBlock)));
        let is_whole = folder.extension().is_none() && !folder.join(RESTORED).exists();
        let has_files = || fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
        is_whole && !is_open && has_files()
    };
    let mut folders: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(holds).collect();
    folders.sort();
    folders.reverse();
    folders
}

/// Opens the work in a folder: the scene, which stays unsaved, and the modules. Returns whether all of it was opened; if
/// not, [`Model::message`] says why.
pub(crate) fn restore(folder: &Path, model: &mut Model, author: &mut Author) -> bool {
    let (scene, origin) = (folder.join(SCENE), open::text(&folder.join(ORIGIN), MAX_PATH).ok());
    if scene.exists() && !model.restore(&scene, origin.map(PathBuf::from)) {
        return false;
    }
    let mut is_whole = true;
    for module in modules(folder) {
        if let Err(error) = author.watch(model.library(), &module) {
            model.say(error);
            is_whole = false;
        }
    }
    is_whole
}

/// The module files in such a folder.
pub(crate) fn modules(folder: &Path) -> Vec<PathBuf> {
    let within =
        |folder: &Path| fs::read_dir(folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    let mut files: Vec<PathBuf> = within(folder).flat_map(|slot| within(&slot).collect::<Vec<_>>()).collect();
    files.sort();
    files
}

/// The folder of unsaved work in the cache.
fn root() -> Option<PathBuf> {
    Some(hypertexture_support::disk_cache::default_folder()?.join("unsaved"))
}

/// The path of a new folder, whose name is the present time.
fn new_folder(root: &Path) -> Option<PathBuf> {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_millis();
    let is_free = |folder: &PathBuf| !folder.exists() && !folder.with_extension(PART).exists();
    (now..).map(|name| root.join(name.to_string())).find(is_free)
}

/// Texts of modules that are neither shipped nor in a file, by path.
pub fn texts(model: &Model, author: &Author) -> BTreeMap<String, String> {
    let shipped = &*SHIPPED;
    let written = author.path();
    // The edited text replaces the last good one.
    let all = model.library().sources().chain(author.drafts()).chain([(written.as_str(), author.text.as_str())]);
    let mut texts: BTreeMap<String, String> = all
        .collect::<BTreeMap<_, _>>()
        .into_iter()
        .filter(|(path, text)| shipped.source(path) != Some(*text))
        .map(|(path, text)| (path.to_string(), text.to_string()))
        .collect();
    if texts.is_empty() {
        return texts; // no file is read for this, which is asked in every frame
    }
    let filed = model.scene().library().unwrap_or_else(|_| shipped.clone());
    let followed = |file: &Path| open::text(file, super::author::MAX_FILE).ok();
    let followed = author.file().and_then(followed).map(|text| (author.path(), text));
    texts.retain(|path, text| {
        filed.source(path) != Some(text.as_str()) && followed.as_ref() != Some(&(path.clone(), text.clone()))
    });
    texts
}
