//! The state of the window, in parts by subject.

use super::jobs::Jobs;
use crate::ViewError;
use crate::background::{Background, Notify};
use crate::document::Document;
use crate::document::author::Author;
use crate::document::model::Model;
use crate::document::unsaved::{self, Latest};
use crate::facts::{Densities, UnusedSettings};
use crate::input::trackball::Trackball;
use crate::inspect::Inspector;
use crate::lesson::Lesson;
use crate::load::{Loader, Progress};
use crate::message::Message;
use crate::panels::Panels;
use crate::playback::Playback;
use crate::screen::{Comparison, Screen};
use crate::worker::{Figures, Worker};
use egui::{Pos2, Rect};
use glam::DVec3;
use hypertexture::gpu::{Gpu, Image, Options};
use hypertexture::scene::{self, Camera, Scene};
use hypertexture::shader::Library;
use hypertexture_support::disk_cache;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Error target without `--max-error`: half a step of 8 bits in the mid tones.
pub(super) const GOOD: f64 = 1e-3;

/// Arguments of the window.
pub struct Start {
    /// The scene, which has passed its checks.
    pub scene: Scene,
    /// The modules of the scene.
    pub library: Library,
    /// Options for opening the device.
    pub options: Options,
    /// Root mean square error at which a picture has converged.
    pub max_error: Option<f64>,
    /// Whether time runs from the beginning.
    pub play: bool,
    /// Width and height of the window, points.
    pub window: [u32; 2],
    /// Number of frames to draw after the first picture before the screenshot and the exit.
    pub frames: Option<u32>,
    /// Path of a screenshot, taken after `frames`, or once the picture has converged.
    pub screenshot: Option<PathBuf>,
    /// The file from which the scene was read.
    pub file: Option<PathBuf>,
    /// Path of a script of user input.
    pub script: Option<PathBuf>,
    /// Start of the program.
    pub began: Instant,
}

/// Milliseconds for a preview, on a CPU and on a GPU.
const BUDGET_MS: [f64; 2] = [30.0, 12.0];

/// The state of the window.
pub(crate) struct App {
    pub(crate) document: Document,
    pub(super) panels: Panels,
    pub(super) library: Arc<Library>,
    pub(crate) worker: Option<Worker>,
    pub(super) loader: Loader,
    pub(super) notify: Notify,
    pub(super) screen: Screen,
    pub(crate) figures: Figures,
    /// Rectangle of the picture, points.
    pub(crate) place: Rect,
    pub(super) navigation: Navigation,
    pub(super) time: Time,
    pub(super) comparison: Compared,
    pub(crate) inspector: Inspector,
    pub(crate) lesson: Lesson,
    pub(super) objects: Objects,
    /// Error target of the pictures.
    pub(super) max_error: Option<f64>,
    /// Whether pixels are colored by their validity.
    pub(super) validity: bool,
    pub(super) densities: Densities,
    pub(super) unused_settings: UnusedSettings,
    pub(crate) jobs: Jobs,
    pub(super) search: Search,
    pub(super) help: bool,
    pub(super) help_search: String,
    /// The first failure of an object or a task, which ends a script.
    pub(crate) failure: Option<String>,
    pub(crate) lost: bool,
    pub(crate) quit: bool,
    pub(crate) full_screen: bool,
    /// The last message, and the newest job at that time.
    pub(super) message: Option<Message>,
    pub(super) message_job: u64,
}

/// The effect of a drag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Drag {
    #[default]
    Turn,
    Pan,
    Light,
}

/// Camera control by the mouse.
pub(super) struct Navigation {
    pub(super) ball: Trackball,
    /// Axis and radians per second of a rotation that goes on after a drag.
    pub(super) glide: Option<(DVec3, f64)>,
    /// Axis and radians per second of the last move of a drag.
    pub(super) last_turn: (DVec3, f64),
    pub(super) inertia: bool,
    /// Whether a drag keeps the vertical axis upright.
    pub(super) level: bool,
    pub(super) drag: Drag,
    pub(super) dragging: bool,
    /// Whether a stroke of the brush was refused, whose drag moves nothing.
    pub(super) is_refused: bool,
    /// Position of the pointer over the picture.
    pub(super) pointer: Option<Pos2>,
}

impl Navigation {
    fn new(camera: &Camera) -> Navigation {
        Navigation {
            ball: Trackball::of(camera),
            glide: None,
            last_turn: (DVec3::Y, 0.0),
            inertia: false,
            level: false,
            drag: Drag::default(),
            dragging: false,
            is_refused: false,
            pointer: None,
        }
    }
}

/// Selection and placement of additional objects.
#[derive(Default)]
pub(super) struct Objects {
    /// Search for the name of the object of a click; `None` if the ray hits none.
    pub(super) clicked: Option<Background<Option<String>>>,
    /// Whether drags place the selected object, or the light if none is selected.
    pub(super) places: bool,
    pub(super) gizmo: Gizmo,
}

/// State of the gizmo.
#[derive(Default)]
pub(super) struct Gizmo {
    /// The axis of the drag in progress.
    pub(super) grabbed: Option<usize>,
    /// The last used axis, and whether it was turned about.
    pub(super) last: (usize, bool),
    /// The number typed so far.
    pub(super) typed: String,
}

/// Time of the scene.
pub(super) struct Time {
    /// The time while it runs.
    pub(super) clock: Option<f64>,
    pub(super) playback: Playback,
    pub(super) last_frame: Instant,
}

/// The scene that is compared with the current one.
#[derive(Default)]
pub(super) struct Compared {
    /// The pinned scene and its modules.
    pub(super) pinned: Option<(Arc<Scene>, Arc<Library>)>,
    /// Titles of the last two scenes, which are compared once.
    pub(super) titles: Option<([Arc<Scene>; 2], [String; 2])>,
    pub(super) view: Comparison,
}

/// The search for the fastest settings.
#[derive(Default)]
pub(super) struct Search {
    /// Error of a search that has not started.
    pub(super) pick: Option<f64>,
    /// The scene of the running search.
    pub(super) picked_for: Option<Arc<Scene>>,
}

impl App {
    /// A window without a device.
    pub(crate) fn new(start: &Start, notify: Notify) -> Result<App, ViewError> {
        let mut model = Model::new(start.scene.clone(), start.library.clone())?;
        model.set_file(start.file.clone());
        let program = std::env::current_exe().unwrap_or_else(|_| PathBuf::from("hypertexture"));
        let mut document = Document::new(model, program).map_err(scene::SceneError::from)?;
        let mut panels = Panels::default();
        panels.remember(unsaved::kept(), disk_cache::default_folder());
        let Document { model, author, .. } = &mut document;
        let modules = &model.scene().modules;
        if let Some((slot, name, file)) =
            modules.iter().find_map(|(module, file)| module.split_once('/').map(|(slot, name)| (slot, name, file)))
        {
            let followed = author.follow(model.library(), slot, name, Path::new(file));
            followed.unwrap_or_else(|error| log::warn!("{error}"));
        }
        let (now, camera) = (Instant::now(), model.scene().camera.clone());
        let mut playback = Playback::default();
        playback.reach(camera.time);
        Ok(App {
            library: model.shared_library().clone(),
            panels,
            worker: None,
            loader: Loader::default(),
            notify,
            screen: Screen::default(),
            figures: Figures::default(),
            place: Rect::ZERO,
            navigation: Navigation::new(&camera),
            time: Time { clock: start.play.then_some(camera.time), playback, last_frame: now },
            comparison: Compared::default(),
            inspector: Inspector::default(),
            lesson: Lesson::default(),
            objects: Objects::default(),
            max_error: start.max_error,
            validity: false,
            densities: Densities::default(),
            unused_settings: UnusedSettings::default(),
            jobs: Jobs::new(now),
            search: Search { pick: start.max_error, picked_for: None },
            help: false,
            help_search: String::new(),
            failure: None,
            lost: false,
            quit: false,
            full_screen: false,
            message: None,
            message_job: 0,
            document,
        })
    }

    /// Uses a device, the first one or the replacement of a lost one.
    pub(crate) fn use_device(&mut self, gpu: &Gpu) {
        let info = gpu.info();
        self.figures.device = format!("{} ({})", info.name, info.driver);
        (self.figures.is_cpu, self.figures.budget_ms) = (info.cpu, BUDGET_MS[usize::from(!info.cpu)]);
        let gate = self.document.author.gate().clone();
        gate.try_on(&info.name);
        self.worker = Some(Worker::start(gpu.clone(), gate, self.figures.budget_ms, self.notify.clone()));
        self.lesson.use_device(Some(gpu));
        self.screen.forget();
        (self.jobs.submitted, self.lost, self.figures.picking) = (None, false, None);
    }

    /// Drops everything that holds the device.
    pub(crate) fn leave_device(&mut self) {
        self.worker = None;
        self.lesson.use_device(None);
        self.screen.leave_device();
    }

    /// The pictures on the screen that the device has encoded.
    pub(crate) fn pictures(&self) -> &[Arc<Image>] {
        self.screen.images.of_device()
    }

    /// Skips the time since the last frame.
    pub(crate) fn rest(&mut self) {
        self.time.last_frame = Instant::now();
    }

    /// Notes unsaved work.
    pub(crate) fn note_unsaved(&mut self, latest: &Latest) {
        self.document.restored.take().into_iter().for_each(|folder| latest.took(folder));
        latest.note(&self.document.model, &self.document.author, &self.document.painting);
    }

    /// Notes unsaved work at the end of the window, also that of a stroke that goes on.
    pub(crate) fn note_last(&self, latest: &Latest) {
        latest.note_last(&self.document.model, &self.document.author, &self.document.painting);
    }

    /// The edited module.
    pub(crate) fn author(&mut self) -> &mut Author {
        &mut self.document.author
    }

    /// The title of the window: the scene, after a dot if there is unsaved work.
    pub(crate) fn title(&self) -> String {
        let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
        let input = &self.document.model.scene().object.input;
        let of = || name(Path::new(input)).unwrap_or_default();
        let scene = self.document.model.file().and_then(name).unwrap_or_else(|| match self.document.model.preset() {
            Some(preset) => format!("{}, {preset}", of()),
            None => of(),
        });
        let mark = if self.document.is_unsaved() { "\u{2022} " } else { "" };
        format!("{mark}{scene} \u{2013} hypertexture")
    }

    /// Whether the picture shows the current scene.
    pub(crate) fn is_current(&self) -> bool {
        !self.jobs.lacks_object && self.jobs.since > 0 && self.jobs.on_screen >= self.jobs.since
    }

    /// Whether no search, final picture or measurement is running.
    pub(crate) fn is_idle(&self) -> bool {
        self.figures.picking.is_none() && !self.document.exports.is_running() && !self.lesson.is_measuring()
    }

    /// Progress of the object that is being loaded.
    pub(crate) fn loading(&self) -> Option<Progress> {
        self.loader.progress()
    }

    /// Work that an automated run waits for, in words.
    pub(crate) fn awaited(&self) -> String {
        let error = self.figures.error;
        match (self.document.exports.progress(), self.loading()) {
            (Some(progress), _) => format!("the screenshot: {progress}"),
            (None, Some(Progress { name, done, seconds })) if done > 0.0 => {
                format!("the distance field of {name}: {:.0} %, {seconds} s", 100.0 * done)
            }
            (None, Some(Progress { name, seconds, .. })) => format!("{name}, which is read since {seconds} s"),
            _ if !self.is_current() => "the first picture, whose programs are compiled".into(),
            _ if error.is_some() => format!("the picture: {}", self.figures.words(self.max_error.unwrap_or(GOOD))),
            _ => format!("the picture: {}", self.figures.words(GOOD)),
        }
    }

    /// Shows a note.
    pub(super) fn note(&mut self, line: impl Into<String>) {
        self.message = Some(Message::note(line));
    }

    /// Shows an error until the picture of a newer job arrives.
    pub(super) fn fail(&mut self, line: impl Into<String>) {
        (self.message, self.message_job) = (Some(Message::error(line)), self.jobs.number);
    }
}
