//! A simple model and panel, until those of their own rooms take their place.

/// The scene that is being edited.
pub mod model {
    use crate::glsl::Library;
    use crate::output;
    use crate::scene::{self, Scene, SceneError};
    use std::path::Path;

    /// A scene that is being edited, with the modules it is made of.
    pub struct Model {
        scene: Scene,
        library: Library,
        past: Vec<Scene>,
        future: Vec<Scene>,
        open: Option<String>,
        message: Option<String>,
    }

    impl Model {
        /// Starts with a scene.
        ///
        /// # Errors
        /// What [`Scene::check`] finds.
        pub fn new(scene: Scene, library: Library) -> Result<Model, SceneError> {
            scene.check(&library)?;
            Ok(Model { scene, library, past: Vec::new(), future: Vec::new(), open: None, message: None })
        }

        /// The scene.
        pub fn scene(&self) -> &Scene {
            &self.scene
        }

        /// The modules that there are.
        pub fn library(&self) -> &Library {
            &self.library
        }

        /// The last thing that was refused or done, one line.
        pub fn message(&self) -> Option<&str> {
            self.message.as_deref()
        }

        /// Shows a line.
        pub fn say(&mut self, line: impl Into<String>) {
            self.message = Some(line.into());
        }

        /// Changes the scene; edits of the same thing are one step of the history until [`Model::settle`].
        pub fn edit(&mut self, what: &str, change: impl FnOnce(&mut Scene)) -> bool {
            let mut scene = self.scene.clone();
            change(&mut scene);
            self.propose(what, scene)
        }

        /// Puts another scene in place of this one.
        pub fn propose(&mut self, what: &str, mut scene: Scene) -> bool {
            let checked = scene.drop_foreign_knobs(&self.library).and_then(|()| scene.check(&self.library).map(drop));
            if let Err(error) = checked {
                self.say(error.to_string());
                return false;
            }
            let before = std::mem::replace(&mut self.scene, scene);
            if self.open.as_deref() != Some(what) {
                self.past.push(before);
            }
            self.future.clear();
            (self.open, self.message) = (Some(what.into()), None);
            true
        }

        /// Ends a step of the history.
        pub fn settle(&mut self) {
            self.open = None;
        }

        /// Takes back the last step; whether there was one.
        pub fn undo(&mut self) -> bool {
            self.open = None;
            let Some(scene) = self.past.pop() else { return false };
            self.future.push(std::mem::replace(&mut self.scene, scene));
            true
        }

        /// Does again what was taken back last; whether there was something.
        pub fn redo(&mut self) -> bool {
            self.open = None;
            let Some(scene) = self.future.pop() else { return false };
            self.past.push(std::mem::replace(&mut self.scene, scene));
            true
        }

        /// Reads a scene file, or takes a file of any other kind as the object.
        pub fn open(&mut self, path: &Path) -> bool {
            if !path.extension().is_some_and(|end| end.eq_ignore_ascii_case("toml")) {
                return self.edit("object.input", |scene| scene.object.input = path.display().to_string());
            }
            match scene::load(path) {
                Ok(scene) => self.propose("open", scene),
                Err(error) => {
                    self.say(error.to_string());
                    false
                }
            }
        }

        /// Writes the scene.
        pub fn save(&mut self, path: &Path) -> bool {
            let written = output::write_whole(path, scene::to_text(&self.scene).as_bytes());
            self.say(match &written {
                Ok(()) => format!("wrote {}", path.display()),
                Err(error) => format!("{}: {error}; nothing was written", path.display()),
            });
            written.is_ok()
        }

        /// Takes a preset.
        pub fn take_preset(&mut self, name: &str, effect_only: bool) -> bool {
            let Ok(preset) = scene::preset(name) else { return false };
            let Scene { object, camera, light, image, quality, .. } = self.scene.clone();
            let scene = match effect_only {
                true => Scene { object, camera, light, image, quality, ..preset },
                false => Scene { image, ..preset },
            };
            let good = self.propose("preset", scene);
            self.settle();
            good
        }
    }
}

/// The panel at the right.
pub mod panels {
    use super::model::Model;
    use crate::glsl::LibraryError;
    use crate::scene::{self, Scene};
    use egui::{Panel, ScrollArea, Slider, Ui};
    use std::path::PathBuf;

    /// What the window knows and the panels show.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct Status {
        /// Time of the last frame and its spread, milliseconds.
        pub frame_ms: Option<[f64; 2]>,
        /// Estimated error of the picture that is shown, and its own spread, in units of 1.
        pub error: Option<[f64; 2]>,
        /// Samples, slices or pictures that are shown, in words.
        pub samples: String,
        /// Device and driver.
        pub device: String,
        /// What goes wrong, or was done; the model's own message goes before it.
        pub message: Option<String>,
        /// Part of what is under way that is done, 0 to 1.
        pub progress: Option<f32>,
        /// Whether time stands still.
        pub paused: bool,
        /// Whether frames are being written.
        pub recording: bool,
        /// Whether a second scene is shown beside this one.
        pub split: bool,
        /// The error that the picture may have; without one, the scene says how it is made.
        pub max_error: Option<f64>,
    }

    /// What only the window can do.
    #[derive(Clone, Debug, PartialEq)]
    pub enum Request {
        /// Write the picture that is shown.
        Screenshot(PathBuf),
        /// Look at the object as the preset does.
        ResetCamera,
        /// Show this scene beside the one that is edited; none ends it.
        Split(Option<Box<Scene>>),
        /// Start or end the writing of frames.
        Record(bool),
        /// Let time stand still, or go on.
        Pause(bool),
        /// Choose samples so that the error is at most this; none leaves them to the scene.
        MaxError(Option<f64>),
        /// End the program.
        Quit,
    }

    /// What the panels remember from frame to frame.
    pub struct Panels;

    impl Panels {
        /// Panels around a scene. `program` is the executable of hypertexture.
        ///
        /// # Errors
        /// None here.
        pub fn new(_program: PathBuf, _model: &Model) -> Result<Panels, LibraryError> {
            Ok(Panels)
        }

        /// Shows every panel in what is left of `ui`; what they leave is for the picture. To be called once for each frame.
        pub fn show(&mut self, ui: &mut Ui, model: &mut Model, status: &Status) -> Vec<Request> {
            let mut requests = Vec::new();
            Panel::right("panels").default_size(260.0).show(ui, |ui| {
                ui.add_space(6.0);
                ui.horizontal(|ui| {
                    if ui.button("Reset view").clicked() {
                        requests.push(Request::ResetCamera);
                    }
                    if ui.button(if status.paused { "Play" } else { "Pause" }).clicked() {
                        requests.push(Request::Pause(!status.paused));
                    }
                });
                ui.add_space(6.0);
                let mut samples = model.scene().quality.samples;
                if ui.add(Slider::new(&mut samples, 16..=1024).logarithmic(true).text("samples")).changed() {
                    model.edit("quality.samples", |scene| scene.quality.samples = samples);
                }
                ui.separator();
                ScrollArea::vertical().auto_shrink([false; 2]).show(ui, |ui| {
                    for name in scene::names() {
                        if ui.selectable_label(false, name).clicked() {
                            model.take_preset(name, false);
                        }
                    }
                });
            });
            if !ui.ctx().input(|input| input.pointer.any_down()) {
                model.settle();
            }
            requests
        }
    }
}
