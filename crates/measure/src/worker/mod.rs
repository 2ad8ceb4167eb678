//! Pictures drawn in a process of their own: a driver that crashes or hangs on one of them costs that one.
//!
//! Role: [`Painter`] draws as a [`Renderer`] does, here or in a [`Worker`]; a worker that has ended is started again for the
//! next picture. The worker is this very program with a hidden command ([`serve`]): it loads the object once, keeps a
//! renderer for each painter, and answers line by line. Invariant: what a picture may take is time of the processor, so
//! that a busy machine refuses none; times are measured in the worker, where nothing else runs meanwhile.

mod serve;

pub use serve::serve;

use hypertexture::gpu::Gpu;
use hypertexture::render::{Frame, Measurements, RenderError, Renderer, Subject};
use hypertexture::scene::{Object, Scene, to_text};
use hypertexture::shader::{self, Library};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;
use support::watchdog::{Excess, Watchdog, describe, memory};

/// Name of the hidden command.
pub const COMMAND: &str = "draw";
/// Processor time that a picture may take whatever its size: a device, an object, a pipeline.
pub const PATIENCE: Duration = Duration::from_secs(120);
/// Processor time that each of its samples may take beyond that, seconds: ten times what a software driver needs.
const SAMPLE: f64 = 1e-5;
/// A process that holds more after a picture is replaced: lavapipe keeps hundreds of megabytes for each picture of a large
/// program.
const MOST_MEMORY: u64 = 4 << 30;
/// Memory that it may hold while it draws.
const MOST_WHILE: u64 = 12 << 30;
/// How often a worker is watched.
const LOOK: Duration = Duration::from_millis(20);

/// How workers are started.
#[derive(Clone, Debug)]
pub struct Start {
    /// The executable of hypertexture.
    pub program: PathBuf,
    /// Part of the name of the device, as the program takes it.
    pub device: Option<String>,
    /// Processor time that a picture may take, beside what it may for its samples; [`PATIENCE`] unless there is a reason.
    pub patience: Duration,
}

/// What a worker loads its object from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Load {
    /// The text of a scene: [`Subject::load`].
    Scene(String),
    /// [`Subject::load_with_margin`].
    Object {
        /// The object.
        object: Box<Object>,
        /// How far its field reaches, object units.
        margin: f32,
        /// Whether it has its closest points.
        closest: bool,
    },
}

/// The first line that a worker reads.
#[derive(Debug, Serialize, Deserialize)]
struct Task {
    load: Load,
    /// The modules that are not as shipped.
    changed: BTreeMap<String, String>,
}

/// What a worker is asked, a line each.
#[derive(Debug, Serialize, Deserialize)]
enum Request {
    /// A picture by the renderer of this number, its shadows cast anew or not.
    Draw(u64, String, bool),
    /// That renderer is not used any more.
    Forget(u64),
}

/// What it answers, a line each.
#[derive(Debug, Serialize, Deserialize)]
enum Answer {
    /// The device is open and the object loaded.
    Ready,
    /// A picture; its pixels follow as bytes.
    Drawn([u32; 2], Box<Measurements>),
    /// Why there is none; the device may be lost with it.
    Failed { reason: String, is_lost: bool },
}

/// A process that draws pictures of one object.
pub struct Worker {
    start: Start,
    task: String,
    state: RefCell<State>,
}

#[derive(Default)]
struct State {
    process: Option<Process>,
    /// How many processes there were.
    generation: u64,
    /// How many painters there were.
    painters: u64,
}

impl Worker {
    /// A worker for an object and the modules of a library; its process is started with the first picture.
    pub fn new(start: &Start, library: &Library, load: Load) -> Worker {
        let task = line(&Task { load, changed: shader::changed(library) });
        Worker { start: start.clone(), task, state: RefCell::default() }
    }

    /// Draws a scene with the renderer of that number, which the process of that generation has drawn with before.
    fn draw(&self, number: u64, before: &mut Option<u64>, scene: &Scene, anew: bool) -> Result<Frame, RenderError> {
        let mut state = self.state.borrow_mut();
        let state = &mut *state;
        let process = match &mut state.process {
            Some(process) => process,
            none => {
                state.generation += 1;
                none.insert(Process::start(&self.start, &self.task)?)
            }
        };
        let generation = state.generation;
        let patience = self.start.patience + Duration::from_secs_f64(SAMPLE * samples(scene));
        let request = line(&Request::Draw(number, to_text(scene), anew));
        // In a new process the first picture is not what it was: what is drawn twice has its own first one there.
        let times = 1 + u32::from(before.is_some_and(|before| before != generation));
        let mut frame = Err(RenderError::Worker("nothing was drawn".into()));
        for _ in 0..times {
            frame = match process.ask(&request, patience) {
                Ok((Answer::Drawn(size, measurements), pixels)) => {
                    Ok(Frame { size, pixels, measurements: *measurements })
                }
                Ok((Answer::Failed { reason, is_lost: false }, _)) => Err(RenderError::Worker(reason)),
                Ok((Answer::Failed { reason, .. }, _)) | Err(reason) => {
                    state.process = None;
                    return Err(RenderError::Ended(reason));
                }
                Ok((Answer::Ready, _)) => Err(RenderError::Worker("the worker says what it was not asked".into())),
            };
        }
        *before = Some(generation);
        if memory(process.child.id()).is_some_and(|bytes| bytes > MOST_MEMORY) {
            state.process = None;
        }
        frame
    }
}

/// Samples of a picture.
fn samples(scene: &Scene) -> f64 {
    let quality = &scene.quality;
    let each = [scene.image.size[0], scene.image.size[1], quality.samples, quality.msaa, quality.supersampling];
    each.into_iter().map(f64::from).product()
}

/// A value as a line of text.
fn line(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("requests and answers hold nothing that JSON cannot hold") + "\n"
}

/// A worker that runs.
struct Process {
    child: Child,
    input: ChildStdin,
    answers: Receiver<(Answer, Vec<[f32; 4]>)>,
}

impl Process {
    fn start(start: &Start, task: &str) -> Result<Process, RenderError> {
        let fail = |reason: &dyn std::fmt::Display| {
            RenderError::Worker(format!("`{}` cannot draw in a process of its own: {reason}", start.program.display()))
        };
        let mut command = Command::new(&start.program);
        command.arg(COMMAND).args(start.device.iter().flat_map(|device| ["--device", device]));
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0); // Ctrl-C is for whoever waits for it
        let mut child = command.spawn().map_err(|error| fail(&error))?;
        let (Some(input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(fail(&"it has no standard input or output"));
        };
        let (tell, answers) = channel();
        let listen = move || {
            let mut output = BufReader::new(output);
            // Once the worker or its parent has ended, so does this.
            while let Some(answer) = read_answer(&mut output) {
                if tell.send(answer).is_err() {
                    break;
                }
            }
        };
        std::thread::Builder::new().spawn(listen).map_err(|error| fail(&error))?;
        let mut process = Process { child, input, answers };
        match process.ask(task, start.patience).map_err(|reason| fail(&reason))?.0 {
            Answer::Ready => Ok(process),
            Answer::Failed { reason, .. } => Err(RenderError::Worker(reason)),
            Answer::Drawn(..) => Err(fail(&"it does not answer what it was asked")),
        }
    }

    /// Sends a line and waits for the answer; the error says how the worker has ended.
    fn ask(&mut self, text: &str, patience: Duration) -> Result<(Answer, Vec<[f32; 4]>), String> {
        let mut watch = Watchdog::new(self.child.id(), patience, MOST_WHILE);
        let _ = self.input.write_all(text.as_bytes()); // a worker that has ended says more by its end
        loop {
            match self.answers.recv_timeout(LOOK) {
                Ok(answer) => return Ok(answer),
                Err(RecvTimeoutError::Timeout) => match watch.excess() {
                    Some(Excess::Time) => {
                        let seconds = patience.as_secs_f32();
                        return Err(format!("the driver did not end within {seconds:.0} s of the processor"));
                    }
                    Some(Excess::Memory) => {
                        return Err(format!("the driver took more than {} GiB of memory", MOST_WHILE >> 30));
                    }
                    None => {}
                },
                Err(RecvTimeoutError::Disconnected) => {
                    let how = self.child.wait().map_or_else(|error| error.to_string(), describe);
                    return Err(format!("the driver crashed ({how})"));
                }
            }
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill(); // it may have ended before
        let _ = self.child.wait();
    }
}

/// An answer and its pixels; `None` at the end.
fn read_answer(output: &mut impl BufRead) -> Option<(Answer, Vec<[f32; 4]>)> {
    let mut text = String::new();
    output.read_line(&mut text).ok()?;
    let answer = serde_json::from_str(&text).ok()?;
    let mut pixels = Vec::new();
    if let Answer::Drawn([width, height], _) = answer {
        pixels = vec![[0f32; 4]; width as usize * height as usize];
        output.read_exact(bytemuck::cast_slice_mut(&mut pixels)).ok()?;
    }
    Some((answer, pixels))
}

/// Draws scenes of one subject, as a [`Renderer`] does: it is one, or asks a worker for one.
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
    /// The process that it last drew in.
    before: Option<u64>,
}

impl<'a> Painter<'a> {
    /// A painter of the worker, if there is one, or of this process.
    pub fn new(gpu: &'a Gpu, library: &'a Library, subject: &'a Subject, worker: Option<&'a Worker>) -> Painter<'a> {
        match worker {
            Some(worker) => Painter::of(worker),
            None => Painter::Here(Box::new(Renderer::new(gpu, library, subject))),
        }
    }

    /// A painter of a worker.
    pub fn of(worker: &'a Worker) -> Painter<'a> {
        let mut state = worker.state.borrow_mut();
        state.painters += 1;
        Painter::There(Remote { worker, number: state.painters, before: None })
    }

    /// Renders a scene, as [`Renderer::render`] does, bit for bit.
    ///
    /// # Errors
    /// As [`Renderer::render`]; or the worker has ended by it.
    pub fn render(&mut self, scene: &Scene) -> Result<Frame, RenderError> {
        match self {
            Painter::Here(renderer) => renderer.render(scene),
            Painter::There(remote) => remote.worker.draw(remote.number, &mut remote.before, scene, false),
        }
    }

    /// Renders a scene with shadows cast anew, so that its measurements are those of the whole picture.
    ///
    /// # Errors
    /// As [`Painter::render`].
    pub fn render_anew(&mut self, scene: &Scene) -> Result<Frame, RenderError> {
        match self {
            Painter::Here(renderer) => {
                renderer.forget_shadows();
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
            let _ = process.input.write_all(line(&Request::Forget(self.number)).as_bytes());
        }
    }
}
