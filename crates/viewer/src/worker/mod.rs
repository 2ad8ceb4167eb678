//! The thread that renders: the newest scene first, coarse while it moves, better and better while it stands still.

mod aside;
mod easel;
mod examine;
mod refine;
mod render_thread;
mod task;

use super::author::Gate;
use super::status::Stage;
use egui::ColorImage;
use hypertexture::gpu::Gpu;
use hypertexture::render::{Subject, ViewPose};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use measure::pick::{ErrorBound, Pick};
use render_thread::RenderThread;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, mpsc};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

pub(super) use easel::sight;

/// A preview is waited for to be on the screen for so long at most: a hidden window shows none.
const SHOWN: Duration = Duration::from_millis(40);
/// While it is, whether it is there is asked this often.
const LOOK: Duration = Duration::from_micros(500);

/// A scene with its modules and its object.
#[derive(Clone)]
pub(super) struct Variant {
    pub(super) scene: Scene,
    pub(super) library: Arc<Library>,
    pub(super) subject: Arc<Subject>,
}

impl Variant {
    /// Whether another one has the same modules and object.
    pub(super) fn is_made_as(&self, other: &Variant) -> bool {
        Arc::ptr_eq(&self.library, &other.library) && Arc::ptr_eq(&self.subject, &other.subject)
    }
}

/// What is to be on the screen.
#[derive(Clone)]
pub(super) struct Job {
    /// Larger than that of the job before.
    pub(super) number: u64,
    /// One, or two to be compared; their pictures have the same size.
    pub(super) variants: Vec<Variant>,
    /// Whether the next one is expected soon.
    pub(super) moving: bool,
    /// The error that is good enough.
    pub(super) max_error: f64,
    /// Where one looks, in parts of the width and height of a picture: what is there gets finer first.
    pub(super) focus: [f32; 2],
    /// Whether the pixels that are not to be trusted are shown, once the picture is finished; of one variant.
    pub(super) validity: bool,
}

/// What is done between two jobs.
pub(super) enum Task {
    /// Writes the picture that `render` makes. `edited` are modules that are in no file as they are drawn here.
    Shot { variant: Box<Variant>, path: PathBuf, edited: Vec<String> },
    /// Writes a turn around the object.
    Turntable { variant: Box<Variant>, path: PathBuf, frames: u32, edited: Vec<String> },
    /// Looks for the fastest settings within an error.
    Pick { variant: Box<Variant>, bound: ErrorBound },
}

/// A picture, ready to be shown, and what is known about it.
#[derive(Default)]
pub(super) struct Picture {
    /// That of its job.
    pub(super) number: u64,
    /// One for each variant.
    pub(super) images: Vec<ColorImage>,
    /// What they are of: premultiplied linear RGBA; none where pixels are colored by what they are worth.
    pub(super) frames: Vec<Arc<[[f32; 4]]>>,
    /// Root mean square difference of two variants, where both are as finely sampled.
    pub(super) difference: Option<f64>,
    pub(super) size: [u32; 2],
    pub(super) samples: u32,
    /// Where it is looked at from.
    pub(super) sight: Option<ViewPose>,
    pub(super) stage: Stage,
    /// Milliseconds on the device, of all variants.
    pub(super) gpu_ms: f64,
    pub(super) error: Option<f64>,
    pub(super) standard_error: Option<f64>,
    /// What the colors of pixels that are not to be trusted mean.
    pub(super) validity: Vec<([u8; 3], String)>,
}

/// What the thread tells.
pub(super) enum Event {
    /// There is a picture.
    Picture(Box<Picture>),
    /// What the picture of a job was made with: what each line is about, and what there is.
    Made(Vec<[String; 2]>),
    /// What was set and changes nothing in the picture.
    Ignored(Vec<String>),
    /// A file was written.
    Wrote(PathBuf),
    /// So much of the search for a way to draw is done.
    Picking(f32),
    /// A way to draw was found, or the search was given up.
    Picked(Option<Box<Pick>>),
    /// So many frames of a recording are written.
    Recorded(u32, u32),
    /// A recording was ended by hand; one line.
    Stopped(String),
    /// A program may not be drawn; one line.
    Refused(String),
    /// Something could not be done; one line.
    Failed(String),
    /// The device is gone, and the thread with it.
    Lost,
}

/// The thread, which ends with this.
pub(super) struct Worker {
    shared: Arc<Shared>,
    pub(super) events: mpsc::Receiver<Event>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    inbox: Mutex<Inbox>,
    wake: Condvar,
    /// Number of the newest job.
    newest: AtomicU64,
    /// Whether the thread ends.
    quit: AtomicBool,
    /// Whether a recording or a search ends.
    stop: AtomicBool,
    /// The jobs of the last preview that was told of, and of the last picture that the window was drawn with.
    told: AtomicU64,
    shown: AtomicU64,
}

#[derive(Default)]
struct Inbox {
    job: Option<Job>,
    tasks: VecDeque<Task>,
}

impl Shared {
    fn inbox(&self) -> MutexGuard<'_, Inbox> {
        self.inbox.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    fn quits(&self) -> bool {
        self.quit.load(Ordering::Relaxed)
    }

    /// Waits until the window was drawn with the last preview: on a device that draws both, the next one would keep it
    /// waiting.
    fn wait_until_shown(&self) {
        let until = Instant::now() + SHOWN;
        while self.shown.load(Ordering::Relaxed) < self.told.load(Ordering::Relaxed) && Instant::now() < until {
            thread::sleep(LOOK);
        }
    }

    /// Whether something is more urgent than the job of this number.
    fn is_stale(&self, number: u64) -> bool {
        self.quits() || self.newest.load(Ordering::Relaxed) != number
    }
}

impl Worker {
    /// Starts the thread. `notify` is called from it when there is an event.
    pub(super) fn start(
        gpu: Gpu,
        gate: Arc<Gate>,
        budget_ms: f64,
        notify: impl Fn() + Send + Sync + 'static,
    ) -> Worker {
        let shared = Arc::new(Shared::default());
        let (sender, events) = mpsc::channel();
        let own = shared.clone();
        let thread = thread::spawn(move || {
            let tell = move |event| {
                // Nobody listens any more when the window is closed.
                let _ = sender.send(event);
                notify();
            };
            RenderThread::new(gpu, gate, own, budget_ms, Box::new(tell)).run();
        });
        Worker { shared, events, thread: Some(thread) }
    }

    /// Puts a job in place of the one before.
    pub(super) fn show(&self, job: Job) {
        self.shared.newest.store(job.number, Ordering::Relaxed);
        self.shared.inbox().job = Some(job);
        self.shared.wake.notify_one();
    }

    /// The window was drawn with the picture of a job.
    pub(super) fn shown(&self, number: u64) {
        self.shared.shown.store(number, Ordering::Relaxed);
    }

    /// Does a task as soon as the picture in work is interrupted.
    pub(super) fn add(&self, task: Task) {
        self.shared.stop.store(false, Ordering::Relaxed);
        self.shared.newest.store(u64::MAX, Ordering::Relaxed);
        self.shared.inbox().tasks.push_back(task);
        self.shared.wake.notify_one();
    }

    /// Whether the thread has ended by itself: with the device, or by a fault of its own.
    pub(super) fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Ends a recording or a search.
    pub(super) fn stop(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.shared.quit.store(true, Ordering::Relaxed);
        self.stop();
        drop(self.shared.inbox()); // whoever is about to wait has seen nothing yet
        self.shared.wake.notify_one();
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            log::error!("the thread that renders has failed");
        }
    }
}
