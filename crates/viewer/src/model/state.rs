//! The edited scene and its history.

use crate::message::Message;
use hypertexture::scene::{self, Camera, ParameterValue, Parameters, Part, Scene, SceneError, schema};
use hypertexture::shader::slots::MAIN;
use hypertexture::shader::{Library, ParameterKind, Slots};
use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};

/// Number of undo steps, each of a few kilobytes. egui's `Undoer` has steps without names that end with time, and
/// would restore a scene whose modules are gone.
const HISTORY: usize = 256;

/// The edited scene with its modules and its history.
pub struct Model {
    pub(super) scene: Scene,
    pub(super) library: Library,
    pub(super) parameters: Parameters,
    pub(super) parts: BTreeMap<String, Parameters>,
    pub(super) past: VecDeque<Step>,
    pub(super) future: Vec<Step>,
    /// Name of the open undo group.
    pub(super) open: Option<String>,
    pub(super) saved: Scene,
    pub(super) file: Option<PathBuf>,
    /// Texts by the files to which they were written.
    pub(super) written: BTreeMap<PathBuf, String>,
    pub(super) home: Camera,
    /// Time of playback.
    pub(super) clock: Option<f64>,
    pub(super) message: Option<Message>,
}

/// A scene of the history.
pub(super) struct Step {
    scene: Scene,
    what: String,
}

impl Model {
    /// A model of a scene.
    ///
    /// # Errors
    /// Errors of [`Scene::check`] and [`Scene::check_parts`].
    pub fn new(scene: Scene, library: Library) -> Result<Model, SceneError> {
        let (parameters, parts) = checked(&scene, &library)?;
        let saved = scene.clone();
        let (past, future, home) = (VecDeque::new(), Vec::new(), scene.camera.clone());
        Ok(Model {
            scene,
            library,
            parameters,
            parts,
            past,
            future,
            open: None,
            saved,
            file: None,
            written: BTreeMap::new(),
            home,
            clock: None,
            message: None,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The modules.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// The parameters of the main object, or of an additional one, with their values.
    pub fn parameters(&self, part: Option<&str>) -> &Parameters {
        part.and_then(|part| self.parts.get(part)).unwrap_or(&self.parameters)
    }

    /// The text of the last message.
    pub fn message(&self) -> Option<&str> {
        self.notice().map(|message| message.text.as_str())
    }

    /// The last message.
    pub fn notice(&self) -> Option<&Message> {
        self.message.as_ref()
    }

    /// Shows an error.
    pub fn say(&mut self, line: impl Into<String>) {
        self.message = Some(Message::error(line));
    }

    /// The file of the last open or save.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The camera of the last opened preset or file.
    pub fn home(&self) -> &Camera {
        &self.home
    }

    /// Records the file of a custom module in the scene. This is not an undo step.
    pub fn file_module(&mut self, module: &str, file: &str) {
        if self.scene.modules.get(module).is_none_or(|known| known != file) {
            self.scene.modules.insert(module.into(), file.into());
        }
    }

    /// Whether the scene has unsaved changes.
    pub fn is_dirty(&self) -> bool {
        self.scene != self.saved
    }

    /// Changes the scene. Values of undeclared parameters are dropped, and shared settings are copied to all objects.
    /// Edits with the same name `what` are one undo step until [`Model::end_undo_group`].
    ///
    /// Returns whether the change was accepted; if not, [`Model::message`] says why.
    pub fn edit(&mut self, what: &str, change: impl FnOnce(&mut Scene)) -> bool {
        let mut scene = self.present();
        change(&mut scene);
        self.change(what, scene)
    }

    /// Changes the scene to one made of [`Model::present`]; see [`Model::edit`].
    pub fn change(&mut self, what: &str, mut scene: Scene) -> bool {
        self.set_keys(&mut scene);
        self.propose(what, scene)
    }

    /// Replaces the scene; see [`Model::edit`].
    pub fn propose(&mut self, what: &str, mut scene: Scene) -> bool {
        if scene == self.scene {
            return true;
        }
        let normalized = normalize(&mut scene, &self.library).and_then(|()| checked(&scene, &self.library));
        match normalized {
            Err(error) => {
                self.say(error.to_string());
                false
            }
            Ok((parameters, parts)) => {
                let before = std::mem::replace(&mut self.scene, scene);
                if self.open.as_deref() != Some(what) {
                    self.past.push_back(Step { scene: before, what: what.into() });
                    if self.past.len() > HISTORY {
                        self.past.pop_front();
                    }
                }
                self.future.clear();
                (self.parameters, self.parts, self.message) = (parameters, parts, None);
                self.open = Some(what.into());
                true
            }
        }
    }

    /// Ends an undo group.
    pub fn end_undo_group(&mut self) {
        self.open = None;
    }

    /// Name of the step that [`Model::undo`] reverts.
    pub fn undoes(&self) -> Option<&str> {
        self.past.back().map(|step| step.what.as_str())
    }

    /// Name of the step that [`Model::redo`] repeats.
    pub fn redoes(&self) -> Option<&str> {
        self.future.last().map(|step| step.what.as_str())
    }

    /// Undoes the last step; returns whether there was one.
    pub fn undo(&mut self) -> bool {
        while let Some(Step { scene, what }) = self.past.pop_back() {
            if let Some(scene) = self.exchange(scene) {
                self.future.push(Step { scene, what });
                return true;
            }
        }
        false
    }

    /// Repeats the last undone step; returns whether there was one.
    pub fn redo(&mut self) -> bool {
        while let Some(Step { scene, what }) = self.future.pop() {
            if let Some(scene) = self.exchange(scene) {
                self.past.push_back(Step { scene, what });
                return true;
            }
        }
        false
    }

    /// Exchanges the scene with one of the history; `None` if a module of that one no longer exists.
    fn exchange(&mut self, mut scene: Scene) -> Option<Scene> {
        normalize(&mut scene, &self.library).ok()?;
        (self.parameters, self.parts) = checked(&scene, &self.library).ok()?;
        (self.open, self.message) = (None, None);
        Some(std::mem::replace(&mut self.scene, scene))
    }

    /// Replaces the modules. New parameters have their defaults, removed ones are dropped, and values are clamped to
    /// their new ranges.
    ///
    /// # Errors
    /// The scene is invalid with these modules; nothing is changed.
    pub fn set_library(&mut self, library: Library) -> Result<(), SceneError> {
        let mut scene = self.scene.clone();
        normalize(&mut scene, &library)?;
        (self.parameters, self.parts) = checked(&scene, &library)?;
        (self.scene, self.library, self.message) = (scene, library, None);
        Ok(())
    }

    /// Adds an object and appends it to the formula. Returns its name.
    pub fn add_part(&mut self, input: &str) -> Option<String> {
        let name = (1..).map(|number| format!("object{number}")).find(|name| !self.scene.parts.contains_key(name))?;
        let mut part = Part::default();
        part.object.input = input.into();
        part.transform = scene::Transform { at: [1.0, 0.0, 0.0], scale: 0.5, ..part.transform };
        let good = self.edit(&format!("add {name}"), |scene| {
            scene.parts.insert(name.clone(), part);
            if let Some(formula) = &mut scene.combine {
                formula.push_str(&format!(" | {name}"));
            }
        });
        self.end_undo_group();
        good.then_some(name)
    }

    /// Removes an additional object. A formula that names it is replaced by the union.
    pub fn remove_part(&mut self, name: &str) -> bool {
        let good = self.edit(&format!("remove {name}"), |scene| {
            scene.parts.remove(name);
            let uses = scene.formula().is_ok_and(|formula| formula.objects().contains_key(name));
            if uses || scene.parts.is_empty() {
                scene.combine = None;
            }
        });
        self.end_undo_group();
        good
    }

    /// Renames an additional object, also in the formula and in its tracks.
    pub fn rename_part(&mut self, from: &str, to: &str) -> bool {
        if to == MAIN || self.scene.parts.contains_key(to) {
            self.say(format!("parts.{from}: `{to}` is the name of another object; choose one that no object has"));
            return false;
        }
        let good = self.edit(&format!("rename {from}"), |scene| {
            if let Some(part) = scene.parts.remove(from) {
                scene.parts.insert(to.into(), part);
            }
            scene.combine = scene.combine.as_deref().map(|formula| renamed(formula, from, to));
            let [own, new] = [from, to].map(|name| format!("parts.{name}."));
            let tracks = std::mem::take(&mut scene.animation.tracks).into_iter();
            let tracks = tracks.map(|(field, track)| match field.strip_prefix(&own) {
                Some(rest) => (format!("{new}{rest}"), track),
                None => (field, track),
            });
            scene.animation.tracks = tracks.collect();
        });
        self.end_undo_group();
        good
    }

    /// The command line that renders the same picture.
    pub fn command_line(&self) -> String {
        self.scene.command_line(&self.library)
    }
}

/// A formula with another name for an object.
fn renamed(formula: &str, from: &str, to: &str) -> String {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let pieces = formula.split_inclusive(|c: char| !is_name(c));
    let piece = |piece: &str| match piece.trim_end_matches(|c: char| !is_name(c)) {
        name if name == from => piece.replacen(from, to, 1),
        _ => piece.into(),
    };
    pieces.map(piece).collect()
}

fn checked(scene: &Scene, library: &Library) -> Result<(Parameters, BTreeMap<String, Parameters>), SceneError> {
    let parameters = scene.check(library)?;
    Ok((parameters, scene.check_parts(library)?))
}

/// Copies shared settings to all objects, and drops undeclared parameters.
fn normalize(scene: &mut Scene, library: &Library) -> Result<(), SceneError> {
    let shared = scene.effect.clone();
    for part in scene.parts.values_mut() {
        for ((slot, own), (_, scene)) in part.effect.modules_mut().into_iter().zip(shared.modules()) {
            if schema::is_shared(slot) {
                own.clone_from(scene);
            }
        }
    }
    let mut slots: Slots = scene.slots(library);
    let objects = scene.parts.keys().map(|name| format!("{name}.object")).chain(["object".into()]);
    slots.extend(objects.collect::<Vec<_>>().into_iter().map(|slot| (slot, vec!["normals".into()])));
    let declared = library.declarations(&scene.entries(), &slots)?.parameters;
    keep_declared(&mut scene.parameters, &declared);
    let is_declared = |name: &str| declared.iter().any(|parameter| parameter.name == name);
    scene.animation.tracks.retain(|field, _| field.strip_prefix("parameters.").is_none_or(is_declared));
    for (name, part) in &mut scene.parts {
        keep_declared(&mut part.parameters, &library.object_declarations(name, &slots)?.parameters);
    }
    Ok(())
}

/// Drops undeclared parameters, and clamps the others to their ranges.
fn keep_declared(values: &mut BTreeMap<String, ParameterValue>, declared: &[hypertexture::shader::Parameter]) {
    values.retain(|name, value| {
        let parameter = declared.iter().find(|parameter| parameter.name == *name);
        match (parameter.map(|parameter| parameter.kind), value) {
            (Some(ParameterKind::Number(_, [low, high])), ParameterValue::Number(value)) => {
                *value = value.clamp(low, high);
                true
            }
            (Some(ParameterKind::Color(_)), ParameterValue::Color(_)) => true,
            _ => false,
        }
    });
}
