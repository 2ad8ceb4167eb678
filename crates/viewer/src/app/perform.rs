//! Commands of keys, panels and dropped files.

use super::state::App;
use crate::document::exports::ExportOrder;
use crate::document::painting::SEVERAL;
use crate::input::Command;
use crate::panels::{Question, SIDES};
use crate::worker::LoadedScene;
use egui::Ui;
use hypertexture::scene::{self, Camera, Scene};
use hypertexture::shader::slots::MAIN;
use hypertexture_measure::metric::Metric;
use hypertexture_measure::pick::{ErrorBound, Pick};
use hypertexture_measure::statistics::rounded_up;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time without a change of the scene before the search for the fastest settings starts.
const PICK_DELAY: Duration = Duration::from_millis(500);

impl App {
    /// Performs a command. One without an effect says why.
    pub(super) fn perform(&mut self, command: Command) {
        match command {
            // Texts of modules and running renders go on.
            Command::New if self.document.model.is_dirty() => self.panels.ask(Question::New),
            Command::New | Command::Begin => self.begin(),
            Command::Open(_) => {
                self.loader.failed = None;
                self.panels.perform(command, &mut self.document);
            }
            Command::ChooseFile
            | Command::Save
            | Command::SaveTo(_)
            | Command::SaveAs
            | Command::Restore(_)
            | Command::Preset { .. }
            | Command::AddPart
            | Command::RemovePart(_)
            | Command::RenamePart { .. } => drop(self.panels.perform(command, &mut self.document)),
            Command::Export => self.panels.export.is_open ^= true,
            Command::AskToLook if self.document.model.is_dirty() => self.panels.ask(Question::Look),
            Command::AskToLook | Command::Look => self.look_at_print(),
            Command::AskToQuit => self.ask_to_quit(),
            Command::Quit => self.quit = true,
            Command::Undo => {
                if !self.document.model.undo() {
                    self.note("there is nothing to undo");
                }
            }
            Command::Redo => {
                if !self.document.model.redo() {
                    self.note("there is nothing to redo");
                }
            }
            Command::PreviousPreset => self.step(-1),
            Command::NextPreset => self.step(1),
            Command::Duplicate => self.duplicate(),
            Command::Delete => self.delete(),
            Command::Place => self.toggle_placement(),
            Command::Paint => self.toggle_brush(),
            Command::WeakerBrush => self.strengthen(0.8),
            Command::StrongerBrush => self.strengthen(1.25),
            Command::Frame => self.frame_objects(),
            Command::ResetCamera => self.reset_camera(),
            Command::Side(index) => self.look_from_side(index),
            Command::LevelOrbit => {
                self.navigation.level = !self.navigation.level;
                self.note(if self.navigation.level { "a drag orbits level" } else { "a drag turns like a ball" });
            }
            Command::Inertia => {
                self.navigation.inertia = !self.navigation.inertia;
                self.navigation.glide = None;
                self.note(if self.navigation.inertia { "inertia on" } else { "inertia off" });
            }
            Command::Panels => self.panels.hidden ^= true,
            Command::FocusControls => self.panels.hidden = false,
            Command::FullScreen => self.full_screen = !self.full_screen,
            Command::Play => self.toggle_time(),
            Command::Time(time) => self.set_time(time),
            Command::Playback(playback) => self.time.playback = playback,
            Command::WritePicture => self.screenshot(self.free_name("hypertexture", ".png")),
            Command::Screenshot(path) => self.screenshot(path),
            Command::Turntable => self.toggle_turntable(),
            Command::Compare => self.toggle_comparison(),
            Command::NextComparison if self.comparison.pinned.is_none() => {
                self.note("there is nothing to compare with: C pins this variant first");
            }
            Command::NextComparison => self.comparison.view.next(),
            Command::InspectPixel => self.inspect_under_pointer(),
            Command::WorstPixel => self.jump_to_worst(),
            Command::Validity => {
                self.validity = !self.validity;
                // The validity is that of one variant.
                self.comparison.pinned = self.comparison.pinned.take().filter(|_| !self.validity);
            }
            Command::MaxError(error) => {
                (self.max_error, self.search.pick) = (error, error);
                if self.figures.picking.is_some() {
                    self.stop(); // the search was for the old target
                }
            }
            Command::Densities => {
                if let Some(job) = self.jobs.submitted.as_ref().filter(|job| !job.moving) {
                    self.densities.request(job, &self.notify);
                }
            }
            Command::Help => self.help = !self.help,
            Command::Lesson => self.lesson.is_open ^= true,
            Command::Leave => self.leave(),
        }
    }

    /// Ends the innermost mode: the list of keys, the placement, the brush, the full screen; then asks to quit.
    fn leave(&mut self) {
        if self.help {
            self.help = false;
        } else if self.objects.places {
            self.toggle_placement();
        } else if self.document.painting.is_on {
            self.toggle_brush();
        } else if self.full_screen {
            self.full_screen = false;
        } else {
            self.panels.ask(Question::Quit);
        }
    }

    fn look_from_side(&mut self, index: usize) {
        let (name, azimuth, elevation) = SIDES[index];
        self.navigation.glide = None;
        if self.turns() {
            self.document.model.look(|camera| {
                (camera.azimuth, camera.elevation, camera.rotation) = (azimuth, elevation, None);
            });
            self.document.model.end_undo_group();
            self.note(format!("from the {name}"));
        }
    }

    fn reset_camera(&mut self) {
        let time = self.document.model.scene().camera.time;
        let home = Camera { time, ..self.document.model.home().clone() };
        self.navigation.glide = None;
        // A step of the history: more than the view is replaced.
        self.document.model.end_undo_group();
        self.document.model.edit("reset view", |scene| scene.camera = home);
        self.document.model.end_undo_group();
    }

    /// Plays or pauses.
    fn toggle_time(&mut self) {
        match self.time.clock.take() {
            Some(clock) => drop(self.document.model.look(|camera| camera.time = clock)),
            None => self.time.clock = Some(self.document.model.scene().camera.time),
        }
    }

    fn set_time(&mut self, time: f64) {
        self.time.playback.reach(time);
        match &mut self.time.clock {
            Some(clock) => *clock = time,
            None => drop(self.document.model.look(|camera| camera.time = time)),
        }
    }

    fn toggle_turntable(&mut self) {
        if self.document.exports.frames().is_some() {
            return self.document.exports.stop();
        }
        let (scene, path) = (self.timed(), self.free_name("turntable", "_####.png"));
        self.document.exports.add(ExportOrder::turntable(scene, self.document.model.library().clone(), path));
    }

    /// Pins this variant, or ends the comparison.
    fn toggle_comparison(&mut self) {
        self.comparison.pinned = match self.comparison.pinned {
            Some(_) => None,
            None => Some((Arc::new(self.shown()), self.library.clone())),
        };
        self.validity &= self.comparison.pinned.is_none();
    }

    /// States of the commands that are switched on and off.
    pub(super) fn states(&self) -> Vec<(Command, bool)> {
        [
            (Command::Play, self.time.clock.is_some()),
            (Command::Compare, self.comparison.pinned.is_some()),
            (Command::Validity, self.validity),
            (Command::Paint, self.document.painting.is_on),
            (Command::Inertia, self.navigation.inertia),
            (Command::LevelOrbit, self.navigation.level),
            (Command::InspectPixel, self.inspector.is_open()),
            (Command::Lesson, self.lesson.is_open),
            (Command::Place, self.objects.places),
            (Command::FullScreen, self.full_screen),
            (Command::Turntable, self.document.exports.frames().is_some()),
            (Command::Panels, self.panels.hidden),
            (Command::Help, self.help),
        ]
        .into()
    }

    /// Turns the brush on or off.
    fn toggle_brush(&mut self) {
        if self.document.model.scene().has_several() {
            self.document.painting.is_on = false;
            return self.note(SEVERAL);
        }
        self.document.painting.is_on ^= true;
        self.note(if self.document.painting.is_on {
            "the brush paints where a drag begins on the object; beside it, the drag turns the view"
        } else {
            "the brush is off"
        });
    }

    fn strengthen(&mut self, factor: f32) {
        let painting = &mut self.document.painting;
        if !painting.is_on {
            return self.note("the brush is off: B turns it on");
        }
        painting.brush.strength = (painting.brush.strength * factor).clamp(0.02, 1.0);
        let strength = painting.brush.strength;
        self.note(format!("strength of the brush: {strength:.2}"));
    }

    /// Duplicates the selected object, or the main one.
    fn duplicate(&mut self) {
        let from = self.document.selection.part().map(String::from);
        if let Some(name) = self.document.model.duplicate_part(from.as_deref()) {
            self.note(format!("{} is duplicated as {name}: G places it", from.as_deref().unwrap_or(MAIN)));
            self.document.selection.select(Some(name));
        }
    }

    /// Removes the selected keyframe, else the selected object.
    fn delete(&mut self) {
        if self.panels.remove_key(&mut self.document.model) {
            return self.document.model.end_undo_group();
        }
        match self.document.selection.part().map(String::from) {
            None if self.document.model.scene().parts.is_empty() => self.note("the only object cannot be removed"),
            None => self.note("the main object cannot be removed: select another one"),
            Some(name) if self.document.selection.is_locked(&name) => {
                self.note(format!("{name} is locked: unlock it in Objects first"));
            }
            Some(name) => {
                if self.document.model.remove_part(&name) {
                    self.note(format!("{name} is removed: Ctrl+Z brings it back"));
                }
            }
        }
    }

    /// Whether the view can be moved; says so if not.
    pub(super) fn turns(&mut self) -> bool {
        let is_fixed = self.document.model.scene().camera.matrices.is_some();
        if is_fixed {
            self.note("camera.matrices fix the view: remove them in Camera, Advanced, to move it");
        }
        !is_fixed
    }

    /// Begins a new scene.
    fn begin(&mut self) {
        self.navigation.glide = None;
        self.document.selection.select(None);
        if self.document.model.begin() {
            self.note("a new scene; Ctrl+Z goes back");
        }
    }

    /// Begins a scene of the print that was written last.
    fn look_at_print(&mut self) {
        self.loader.failed = None;
        self.navigation.glide = None;
        if self.document.look_at_print() {
            self.note("the print, with overhangs and thin walls colored; Ctrl+Z goes back");
        }
    }

    /// Closes the window, after a question if there is unsaved work.
    pub(crate) fn ask_to_quit(&mut self) {
        match self.document.at_stake() {
            Some(_) => self.panels.ask(Question::Quit),
            None => self.quit = true,
        }
    }

    /// Takes the preset `by` places after the current one.
    fn step(&mut self, by: isize) {
        let names: Vec<&str> = scene::names().collect();
        let here = self.document.model.preset().and_then(|own| names.iter().position(|name| *name == own));
        let count = names.len() as isize;
        let next = here.map_or(0, |here| (here as isize + by).rem_euclid(count));
        self.document.model.take_preset(names[next as usize], false);
        self.navigation.glide = None;
        self.note(format!("{}: {}", names[next as usize], self.document.model.scene().about));
    }

    /// Stops the search for the fastest settings.
    pub(super) fn stop(&self) {
        if let Some(worker) = &self.worker {
            worker.stop();
        }
    }

    /// Writes the picture of the current scene.
    pub(crate) fn screenshot(&mut self, path: PathBuf) {
        self.document.exports.add(ExportOrder::picture(self.shown(), self.document.model.library().clone(), path));
    }

    /// Starts the search for the fastest settings within the error target, once the mouse is released.
    pub(super) fn pick(&mut self, ui: &Ui, now: Instant) {
        let Some(error) = self.search.pick else { return };
        let rests = self.time.clock.is_some() || now.duration_since(self.jobs.changed) >= PICK_DELAY;
        let is_free = !ui.input(|input| input.pointer.any_down()) && self.loader.progress().is_none();
        // A preview comes first: the search occupies the device.
        let is_ready = rests && is_free && self.is_current() && self.figures.picking.is_none();
        let (true, Some(worker), Some(job)) = (is_ready, &self.worker, &self.jobs.submitted) else {
            return ui.ctx().request_repaint_after(PICK_DELAY);
        };
        self.search.pick = None;
        match ErrorBound::new(Metric::Rmse, error) {
            Ok(bound) => {
                worker.pick(LoadedScene { scene: Arc::new(self.shown()), ..job.variants[0].clone() }, bound);
                self.figures.picking = Some(0.0);
                self.search.picked_for = Some(self.document.model.shared_scene().clone());
                self.jobs.submitted = None; // the picture is gone on with afterwards
            }
            Err(error) => self.fail(error.to_string()),
        }
    }

    /// Applies the settings that were found.
    pub(super) fn take(&mut self, pick: &Pick) {
        let content = |scene: &Scene| Scene { camera: Camera::default(), ..scene.clone() };
        if self.search.picked_for.take().map(|scene| content(&scene)) != Some(content(self.document.model.scene())) {
            self.fail("the scene changed during the search for the fastest settings: try again");
            return;
        }
        let Scene { quality, effect, .. } = &pick.scene;
        let good = self.document.model.edit("way to draw", |scene| {
            scene.quality.clone_from(quality);
            scene.effect.clone_from(effect);
        });
        self.document.model.end_undo_group();
        if good {
            let by = if pick.unverified.is_none() { "the f64 reference" } else { "a finer picture" };
            let error = rounded_up(pick.verified.error);
            self.note(format!("using {}: error at most {error:.1e} against {by}", pick.settings));
        }
    }

    /// The first file name of the form `stem`, number, `end` that neither exists nor is ordered.
    fn free_name(&self, stem: &str, end: &str) -> PathBuf {
        let name = |number: u32| PathBuf::from(format!("{stem}_{number:03}{end}"));
        let taken = |path: &PathBuf| {
            let first = path.to_string_lossy().replace("####", "0000");
            Path::new(&first).exists() || self.document.exports.is_own(Path::new(&first))
        };
        (1..1000).map(name).find(|path| !taken(path)).unwrap_or_else(|| name(1000))
    }
}
