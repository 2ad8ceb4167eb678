//! The parent's side: starts the process, limits it, and restarts it.

use super::{Drawn, Failed, JOB, Load, Request, Task};
use hypertexture::gpu::{Gpu, ending};
use hypertexture::render::{Frame, RenderError, Renderer, Subject};
use hypertexture::scene::{Scene, to_text};
use hypertexture::shader::{self, Library};
use hypertexture_support::jobs::{Child, Ended, Limits};
use std::cell::RefCell;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Processor time allowed for a picture of any size: device, object, pipeline.
pub const PICTURE_TIME: Duration = Duration::from_secs(120);
/// Further processor time allowed per sample, seconds: ten times that of a software driver.
const SECONDS_PER_SAMPLE: f64 = 1e-5;
/// Memory after a picture from which the process is replaced: lavapipe retains hundreds of megabytes for each picture of a
/// large program.
const RETAINED_MEMORY: u64 = 4 << 30;
/// Largest memory during a picture, MiB.
const PEAK_MEMORY_MIB: u64 = 12 << 10;

/// Start options of a worker.
#[derive(Clone, Debug)]
pub struct Start {
    /// The executable of hypertexture.
    pub program: PathBuf,
    /// Part of the name of the device, as for `--device`.
    pub device: Option<String>,
    /// Processor time allowed for a picture in addition to that of its samples; normally [`PICTURE_TIME`].
    pub patience: Duration,
}

/// A child process that renders one object.
pub struct Worker {
    start: Start,
    task: Task,
    state: RefCell<State>,
}

#[derive(Default)]
struct State {
    process: Option<Child>,
    /// Number of processes started.
    generation: u64,
    /// Number of painters created.
    painters: u64,
}

impl Worker {
    /// A worker for an object and the modules of a library; its process starts with the first picture.
    pub fn new(start: &Start, library: &Library, load: Load) -> Worker {
        let task = Task { load, changed: shader::changed(library) };
        Worker { start: start.clone(), task, state: RefCell::default() }
    }

    fn start(&self) -> Result<Child, RenderError> {
        let Start { program, device, patience } = &self.start;
        let limits = Limits { time: *patience, memory_mib: PEAK_MEMORY_MIB, ..Limits::default() };
        let started = Child::start(program, device.as_deref(), JOB, &limits).and_then(|mut process| {
            let (ready, _) = process.ask::<Result<(), Failed>>(&self.task)?;
            Ok(ready.map(|()| process))
        });
        match started {
            Ok(ready) => ready.map_err(|failed| RenderError::Worker(failed.reason)),
            Err(ended) => {
                let (path, reason) = (program.display(), reason(ended));
                Err(RenderError::Worker(format!("`{path}` cannot render in a process of its own: {reason}")))
            }
        }
    }

    /// Renders a scene with the renderer of this number, last used in the process of generation `before`.
    fn draw(&self, number: u64, before: &mut Option<u64>, scene: &Scene, anew: bool) -> Result<Frame, RenderError> {
        let mut state = self.state.borrow_mut();
        let state = &mut *state;
        let process = match &mut state.process {
            Some(process) => process,
            none => {
                state.generation += 1;
                none.insert(self.start()?)
            }
        };
        let generation = state.generation;
        process.limits.time = self.start.patience + Duration::from_secs_f64(SECONDS_PER_SAMPLE * samples(scene));
        let request = Request::Draw(number, to_text(scene), anew);
        // A renderer's first picture differs in its times: in a restarted process it is rendered twice.
        let times = 1 + u32::from(before.is_some_and(|before| before != generation));
        let mut frame = Err(RenderError::Worker("no picture was rendered".into()));
        for _ in 0..times {
            process.send(&request);
            let asked = Instant::now();
            let lost = match process.receive(&|| ending::gives_up(asked)) {
                Ok((Ok(Drawn { size, measurements }), pixels)) => {
                    frame = Ok(Frame { size, pixels: bytemuck::pod_collect_to_vec(&pixels), measurements });
                    continue;
                }
                Ok((Err(Failed { reason, is_lost: false }), _)) => {
                    frame = Err(RenderError::Worker(reason));
                    continue;
                }
                Ok((Err(failed), _)) => failed.reason,
                Err(ended) => reason(ended),
            };
            state.process = None;
            return Err(RenderError::Ended(lost));
        }
        *before = Some(generation);
        if process.memory().is_some_and(|bytes| bytes > RETAINED_MEMORY) {
            state.process = None;
        }
        frame
    }
}

/// Number of samples of a picture.
fn samples(scene: &Scene) -> f64 {
    let quality = &scene.quality;
    let each = [scene.image.size[0], scene.image.size[1], quality.samples, quality.msaa, quality.supersampling];
    each.into_iter().map(f64::from).product()
}

/// Why a process gave no picture.
fn reason(ended: Ended) -> String {
    match ended {
        Ended::Unfit(reason) => reason,
        Ended::Cancelled => "interrupted".into(),
        Ended::Late(seconds) => format!("the driver did not end within {seconds:.0} s of the processor"),
        Ended::Large(mib) => format!("the driver took more than {} GiB of memory", mib >> 10),
        ended => format!("the driver {ended}"),
    }
}

/// A renderer of one subject in this process or in a worker.
pub enum Painter<'a> {
    /// In this process.
    Here(Box<Renderer>),
    /// In a worker.
    There(Remote<'a>),
}

/// A renderer in a worker.
pub struct Remote<'a> {
    worker: &'a Worker,
    number: u64,
    /// Generation of the process that rendered last.
    before: Option<u64>,
}

impl<'a> Painter<'a> {
    /// A painter in the worker, if there is one, else in this process.
    pub fn new(gpu: &'a Gpu, library: &'a Library, subject: &'a Subject, worker: Option<&'a Worker>) -> Painter<'a> {
        match worker {
            Some(worker) => Painter::of(worker),
            None => Painter::Here(Box::new(Renderer::new(gpu, library, subject))),
        }
    }

    /// A painter in a worker.
    pub fn of(worker: &'a Worker) -> Painter<'a> {
        let mut state = worker.state.borrow_mut();
        state.painters += 1;
        Painter::There(Remote { worker, number: state.painters, before: None })
    }

    /// Renders a scene, bit for bit as [`Renderer::render`].
    ///
    /// # Errors
    /// As [`Renderer::render`], or the process has ended.
    pub fn render(&mut self, scene: &Scene) -> Result<Frame, RenderError> {
        match self {
            Painter::Here(renderer) => renderer.render(scene),
            Painter::There(remote) => remote.worker.draw(remote.number, &mut remote.before, scene, false),
        }
    }

    /// Renders a scene and recomputes its shadows, so that its measurements are those of the whole picture.
    ///
    /// # Errors
    /// As [`Painter::render`].
    pub(crate) fn render_anew(&mut self, scene: &Scene) -> Result<Frame, RenderError> {
        match self {
            Painter::Here(renderer) => {
                renderer.invalidate_shadows();
                renderer.render(scene)
            }
            Painter::There(remote) => remote.worker.draw(remote.number, &mut remote.before, scene, true),
        }
    }
}

impl Drop for Remote<'_> {
    fn drop(&mut self) {
        let mut state = self.worker.state.borrow_mut();
        let is_there = self.before == Some(state.generation);
        if let Some(process) = state.process.as_mut().filter(|_| is_there) {
            process.send(&Request::Forget(self.number));
        }
    }
}
