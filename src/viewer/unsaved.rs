//! What no file holds when the window closes, so that nothing is lost.

use super::author::Author;
use super::model::Model;
use crate::support::{open, write_whole};
use crate::{scene, shader};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Writes the scene and the texts of modules that no file holds into `folder`, which is made; whether there are any. The
/// scene finds its own modules there.
///
/// # Errors
/// The folder cannot be written to.
pub fn keep(model: &Model, author: &Author, folder: &Path) -> Result<bool, String> {
    let mut files = texts(model, author);
    if model.is_dirty() {
        let (mut scene, shipped) = (model.scene().clone(), shader::shipped());
        for path in files.keys().filter(|path| shipped.source(path).is_none()) {
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

/// Folders of the cache in which something was kept, the newest first.
pub(super) fn kept() -> Vec<PathBuf> {
    let root = crate::support::disk_cache::default_folder().map(|folder| folder.join("unsaved"));
    let entries = root.and_then(|root| fs::read_dir(root).ok()).into_iter().flatten();
    let holds = |folder: &PathBuf| fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    let mut folders: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(holds).collect();
    folders.sort();
    folders.reverse();
    folders
}

/// The texts of modules in such a folder.
pub(super) fn modules(folder: &Path) -> Vec<PathBuf> {
    let within =
        |folder: &Path| fs::read_dir(folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    let mut files: Vec<PathBuf> = within(folder).flat_map(|slot| within(&slot).collect::<Vec<_>>()).collect();
    files.sort();
    files
}

/// A folder of the cache that nothing was kept in yet.
pub(super) fn folder() -> Option<PathBuf> {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    Some(crate::support::disk_cache::default_folder()?.join("unsaved").join(now.as_millis().to_string()))
}

/// Texts of modules that neither ship nor are in a file, by their paths in the library.
pub fn texts(model: &Model, author: &Author) -> BTreeMap<String, String> {
    let filed = model.scene().library().unwrap_or_else(|_| shader::shipped());
    let mut texts: BTreeMap<String, String> =
        model.library().sources().map(|(path, text)| (path.to_string(), text.to_string())).collect();
    // What is being written goes before what was good.
    texts.extend(author.drafts().map(|(path, text)| (path.to_string(), text.to_string())));
    texts.insert(author.path(), author.text.clone());
    let shipped = shader::shipped();
    let followed = |file: &Path| open::text(file, super::author::MAX_FILE).ok();
    let followed = author.file().and_then(followed).map(|text| (author.path(), text));
    texts.retain(|path, text| {
        let held = [filed.source(path), shipped.source(path)];
        !held.contains(&Some(text.as_str())) && followed.as_ref() != Some(&(path.clone(), text.clone()))
    });
    texts
}
