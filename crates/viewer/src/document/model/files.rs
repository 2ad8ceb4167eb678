//! Scene files.

use super::state::Model;
use crate::document::painting::{adopted, is_version};
use crate::message::Message;
use hypertexture::output::{OutputError, read_provenance};
use hypertexture::render::settle_lengths;
use hypertexture::scene::{self, Reach, Scene, SceneError};
use hypertexture::shader::Library;
use hypertexture_measure::guard::edited;
use hypertexture_support::{open, write_whole};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl Model {
    /// Opens a scene file, or the scene of a picture; a file of any other kind becomes the object.
    pub fn open(&mut self, path: &Path) -> bool {
        let name = path.display().to_string();
        let ends =
            |ends: &[&str]| path.extension().is_some_and(|end| ends.iter().any(|own| end.eq_ignore_ascii_case(own)));
        let is_picture = ends(&["png", "exr"]);
        if !is_picture && !ends(&["toml"]) {
            let is_other = self.scene.object.input != name;
            let good = self.edit("object.input", |scene| scene.replace_object(&name));
            self.end_undo_group();
            if good && is_other {
                // Another object is framed.
                self.look(|camera| (camera.pan, camera.zoom) = ([0.0; 2], 1.0));
                (self.home.pan, self.home.zoom) = ([0.0; 2], 1.0);
            }
            return good;
        }
        let loaded = if is_picture {
            scene_of_picture(path).map_err(|error| error.to_string())
        } else {
            scene::load(path, Reach::Beside).map_err(|error| error.to_string()).and_then(|mut scene| {
                settle_lengths(&mut scene).map_err(|error| error.to_string())?;
                Ok(scene)
            })
        };
        let opened = loaded.and_then(|scene| {
            let library = self.with_modules_of(&scene).map_err(|error| error.to_string())?;
            Ok((scene, self.replace_library(library)))
        });
        let (scene, library) = match opened {
            Ok(opened) => opened,
            Err(reason) => {
                self.say(reason);
                return false;
            }
        };
        let good = self.propose(&format!("open {name}"), scene);
        if good {
            self.end_undo_group();
            self.set_saved(self.scene.clone());
            self.file = (!is_picture).then(|| path.into());
            self.home.clone_from(&self.scene.camera);
        } else {
            self.library = library;
        }
        good
    }

    /// Restores a scene that was kept: it stays unsaved, and is that of its former file.
    pub(crate) fn restore(&mut self, path: &Path, origin: Option<PathBuf>) -> bool {
        let opened = scene::load(path, Reach::Anywhere).and_then(|scene| {
            let library = self.with_modules_of(&scene)?;
            Ok((scene, self.replace_library(library)))
        });
        let (scene, library) = match opened {
            Ok(opened) => opened,
            Err(error) => {
                self.say(error.to_string());
                return false;
            }
        };
        let scene = Scene { groom: scene.groom.map(|file| adopted(&file)), ..scene };
        let good = self.propose("restore unsaved work", scene);
        if good {
            self.end_undo_group();
            // The present content of the file; without one, the scene is unsaved as a whole.
            let saved = origin.as_deref().and_then(|file| scene::load(file, Reach::Anywhere).ok());
            self.set_saved(Arc::new(saved.unwrap_or_default()));
            self.file = origin;
            self.home.clone_from(&self.scene.camera);
        } else {
            self.library = library;
        }
        good
    }

    /// The current library with the modules of a scene's files.
    fn with_modules_of(&self, scene: &Scene) -> Result<Library, SceneError> {
        let own = scene.library()?;
        let modules = scene.modules.keys().filter_map(|module| module.split_once('/'));
        Ok(modules.fold((*self.library).clone(), |library, (slot, name)| {
            let text = own.source(&format!("{slot}/{name}.glsl")).unwrap_or_default();
            library.with_module(slot, name, text)
        }))
    }

    /// Whether saving would replace content that this model did not write.
    pub fn would_replace(&self, path: &Path) -> bool {
        let held = open::text(path, scene::MAX_BYTES).ok();
        path.exists() && (held.is_none() || held.as_ref() != self.written.get(path))
    }

    /// The scene for a file, with a painted groom copied beside it.
    fn groom_beside(&self, path: &Path) -> Result<Scene, String> {
        let mut scene = (*self.scene).clone();
        if let Some(version) = self.scene.groom.as_deref().filter(|file| is_version(file)) {
            let own = path.with_extension("groom.nrrd");
            let copied = fs::read(version).and_then(|bytes| write_whole(&own, &bytes));
            copied.map_err(|error| format!("{}: {error}; nothing was written", own.display()))?;
            scene.groom = own.file_name().map(|name| name.to_string_lossy().into_owned());
        }
        Ok(scene)
    }

    /// Writes the scene, complete with defaults, as one atomic replacement of the file.
    pub fn save(&mut self, path: &Path) -> bool {
        let text = match self.groom_beside(path) {
            Ok(scene) => scene::to_text(&scene),
            Err(reason) => {
                self.say(reason);
                return false;
            }
        };
        match write_whole(path, text.as_bytes()) {
            Ok(()) => {
                self.written.insert(path.into(), text);
                self.set_saved(self.scene.clone());
                self.file = Some(path.into());
                let edited = edited(&*self.scene, &self.library).unwrap_or_default();
                let missing = if edited.is_empty() {
                    String::new()
                } else {
                    format!(
                        "; save these modules as files too, scene files do not contain their text: {}",
                        edited.join(", ")
                    )
                };
                self.message = Some(Message::note(format!("wrote {}{missing}", path.display())));
                true
            }
            Err(error) => {
                self.say(format!("{}: {error}; nothing was written", path.display()));
                false
            }
        }
    }
}

/// The scene in the metadata of a picture.
fn scene_of_picture(path: &Path) -> Result<Scene, OutputError> {
    let of = |source| OutputError::Provenance { path: path.display().to_string(), source };
    let (provenance, reach) = (read_provenance(path)?, Reach::Beside);
    let scene = provenance.scene(path, reach).map_err(of)?;
    if let Err(changed) = provenance.check_inputs(path, reach) {
        log::warn!("{}", of(changed));
    }
    Ok(scene)
}
