//! What happens in the window: the mouse and the keys to the scene, the scene to the thread that renders.

mod actions;
mod inspect;
mod mouse;
mod overlay;
mod post;
mod receive;

use super::ViewError;
use super::author::Author;
use super::compare::Comparison;
use super::densities::Densities;
use super::inspect::Inspector;
use super::keys;
use super::load::Loader;
use super::message::Message;
use super::model::Model;
use super::panels::Panels;
use super::screen::Screen;
use super::status::{Figures, Stage};
use super::tempo::Tempo;
use super::trackball::Trackball;
use super::unread::Unread;
use super::unsaved::{self, Latest};
use super::worker::{Job, Worker};
use egui::{Rect, Sense, Ui};
use glam::DVec3;
use hypertexture::gpu::{Gpu, Options};
use hypertexture::render::ViewPose;
use hypertexture::scene::{self, Scene};
use hypertexture::shader::Library;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use support::disk_cache;

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
const BUDGET_MS: [f64; 2] = [30.0, 12.0];
/// While the scene moves, the window waits so long for a preview before it is drawn with the old picture moved: on a device
/// that draws both, one would keep the other waiting.
const HOLD: Duration = Duration::from_millis(45);
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
    seen: Option<ViewPose>,
    sight: Option<ViewPose>,
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
    /// The variant that the scene is compared with, and its modules.
    kept: Option<(Scene, Arc<Library>)>,
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
    /// Since when a preview is waited for, and the time that one takes.
    held: Option<Instant>,
    changed: Instant,
    /// Whether there is a picture that the window was not drawn with.
    fresh: bool,
    /// Those of the newest job and of the picture that is on the screen.
    pub(super) number: u64,
    pub(super) on_screen: u64,
    /// The first job of the scene as it is now, or as it was before its object was lacking.
    since: u64,
    /// Whether an object of the scene as it is now is not there: it is being loaded, or cannot be.
    pub(super) lacks_object: bool,
    /// Tasks that are not finished.
    pub(super) tasks: u32,
    help: bool,
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
        let mut tempo = Tempo::default();
        tempo.reach(camera.time);
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
            tempo,
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
            held: None,
            changed: now,
            fresh: false,
            number: 0,
            on_screen: 0,
            since: 0,
            lacks_object: false,
            tasks: 0,
            help: false,
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
        (self.figures.is_cpu, self.figures.budget_ms) = (info.cpu, BUDGET_MS[usize::from(!info.cpu)]);
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

    /// Lets time stand still until now.
    pub(super) fn rest(&mut self) {
        self.last_frame = Instant::now();
    }

    /// Tells what no file holds.
    pub(super) fn note_unsaved(&mut self, latest: &Latest) {
        latest.note(&self.model, self.panels.author());
    }

    /// The module that is being edited.
    pub(super) fn author(&mut self) -> &mut Author {
        self.panels.author()
    }

    /// The title of the window: the scene, behind a dot where something is not saved.
    pub(super) fn title(&self) -> String {
        let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
        let input = &self.model.scene().object.input;
        let of = || name(Path::new(input)).unwrap_or_default();
        let scene = self.model.file().and_then(name).unwrap_or_else(|| match self.model.preset() {
            Some(preset) => format!("{}, {preset}", of()),
            None => of(),
        });
        let mark = if self.panels.is_unsaved(&self.model) { "\u{2022} " } else { "" };
        format!("{mark}{scene} \u{2013} hypertexture")
    }

    /// Whether the picture is that of the scene as it is now.
    pub(super) fn is_current(&self) -> bool {
        !self.lacks_object && self.since > 0 && self.on_screen >= self.since
    }

    /// What is being loaded, and how far it is.
    pub(super) fn loading(&self) -> Option<(String, f32)> {
        self.loader.progress()
    }

    /// How long the window may still wait for a preview that is about to come, since it was first asked; none where it is
    /// to be drawn now.
    pub(super) fn hold(&mut self, now: Instant) -> Option<Duration> {
        let is_coming = self.on_screen < self.number && self.figures.stage == Stage::Coarse;
        let soon = self.figures.is_cpu && is_coming && self.posted.as_ref().is_some_and(|job| job.moving);
        let left = HOLD.saturating_sub(now.duration_since(*self.held.get_or_insert(now)));
        if soon && !self.fresh && !left.is_zero() {
            return Some(left);
        }
        self.held = None;
        None
    }

    /// The window was drawn.
    pub(super) fn drawn(&mut self) {
        self.fresh = false;
        if let Some(worker) = &self.worker {
            worker.shown(self.on_screen);
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
            self.tempo.reach(*clock);
        }
        self.post(ui, now);
        self.screen.moved = self.seen.zip(self.sight).filter(|(seen, now)| seen != now);
        self.screen.draw(ui, self.place, &self.comparison);
        self.show_over(ui);
        self.pick(ui, now);
        keys::writes(ui.ctx());
    }
}
