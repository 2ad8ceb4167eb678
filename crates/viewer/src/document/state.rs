//! The state of the document, and the commands that concern nothing else.

use super::author::Author;
use super::exports::{Exports, up_of_print};
use super::model::Model;
use super::painting::Painting;
use super::selection::Selection;
use super::unsaved;
use crate::input::Command;
use hypertexture::shader::LibraryError;
use std::path::{Path, PathBuf};

/// The scene, and the state of its edits that needs no window.
pub struct Document {
    /// The scene with its modules and its history.
    pub model: Model,
    /// The edited module.
    pub author: Author,
    pub(crate) painting: Painting,
    pub(crate) exports: Exports,
    pub(crate) selection: Selection,
    /// The folder of unsaved work that was restored since the last look.
    pub(crate) restored: Option<PathBuf>,
}

impl Document {
    /// A document of a model. `program` is the executable of hypertexture, which compiles edited modules.
    ///
    /// # Errors
    /// The library lacks the first module of the effect.
    pub fn new(model: Model, program: PathBuf) -> Result<Document, LibraryError> {
        let effect = &model.scene().effect;
        let first = effect.dmf.first().map(|name| ("dmf", name.split('@').next().unwrap_or_default()));
        let (slot, name) = first.unwrap_or(("surface", &effect.surface));
        let author = Author::new(program, model.library(), slot, name)?;
        let exports = Exports::new(author.gate().clone());
        let (painting, selection) = (Painting::default(), Selection::default());
        Ok(Document { model, author, painting, exports, selection, restored: None })
    }

    /// Whether there is unsaved work.
    pub fn is_unsaved(&self) -> bool {
        self.model.is_dirty() || !unsaved::texts(&self.model, &self.author).is_empty()
    }

    /// Description of work that would end with the window: unsaved work, and a final picture in progress.
    pub fn at_stake(&self) -> Option<String> {
        let kept = |what: &str| format!("{what} is not saved. It is kept, and offered at the next start.");
        let unsaved = if self.model.is_dirty() {
            Some(kept("The scene"))
        } else {
            self.is_unsaved().then(|| kept("The text of a module"))
        };
        let running = self.exports.progress().map(|progress| format!("The running render also ends ({progress})."));
        let all: Vec<String> = unsaved.into_iter().chain(running).collect();
        (!all.is_empty()).then(|| all.join("\n"))
    }

    /// Begins a scene of the print that was written last; returns whether it did.
    pub(crate) fn look_at_print(&mut self) -> bool {
        let Some(order) = self.exports.written().map(|written| &written.order) else { return false };
        let path = std::path::absolute(&order.path).unwrap_or_else(|_| order.path.clone());
        let up = up_of_print(&order.scene.object, &path);
        self.selection.select(None);
        self.model.look_at_print(&path, up)
    }

    /// Opens a mesh, a scan or a scene file as the scene, or a module to edit; returns whether it is a module. If it
    /// cannot be opened, [`Model::message`] says why.
    pub(crate) fn open(&mut self, path: &Path) -> bool {
        if path.extension().is_none_or(|end| end != "glsl") {
            self.model.open(path);
            return false;
        }
        let watched = self.author.watch(self.model.library(), path);
        watched.map_err(|reason| self.model.say(reason)).is_ok()
    }

    /// Performs a command that concerns only the document; returns any other.
    pub(crate) fn perform(&mut self, command: Command) -> Option<Command> {
        match command {
            Command::Restore(folder) => {
                // Work that cannot be opened as a whole is offered again.
                if unsaved::restore(&folder, &mut self.model, &mut self.author) {
                    self.restored = Some(folder);
                }
            }
            Command::Undo => drop(self.model.undo()),
            Command::Redo => drop(self.model.redo()),
            Command::Preset { name, on_object } => drop(match self.selection.part().filter(|_| on_object) {
                Some(part) => self.model.take_preset_of_part(part, &name),
                None => self.model.take_preset(&name, on_object),
            }),
            Command::AddPart => {
                if let Some(name) = self.model.add_part("sphere") {
                    self.selection.select(Some(name));
                }
            }
            Command::RemovePart(name) => {
                self.selection.locked.remove(&name);
                self.model.remove_part(&name);
            }
            Command::RenamePart { from, to } => {
                if self.model.rename_part(&from, &to) {
                    self.selection.rename(&from, to);
                }
            }
            other => return Some(other),
        }
        None
    }
}
