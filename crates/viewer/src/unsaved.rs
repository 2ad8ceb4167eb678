//! Unsaved work, stored when the window closes.

use super::author::Author;
use super::model::Model;
use hypertexture::scene::{self, Scene};
use hypertexture::shader::{self, Library};
use hypertexture_support::{open, write_whole};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::time::SystemTime;

/// Shipped modules.
static SHIPPED: LazyLock<Library> = LazyLock::new(shader::shipped);

/// Unsaved work: a scene, and texts of modules by path.
#[derive(Clone, Default)]
pub struct Unsaved {
    scene: Option<Scene>,
    texts: BTreeMap<String, String>,
}

impl Unsaved {
    /// The current unsaved work.
    pub fn of(model: &Model, author: &Author) -> Unsaved {
        Unsaved { scene: model.is_dirty().then(|| model.scene().clone()), texts: texts(model, author) }
    }

    /// Writes the unsaved work to a folder; returns whether there is any. The scene refers to its custom modules in
    /// that folder.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn keep(&self, folder: &Path) -> Result<bool, String> {
        let mut files = self.texts.clone();
        if let Some(mut scene) = self.scene.clone() {
            for path in files.keys().filter(|path| SHIPPED.source(path).is_none()) {
                let module = path.strip_suffix(".glsl").unwrap_or(path);
                scene.modules.insert(module.into(), folder.join(path).display().to_string());
            }
            files.insert("scene.toml".into(), scene::to_text(&scene));
        }
        for (name, text) in &files {
            let path = folder.join(name);
            let whole = fs::create_dir_all(path.parent().unwrap_or(folder))
                .map_err(|error| error.to_string())
                .and_then(|()| write_whole(&path, text.as_bytes()).map_err(|error| error.to_string()));
            whole.map_err(|error| format!("{}: {error}", path.display()))?;
        }
        Ok(!files.is_empty())
    }
}

/// The newest unsaved work, shared with threads that exit the program.
#[derive(Clone, Default)]
pub(super) struct Latest(Arc<Mutex<Noted>>);

/// The unsaved work, and the module from which it was derived.
#[derive(Default)]
struct Noted {
    module: [String; 2],
    unsaved: Unsaved,
}

impl Latest {
    /// Records changes. Called once per frame.
    pub(super) fn note(&self, model: &Model, author: &Author) {
        let mut noted = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let scene = model.is_dirty().then(|| model.scene());
        let same_text = noted.module[1] == author.text && noted.module[0] == author.path();
        if !same_text || noted.unsaved.scene.as_ref() != scene {
            *noted = Noted { module: [author.path(), author.text.clone()], unsaved: Unsaved::of(model, author) };
        }
    }

    /// Writes the unsaved work to a new folder and returns that; `None` without unsaved work, or on failure.
    pub(super) fn keep(&self) -> Option<PathBuf> {
        let folder = folder()?;
        let noted = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match noted.unsaved.keep(&folder) {
            Ok(any) => any.then_some(folder),
            Err(error) => {
                log::warn!("unsaved work is lost: {error}");
                None
            }
        }
    }
}

/// Folders with unsaved work, the newest first.
pub(super) fn kept() -> Vec<PathBuf> {
    let root = hypertexture_support::disk_cache::default_folder().map(|folder| folder.join("unsaved"));
    let entries = root.and_then(|root| fs::read_dir(root).ok()).into_iter().flatten();
    let holds = |folder: &PathBuf| fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    let mut folders: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(holds).collect();
    folders.sort();
    folders.reverse();
    folders
}

/// The module files in such a folder.
pub(super) fn modules(folder: &Path) -> Vec<PathBuf> {
    let within =
        |folder: &Path| fs::read_dir(folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    let mut files: Vec<PathBuf> = within(folder).flat_map(|slot| within(&slot).collect::<Vec<_>>()).collect();
    files.sort();
    files
}

/// A new folder in the cache.
fn folder() -> Option<PathBuf> {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    Some(hypertexture_support::disk_cache::default_folder()?.join("unsaved").join(now.as_millis().to_string()))
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
