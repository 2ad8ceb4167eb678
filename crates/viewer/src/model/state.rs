//! The edited scene and its history.

use crate::message::Message;
use hypertexture::scene::{self, Camera, ParameterValue, Parameters, Part, Scene, SceneError, schema};
use hypertexture::shader::ParameterKind;
use hypertexture::shader::{self, Library, Slots};
use measure::guard::programs;
use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};

/// Steps that can be undone; a scene takes a few kilobytes. Not egui's `Undoer`, whose steps end with time and have no
/// names, and which would give back a scene whose modules are gone.
const HISTORY: usize = 256;

/// A scene that is being edited, with the modules it is made of.
pub struct Model {
    pub(super) scene: Scene,
    pub(super) library: Library,
    pub(super) parameters: Parameters,
    pub(super) parts: BTreeMap<String, Parameters>,
    pub(super) past: VecDeque<Step>,
    pub(super) future: Vec<Step>,
    /// What the last edit was about, while further edits of the same belong to it.
    pub(super) open: Option<String>,
    pub(super) saved: Scene,
    pub(super) file: Option<PathBuf>,
    /// What was written to files from here.
    pub(super) written: BTreeMap<PathBuf, String>,
    pub(super) home: Camera,
    pub(super) message: Option<Message>,
}

/// A scene that one can go back to.
pub(super) struct Step {
    scene: Scene,
    what: String,
}

impl Model {
    /// Starts with a scene.
    ///
    /// # Errors
    /// What [`Scene::check`] and [`Scene::check_parts`] find.
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
            message: None,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The modules that there are.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// The parameters of the scene's own object, or of a further one, with their values.
    pub fn parameters(&self, part: Option<&str>) -> &Parameters {
        part.and_then(|part| self.parts.get(part)).unwrap_or(&self.parameters)
    }

    /// The last thing that was refused or done, one line.
    pub fn message(&self) -> Option<&str> {
        self.notice().map(|message| message.text.as_str())
    }

    /// That line, and whether it is an error.
    pub fn notice(&self) -> Option<&Message> {
        self.message.as_ref()
    }

    /// Says what went wrong.
    pub fn say(&mut self, line: impl Into<String>) {
        self.message = Some(Message::error(line));
    }

    /// The file that the scene was read from or written to last.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The camera of the preset or file that was opened last.
    pub fn home(&self) -> &Camera {
        &self.home
    }

    /// Says which file holds a module of the scene's own, as a part of the scene. It is no step of the history: the module
    /// is in that file whatever is undone.
    pub fn file_module(&mut self, module: &str, file: &str) {
        if self.scene.modules.get(module).is_none_or(|known| known != file) {
            self.scene.modules.insert(module.into(), file.into());
        }
    }

    /// The modules in the programs of the scene that are not as they ship, nor as the scene's files have them: what a
    /// scene file does not say.
    pub fn edited(&self) -> Vec<String> {
        let filed = self.scene.library().unwrap_or_else(|_| shader::shipped());
        let changed = self.library.sources().filter(|(path, text)| filed.source(path) != Some(text));
        let programs = programs(&self.scene, &self.library).unwrap_or_default();
        let is_used = |path: &str| programs.iter().any(|program| program.reaches(&self.library, path));
        changed.map(|(path, _)| path.to_string()).filter(|path| is_used(path)).collect()
    }

    /// Whether the scene is another than the one in its file, or than the one it began with.
    pub fn is_dirty(&self) -> bool {
        self.scene != self.saved
    }

    /// Changes the scene. Parameters that no module declares any more are dropped, and what all objects must share is given to
    /// all. Edits of the same thing, `what`, are one step of the history until [`Model::end_undo_group`].
    ///
    /// Whether the scene is now as `change` left it; if not, [`Model::message`] says why.
    pub fn edit(&mut self, what: &str, change: impl FnOnce(&mut Scene)) -> bool {
        let mut scene = self.scene.clone();
        change(&mut scene);
        self.propose(what, scene)
    }

    /// Puts another scene in place of this one: [`Model::edit`].
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

    /// Ends a step of the history: a slider was let go.
    pub fn end_undo_group(&mut self) {
        self.open = None;
    }

    /// What [`Model::undo`] would take back.
    pub fn undoes(&self) -> Option<&str> {
        self.past.back().map(|step| step.what.as_str())
    }

    /// What [`Model::redo`] would do again.
    pub fn redoes(&self) -> Option<&str> {
        self.future.last().map(|step| step.what.as_str())
    }

    /// Takes back the last step; whether there was one.
    pub fn undo(&mut self) -> bool {
        while let Some(Step { scene, what }) = self.past.pop_back() {
            if let Some(scene) = self.exchange(scene) {
                self.future.push(Step { scene, what });
                return true;
            }
        }
        false
    }

    /// Does again what was taken back last; whether there was something.
    pub fn redo(&mut self) -> bool {
        while let Some(Step { scene, what }) = self.future.pop() {
            if let Some(scene) = self.exchange(scene) {
                self.past.push_back(Step { scene, what });
                return true;
            }
        }
        false
    }

    /// Puts a scene of the history in place; gives the one that was. None where a module of it is gone.
    fn exchange(&mut self, mut scene: Scene) -> Option<Scene> {
        normalize(&mut scene, &self.library).ok()?;
        (self.parameters, self.parts) = checked(&scene, &self.library).ok()?;
        (self.open, self.message) = (None, None);
        Some(std::mem::replace(&mut self.scene, scene))
    }

    /// Exchanges the modules. New parameters have their defaults, those that are gone are dropped, and a value that is out of
    /// its new range goes to the end of it.
    ///
    /// # Errors
    /// The scene cannot be made of these modules; nothing has changed then.
    pub fn set_library(&mut self, library: Library) -> Result<(), SceneError> {
        let mut scene = self.scene.clone();
        normalize(&mut scene, &library)?;
        (self.parameters, self.parts) = checked(&scene, &library)?;
        (self.scene, self.library, self.message) = (scene, library, None);
        Ok(())
    }

    /// Adds an additional object, a copy of a part of a preset; the formula gets it at its end. Gives its name.
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

    /// Removes an additional object. A formula that still names it gives way to the union of those that are left.
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

    /// The command line that renders the same picture.
    pub fn command_line(&self) -> String {
        self.scene.command_line(&self.library)
    }
}

fn checked(scene: &Scene, library: &Library) -> Result<(Parameters, BTreeMap<String, Parameters>), SceneError> {
    let parameters = scene.check(library)?;
    Ok((parameters, scene.check_parts(library)?))
}

/// Makes the rest of a scene follow its modules: what all objects share, and the parameters that there are.
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
    for (name, part) in &mut scene.parts {
        keep_declared(&mut part.parameters, &library.object_declarations(name, &slots)?.parameters);
    }
    Ok(())
}

/// Keeps the values of declared parameters, each in its range where it is of the right kind.
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
