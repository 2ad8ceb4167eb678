//! The edited scene and its history.

use crate::message::Message;
use hypertexture::scene::{Camera, ParameterValue, Parameters, Scene, SceneError, schema};
use hypertexture::shader::{Library, ParameterKind, Slots};
use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Number of undo steps, each of a few kilobytes. egui's `Undoer` has steps without names that end with time, and
/// would restore a scene whose modules are gone.
const HISTORY: usize = 256;

/// The edited scene with its modules and its history. A scene or library that is shared is replaced, not changed, so
/// that others see by its address whether it is still the same.
pub struct Model {
    pub(super) scene: Arc<Scene>,
    pub(super) library: Arc<Library>,
    pub(super) parameters: Parameters,
    pub(super) parts: BTreeMap<String, Parameters>,
    pub(super) past: VecDeque<Step>,
    pub(super) future: Vec<Step>,
    /// Name of the open undo group.
    pub(super) open: Option<String>,
    /// The scene of the file, and whether the present one differs.
    saved: Arc<Scene>,
    is_dirty: bool,
    pub(super) file: Option<PathBuf>,
    /// Texts by the files to which they were written.
    pub(super) written: BTreeMap<PathBuf, String>,
    pub(super) home: Camera,
    /// Time of playback.
    pub(super) clock: Option<f64>,
    pub(super) moment: RefCell<Option<Moment>>,
    pub(super) message: Option<Message>,
}

/// An animated scene at a time.
pub(super) struct Moment {
    pub(super) of: Arc<Scene>,
    pub(super) time: f64,
    pub(super) scene: Arc<Scene>,
}

/// A scene of the history.
pub(super) struct Step {
    scene: Arc<Scene>,
    what: String,
    /// Whether the step itself changed the view, which otherwise stays where it was moved since.
    moves_view: bool,
}

/// A camera with the view and the time of another one.
fn with_view(camera: &Camera, view: &Camera) -> Camera {
    let Camera { azimuth, elevation, rotation, pan, zoom, time, .. } = view.clone();
    Camera { azimuth, elevation, rotation, pan, zoom, time, ..camera.clone() }
}

impl Model {
    /// A model of a scene.
    ///
    /// # Errors
    /// Errors of [`Scene::check`] and [`Scene::check_parts`].
    pub fn new(scene: Scene, library: Library) -> Result<Model, SceneError> {
        let (parameters, parts) = checked(&scene, &library)?;
        let (scene, library) = (Arc::new(scene), Arc::new(library));
        let (past, future, home) = (VecDeque::new(), Vec::new(), scene.camera.clone());
        Ok(Model {
            saved: scene.clone(),
            is_dirty: false,
            scene,
            library,
            parameters,
            parts,
            past,
            future,
            open: None,
            file: None,
            written: BTreeMap::new(),
            home,
            clock: None,
            moment: RefCell::new(None),
            message: None,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene, shared: another one has another address.
    pub(crate) fn shared_scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Replaces the scene; returns the one before.
    fn replace_scene(&mut self, scene: Scene) -> Arc<Scene> {
        let before = std::mem::replace(&mut self.scene, Arc::new(scene));
        self.is_dirty = self.scene != self.saved;
        before
    }

    /// Sets the scene of the file.
    pub(super) fn set_saved(&mut self, saved: Arc<Scene>) {
        self.is_dirty = self.scene != saved;
        self.saved = saved;
    }

    /// The modules.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// The modules, shared: another library has another address.
    pub(crate) fn shared_library(&self) -> &Arc<Library> {
        &self.library
    }

    /// Replaces the modules if they differ; returns those before.
    pub(super) fn replace_library(&mut self, library: Library) -> Arc<Library> {
        let before = self.library.clone();
        if *before != library {
            self.library = Arc::new(library);
        }
        before
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

    /// Makes a file the one of the scene, which was read from it.
    pub(crate) fn set_file(&mut self, file: Option<PathBuf>) {
        self.file = file;
    }

    /// Begins a new scene, the plain one of a sphere.
    pub fn begin(&mut self) -> bool {
        self.begin_with("new scene", "lit", |scene| scene.object.input = "sphere".into())
    }

    /// The camera of the last opened preset or file.
    pub fn home(&self) -> &Camera {
        &self.home
    }

    /// Records the file of a custom module in the scene. This is not an undo step.
    pub fn file_module(&mut self, module: &str, file: &str) {
        if self.scene.modules.get(module).is_none_or(|known| known != file) {
            let mut scene = (*self.scene).clone();
            scene.modules.insert(module.into(), file.into());
            self.replace_scene(scene);
        }
    }

    /// Whether the scene has unsaved changes.
    pub fn is_dirty(&self) -> bool {
        self.is_dirty
    }

    /// Changes the scene. Values of undeclared parameters are dropped, and shared settings are copied to all objects.
    /// Edits with the same name `what` are one undo step until [`Model::end_undo_group`].
    ///
    /// Returns whether the change was accepted; if not, [`Model::message`] says why.
    pub fn edit(&mut self, what: &str, change: impl FnOnce(&mut Scene)) -> bool {
        let mut scene = Arc::unwrap_or_clone(self.present());
        change(&mut scene);
        self.change(what, scene)
    }

    /// Changes the scene to one made of [`Model::present`]; see [`Model::edit`].
    pub fn change(&mut self, what: &str, mut scene: Scene) -> bool {
        self.set_keys(&mut scene);
        self.propose(what, scene)
    }

    /// Moves the view or the time without an undo step; new keyframes of a camera are undo steps.
    pub fn look(&mut self, change: impl FnOnce(&mut Camera)) -> bool {
        if self.scene.animation.tracks.keys().any(|field| field.starts_with("camera.")) {
            return self.edit("camera", |scene| change(&mut scene.camera));
        }
        let mut scene = (*self.scene).clone();
        change(&mut scene.camera);
        match checked(&scene, &self.library) {
            Ok(_) => {
                self.replace_scene(scene);
                true
            }
            Err(error) => {
                self.say(error.to_string());
                false
            }
        }
    }

    /// Adjusts the view to the last change, as a part of its step.
    pub(crate) fn amend_view(&mut self, camera: Camera) {
        self.replace_scene(Scene { camera, ..(*self.scene).clone() });
    }

    /// Replaces the scene; see [`Model::edit`].
    pub fn propose(&mut self, what: &str, mut scene: Scene) -> bool {
        if scene == *self.scene {
            return true;
        }
        let normalized = normalize(&mut scene, &self.library).and_then(|()| checked(&scene, &self.library));
        match normalized {
            Err(error) => {
                self.say(error.to_string());
                false
            }
            Ok((parameters, parts)) => {
                let before = self.replace_scene(scene);
                let moves_view = with_view(&before.camera, &self.scene.camera) != before.camera;
                match self.past.back_mut().filter(|_| self.open.as_deref() == Some(what)) {
                    Some(step) => step.moves_view |= moves_view,
                    None => {
                        self.past.push_back(Step { scene: before, what: what.into(), moves_view });
                        if self.past.len() > HISTORY {
                            self.past.pop_front();
                        }
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
        while let Some(Step { scene, what, moves_view }) = self.past.pop_back() {
            if let Some(scene) = self.exchange(scene, moves_view) {
                self.future.push(Step { scene, what, moves_view });
                return true;
            }
        }
        false
    }

    /// Repeats the last undone step; returns whether there was one.
    pub fn redo(&mut self) -> bool {
        while let Some(Step { scene, what, moves_view }) = self.future.pop() {
            if let Some(scene) = self.exchange(scene, moves_view) {
                self.past.push_back(Step { scene, what, moves_view });
                return true;
            }
        }
        false
    }

    /// Exchanges the scene with one of the history; `None` if a module of that one no longer exists.
    fn exchange(&mut self, scene: Arc<Scene>, moves_view: bool) -> Option<Arc<Scene>> {
        let mut scene = Arc::unwrap_or_clone(scene);
        if !moves_view {
            scene.camera = with_view(&scene.camera, &self.scene.camera);
        }
        normalize(&mut scene, &self.library).ok()?;
        (self.parameters, self.parts) = checked(&scene, &self.library).ok()?;
        (self.open, self.message) = (None, None);
        Some(self.replace_scene(scene))
    }

    /// Replaces the modules. New parameters have their defaults, removed ones are dropped, and values are clamped to
    /// their new ranges.
    ///
    /// # Errors
    /// The scene is invalid with these modules; nothing is changed.
    pub fn set_library(&mut self, library: Library) -> Result<(), SceneError> {
        let mut scene = (*self.scene).clone();
        normalize(&mut scene, &library)?;
        (self.parameters, self.parts) = checked(&scene, &library)?;
        self.replace_scene(scene);
        self.replace_library(library);
        self.message = None;
        Ok(())
    }

    /// The command line that renders the same picture.
    pub fn command_line(&self) -> String {
        self.scene.command_line(&self.library)
    }
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
