//! What happens in the window: the mouse and the keys to the scene, the scene to the thread that renders.

mod actions;
mod inspect;
mod mouse;
mod overlay;

use super::ViewError;
use super::author::Author;
use super::compare::Comparison;
use super::densities::Densities;
use super::inspect::Inspector;
use super::keys;
use super::load::Loader;
use super::message::Message;
use super::model::Model;
use super::panels::{Panels, Status};
use super::screen::Screen;
use super::status::{Figures, Stage};
use super::tempo::Tempo;
use super::trackball::Trackball;
use super::unread::Unread;
use super::unsaved;
use super::worker::{Event, Job, Variant, Worker, sight};
use crate::gpu::{Gpu, Options};
use crate::render::Sight;
use crate::scene::{self, Scene};
use crate::shader::Library;
use crate::support::disk_cache;
use egui::{Rect, Sense, Ui};
use glam::DVec3;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What the window begins with.
pub struct Start {
    /// The scene; it has been checked.
    pub scene: Scene,
    /// Its modules.
    pub library: Library,
    /// How to open the device.
    pub options: Options,
    /// The root mean square error at which a picture is good enough.
    pub max_error: Option<f64>,
    /// Whether time runs from the beginning.
    pub play: bool,
    /// Width and height of the window, points.
    pub window: [u32; 2],
    /// Draw so many frames after the first picture, write the screenshot, and end.
    pub frames: Option<u32>,
    /// Where the screenshot goes, at the end of those frames or when the picture has converged.
    pub screenshot: Option<PathBuf>,
    /// A file of what a person would do.
    pub script: Option<PathBuf>,
    /// When the program began.
    pub began: Instant,
}

/// Good enough for the camera: half a code of an 8-bit picture in its mid tones, without the option.
const GOOD: f64 = 1e-3;
/// A scene that has not changed for so long stands still.
const REST: Duration = Duration::from_millis(200);
/// Milliseconds that a picture may take while the scene moves, on a CPU and on another device.
const BUDGET_MS: [f64; 2] = [50.0, 12.0];
/// What moves by itself is drawn this often.
const FRAME: Duration = Duration::from_millis(16);

/// Tells the window from another thread that there is something new.
pub(super) type Notify = Arc<dyn Fn() + Send + Sync>;

/// The window's state.
pub(super) struct App {
    pub(super) model: Model,
    panels: Panels,
    library: Arc<Library>,
    worker: Option<Worker>,
    loader: Loader,
    notify: Notify,
    screen: Screen,
    /// Where the picture on the screen is looked at from, and where the scene is now.
    seen: Option<Sight>,
    sight: Option<Sight>,
    pub(super) figures: Figures,
    /// Where the picture is, points.
    pub(super) place: Rect,
    ball: Trackball,
    /// Axis, radians per second.
    glide: Option<(DVec3, f64)>,
    last_turn: (DVec3, f64),
    inertia: bool,
    /// Whether a drag keeps the vertical axis upright.
    level: bool,
    /// What a drag does that is under way.
    drag: mouse::Drag,
    /// The time, while it runs.
    clock: Option<f64>,
    tempo: Tempo,
    last_frame: Instant,
    /// The variant that the scene is compared with.
    kept: Option<Scene>,
    comparison: Comparison,
    inspector: Inspector,
    max_error: Option<f64>,
    /// Whether pixels that are not to be trusted are shown.
    validity: bool,
    densities: Densities,
    unread: Unread,
    /// The error that a way to draw is still to be looked for.
    pick: Option<f64>,
    /// The scene that one is being looked for.
    picked_for: Option<Scene>,
    posted: Option<Job>,
    /// Where the pointer is over the picture.
    pointer: Option<egui::Pos2>,
    dragging: bool,
    changed: Instant,
    /// Those of the newest job and of the picture that is on the screen.
    pub(super) number: u64,
    pub(super) on_screen: u64,
    /// Tasks that are not finished.
    pub(super) tasks: u32,
    help: bool,
    /// Whether the picture is that of the scene as it is now.
    pub(super) is_current: bool,
    /// The first thing that went wrong with an object or a task.
    pub(super) failure: Option<String>,
    pub(super) lost: bool,
    pub(super) quit: bool,
    pub(super) full_screen: bool,
    /// What went wrong or was done last, and the number of the job then.
    said: Option<Message>,
    said_at: u64,
    /// What is being written, in words.
    writing: String,
}

impl App {
    /// A window that shows a scene.
    pub(super) fn new(start: &Start, notify: Notify) -> Result<App, ViewError> {
        let model = Model::new(start.scene.clone(), start.library.clone())?;
        let program = std::env::current_exe().unwrap_or_else(|_| PathBuf::from("hypertexture"));
        let mut panels = Panels::new(program, &model).map_err(scene::SceneError::from)?;
        panels.remember(unsaved::kept(), disk_cache::default_folder());
        // A module that was given as a file is followed from the beginning.
        let modules = &model.scene().modules;
        if let Some((slot, name, file)) =
            modules.iter().find_map(|(module, file)| module.split_once('/').map(|(slot, name)| (slot, name, file)))
        {
            let followed = panels.author().follow(model.library(), slot, name, Path::new(file));
            followed.unwrap_or_else(|error| log::warn!("{error}"));
        }
        let (now, camera) = (Instant::now(), model.scene().camera.clone());
        Ok(App {
            library: Arc::new(model.library().clone()),
            panels,
            worker: None,
            loader: Loader::default(),
            notify,
            screen: Screen::default(),
            seen: None,
            sight: None,
            figures: Figures::default(),
            place: Rect::ZERO,
            ball: Trackball::of(&camera),
            glide: None,
            last_turn: (DVec3::Y, 0.0),
            inertia: false,
            level: false,
            drag: mouse::Drag::default(),
            tempo: Tempo::default(),
            clock: start.play.then_some(camera.time),
            last_frame: now,
            kept: None,
            comparison: Comparison::default(),
            inspector: Inspector::default(),
            max_error: start.max_error,
            validity: false,
            densities: Densities::default(),
            unread: Unread::default(),
            pick: start.max_error,
            picked_for: None,
            posted: None,
            pointer: None,
            dragging: false,
            changed: now,
            number: 0,
            on_screen: 0,
            tasks: 0,
            help: false,
            is_current: false,
            failure: None,
            lost: false,
            quit: false,
            full_screen: false,
            said: None,
            said_at: 0,
            writing: String::new(),
            model,
        })
    }

    /// Takes a device, the first or another one; what was on the screen is shown and rendered again.
    pub(super) fn use_device(&mut self, gpu: &Gpu) {
        let info = gpu.info();
        self.figures.device = format!("{} ({})", info.name, info.driver);
        self.figures.budget_ms = BUDGET_MS[usize::from(!info.cpu)];
        let (notify, gate) = (self.notify.clone(), self.panels.author().gate().clone());
        gate.try_on(&info.name);
        self.worker = Some(Worker::start(gpu.clone(), gate, self.figures.budget_ms, move || notify()));
        self.screen.forget();
        (self.posted, self.lost, self.tasks) = (None, false, 0);
    }

    /// Lets go of the device: nothing of this holds it any more.
    pub(super) fn leave_device(&mut self) {
        self.worker = None;
    }

    /// Keeps what no file holds, and says where.
    pub(super) fn keep_unsaved(&mut self) {
        let Some(folder) = unsaved::folder() else { return };
        match unsaved::keep(&self.model, self.panels.author(), &folder) {
            Ok(false) => {}
            Ok(true) => drop(writeln!(io::stdout(), "what was not saved is in {}", folder.display())),
            Err(error) => log::warn!("what was not saved is lost: {error}"),
        }
    }

    /// The module that is being edited.
    pub(super) fn author(&mut self) -> &mut Author {
        self.panels.author()
    }

    /// What is being loaded, and how far it is.
    pub(super) fn loading(&self) -> Option<(String, f32)> {
        self.loader.progress()
    }

    /// Takes what the other threads have made.
    pub(super) fn receive(&mut self) {
        if let Err(reason) = self.loader.poll() {
            self.failure.get_or_insert(reason.clone());
            self.fail(reason);
        }
        let Some(worker) = &self.worker else { return };
        // A thread that has failed is replaced as one whose device is lost: once.
        self.lost |= worker.has_ended();
        let events: Vec<Event> = worker.events.try_iter().collect();
        for event in events {
            match event {
                Event::Picture(picture) => {
                    self.inspector.take(&picture.frames, picture.size, picture.stage);
                    self.screen.take(picture.images, picture.frames, picture.size);
                    self.seen = picture.sight;
                    let figures = &mut self.figures;
                    (figures.stage, figures.size, figures.samples) = (picture.stage, picture.size, picture.samples);
                    (figures.gpu_ms, figures.difference) = (picture.gpu_ms, picture.difference);
                    (figures.error, figures.standard_error) = (picture.error, picture.standard_error);
                    figures.validity = picture.validity;
                    if picture.stage == Stage::Coarse {
                        figures.ignored.clear();
                        figures.recent_ms.push(picture.gpu_ms);
                        let surplus = figures.recent_ms.len().saturating_sub(120);
                        figures.recent_ms.drain(..surplus);
                    }
                    (self.is_current, self.on_screen) = (picture.number == self.number, picture.number);
                    // What went wrong with an earlier scene no longer holds.
                    self.said.take_if(|said| said.is_error && picture.number > self.said_at);
                }
                Event::Stopped(line) => {
                    (self.tasks, self.figures.recording) = (self.tasks.saturating_sub(1), None);
                    self.note(line);
                }
                Event::Made(lines) => self.figures.made = lines,
                Event::Ignored(ignored) => self.figures.ignored = ignored,
                Event::Wrote(path) => {
                    self.tasks = self.tasks.saturating_sub(1);
                    self.figures.recording = None;
                    let path = std::path::absolute(&path).unwrap_or(path);
                    self.note(format!("wrote {}{}", path.display(), self.writing));
                }
                Event::Picking(done) => self.figures.picking = Some(done),
                Event::Picked(pick) => {
                    (self.tasks, self.figures.picking) = (self.tasks.saturating_sub(1), None);
                    if let Some(pick) = pick {
                        self.take(&pick);
                    }
                }
                Event::Recorded(done, all) => self.figures.recording = Some((done, all)),
                Event::Refused(reason) => {
                    self.failure.get_or_insert(reason.clone());
                    (self.tasks, self.figures.recording, self.figures.picking) = (0, None, None);
                    self.fail(reason);
                }
                Event::Failed(reason) => {
                    if self.tasks > 0 {
                        self.failure.get_or_insert(reason.clone());
                    }
                    (self.tasks, self.figures.recording, self.figures.picking) = (0, None, None);
                    self.fail(reason);
                }
                Event::Lost => self.lost = true,
            }
        }
    }

    /// Says what was done.
    fn note(&mut self, line: impl Into<String>) {
        self.said = Some(Message::note(line));
    }

    /// Says what went wrong, until a picture of another scene is there.
    fn fail(&mut self, line: impl Into<String>) {
        (self.said, self.said_at) = (Some(Message::error(line)), self.number);
    }

    /// One frame: the panels, the picture, and what is over it.
    pub(super) fn ui(&mut self, ui: &mut Ui) {
        let now = Instant::now();
        let passed = now.duration_since(self.last_frame).as_secs_f64();
        self.last_frame = now;
        if !self.panels.is_asking() {
            keys::pressed(ui.ctx()).into_iter().for_each(|action| self.act(action));
        }
        let status = self.status();
        let requests = self.panels.show(ui, &mut self.model, &status);
        for request in requests {
            self.request(request);
        }
        let dropped: Vec<PathBuf> =
            ui.ctx().input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_path_buf()).collect());
        for path in dropped {
            self.open(&path);
        }
        self.place = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(self.place, Sense::click_and_drag());
        self.navigate(ui, &response);
        self.glide(passed);
        if let Some(clock) = &mut self.clock {
            *clock = self.tempo.after(*clock, passed);
        }
        self.post(ui, now);
        self.screen.moved = self.seen.zip(self.sight).filter(|(seen, now)| seen != now);
        self.screen.draw(ui, self.place, &self.comparison);
        self.show_over(ui);
        self.pick(ui, now);
    }

    fn status(&mut self) -> Status {
        let Figures { error, standard_error, size, samples, recording, .. } = &self.figures;
        let recent = &self.figures.recent_ms;
        let mean = recent.iter().sum::<f64>() / recent.len().max(1) as f64;
        let variance = recent.iter().map(|ms| (ms - mean).powi(2)).sum::<f64>() / recent.len().max(1) as f64;
        // Only coarse pictures come often enough for their times to have a spread.
        let spread = if self.figures.stage == Stage::Coarse { variance.sqrt() } else { 0.0 };
        Status {
            frame_ms: (!recent.is_empty()).then_some([self.figures.gpu_ms, spread]),
            error: error.map(|error| [error, standard_error.unwrap_or(error)]),
            picture: self.figures.words(self.max_error.unwrap_or(GOOD)),
            detail: format!("{} x {} pixels, {samples} samples", size[0], size[1]),
            device: self.figures.device.clone(),
            message: self.said.clone(),
            ignored: self.figures.ignored.clone(),
            idle: self.unread.poll(self.model.scene()).to_vec(),
            window: self.posted.as_ref().map_or([0, 0], |job| job.variants[0].scene.image.size),
            made: self.figures.made.clone(),
            progress: self.figures.picking.or(recording.map(|(done, all)| done as f32 / all.max(1) as f32)),
            recent_ms: recent.clone(),
            budget_ms: self.figures.budget_ms,
            paused: self.clock.is_none(),
            recording: recording.is_some(),
            split: self.kept.is_some(),
            max_error: self.max_error,
            validity: self.validity,
            densities: self.densities.poll(),
            time: self.clock,
            tempo: self.tempo,
            level: self.level,
        }
    }

    /// The scene at the time it is.
    fn shown(&self) -> Scene {
        let mut scene = self.model.scene().clone();
        if let Some(clock) = self.clock {
            scene.camera.time = clock;
        }
        scene
    }

    /// Gives the thread that renders what is to be seen now, if that is something new.
    fn post(&mut self, ui: &Ui, now: Instant) {
        if *self.library != *self.model.library() {
            self.library = Arc::new(self.model.library().clone());
        }
        let points = ui.ctx().pixels_per_point();
        let pane = self.place.size() * points;
        let size = [pane.x, pane.y].map(|side| (side.round() as u32).clamp(16, 8192));
        let mut scenes = vec![self.shown()];
        if let Some(kept) = &self.kept {
            scenes.push(Scene { camera: scenes[0].camera.clone(), ..kept.clone() });
        }
        let notify = self.notify.clone();
        let mut variants = Vec::new();
        for mut scene in scenes {
            scene.image.size = size;
            match self.loader.subject(&scene, &self.library, &move_clone(&notify)) {
                Ok(Some(subject)) => variants.push(Variant { scene, subject }),
                // One after the other: what is loaded for the second takes the place of what is loaded for the first.
                Ok(None) => break,
                Err(error) => self.fail(error.to_string()),
            }
        }
        if self.loader.progress().is_some() {
            ui.ctx().request_repaint_after(Duration::from_millis(50));
        }
        let expected = 1 + usize::from(self.kept.is_some());
        if variants.len() < expected {
            self.is_current = false;
            return;
        }
        let same = |job: &Job| {
            Arc::ptr_eq(&job.library, &self.library)
                && job.variants.len() == variants.len()
                && job
                    .variants
                    .iter()
                    .zip(&variants)
                    .all(|(a, b)| a.scene == b.scene && Arc::ptr_eq(&a.subject, &b.subject))
        };
        let changed = !self.posted.as_ref().is_some_and(same);
        if changed {
            self.sight = sight(&variants[0], &self.library).ok();
        }
        if changed && self.posted.is_some() {
            self.changed = now;
            if self.figures.picking.is_some() && self.clock.is_none() {
                // Input comes first: what is looked for is looked for again once the scene rests.
                self.stop();
                self.pick = self.max_error;
            }
        }
        let busy = self.dragging || self.clock.is_some() || self.glide.is_some();
        let moving = busy || now.duration_since(self.changed) < REST;
        let max_error = self.max_error.unwrap_or(GOOD);
        let validity = self.validity;
        let as_before =
            |job: &Job| (job.moving, job.max_error.to_bits(), job.validity) == (moving, max_error.to_bits(), validity);
        if changed || !self.posted.as_ref().is_some_and(as_before) {
            self.number += 1;
            self.is_current = false;
            let (number, library, focus) = (self.number, self.library.clone(), self.focus());
            let job = Job { number, library, variants, moving, max_error, focus, validity };
            if let Some(worker) = &self.worker {
                worker.show(job.clone());
            }
            self.posted = Some(job);
        }
        if let (false, Some(job)) = (moving, &self.posted) {
            self.unread.want(job, move || notify());
        }
        // What the hand moves is drawn when it moves.
        if self.clock.is_some() || self.glide.is_some() {
            ui.ctx().request_repaint_after(FRAME);
        } else if moving {
            ui.ctx().request_repaint_after(REST);
        }
    }

    /// Where one looks, in parts of the picture: at the pointer, or in the middle.
    fn focus(&self) -> [f32; 2] {
        let part = |at: egui::Pos2| (at - self.place.min) / self.place.size();
        self.pointer.filter(|at| self.place.contains(*at)).map_or([0.5; 2], |at| part(at).into())
    }
}

/// A function that calls this one.
fn move_clone(notify: &Notify) -> impl Fn() + Clone + Send + 'static + use<> {
    let notify = notify.clone();
    move || notify()
}
