//! The parent's side: starts the process, limits it, and restarts it.

use super::protocol::{Answer, COMMAND, Load, Request, Task, line};
use hypertexture::gpu::Gpu;
use hypertexture::render::{Frame, RenderError, Renderer, Subject};
use hypertexture::scene::{Scene, to_text};
use hypertexture::shader::{self, Library};
use std::cell::RefCell;
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;
use support::watchdog::{Excess, Watchdog, describe, memory};

/// Processor time allowed for a picture of any size: device, object, pipeline.
pub const PATIENCE: Duration = Duration::from_secs(120);
/// Further processor time allowed per sample, seconds: ten times that of a software driver.
const SECONDS_PER_SAMPLE: f64 = 1e-5;
/// Memory after a picture from which the process is replaced: lavapipe retains hundreds of megabytes for each picture of a
/// large program.
const RETAINED_MEMORY: u64 = 4 << 30;
/// Largest memory during a picture.
const PEAK_MEMORY: u64 = 12 << 30;
/// Interval between checks of the limits.
const POLL: Duration = Duration::from_millis(20);

/// Start options of a worker.
#[derive(Clone, Debug)]
pub struct Start {
    /// The executable of hypertexture.
    pub program: PathBuf,
    /// Part of the name of the device, as for `--device`.
    pub device: Option<String>,
    /// Processor time allowed for a picture in addition to that of its samples; normally [`PATIENCE`].
    pub patience: Duration,
}

/// A child process that renders one object.
pub struct Worker {
    start: Start,
    task: String,
    state: RefCell<State>,
}

#[derive(Default)]
struct State {
    process: Option<Process>,
    /// Number of processes started.
    generation: u64,
    /// Number of painters created.
    painters: u64,
}

impl Worker {
    /// A worker for an object and the modules of a library; its process starts with the first picture.
    pub fn new(start: &Start, library: &Library, load: Load) -> Worker {
        let task = line(&Task { load, changed: shader::changed(library) });
        Worker { start: start.clone(), task, state: RefCell::default() }
    }

    /// Renders a scene with the renderer of this number, last used in the process of generation `before`.
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
        let patience = self.start.patience + Duration::from_secs_f64(SECONDS_PER_SAMPLE * samples(scene));
        let request = line(&Request::Draw(number, to_text(scene), anew));
        // A renderer's first picture differs in its times: in a restarted process it is rendered twice.
        let times = 1 + u32::from(before.is_some_and(|before| before != generation));
        let mut frame = Err(RenderError::Worker("no picture was rendered".into()));
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
                Ok((Answer::Ready, _)) => Err(RenderError::Worker("unexpected answer of the worker".into())),
            };
        }
        *before = Some(generation);
        if memory(process.child.id()).is_some_and(|bytes| bytes > RETAINED_MEMORY) {
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

/// A running process.
struct Process {
    child: Child,
    input: ChildStdin,
    answers: Receiver<(Answer, Vec<[f32; 4]>)>,
}

impl Process {
    fn start(start: &Start, task: &str) -> Result<Process, RenderError> {
        let fail = |reason: &dyn std::fmt::Display| {
            RenderError::Worker(format!(
                "`{}` cannot render in a process of its own: {reason}",
                start.program.display()
            ))
        };
        let mut command = Command::new(&start.program);
        command.arg(COMMAND).args(start.device.iter().flat_map(|device| ["--device", device]));
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0); // Ctrl-C goes to the parent alone
        let mut child = command.spawn().map_err(|error| fail(&error))?;
        let (Some(input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(fail(&"it has no standard input or output"));
        };
        let (tell, answers) = channel();
        let listen = move || {
            let mut output = BufReader::new(output);
            // Ends with the process or its parent.
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
            Answer::Drawn(..) => Err(fail(&"unexpected answer")),
        }
    }

    /// Sends a line and waits for the answer; the error describes the end of the process.
    fn ask(&mut self, text: &str, patience: Duration) -> Result<(Answer, Vec<[f32; 4]>), String> {
        let mut watch = Watchdog::new(self.child.id(), patience, PEAK_MEMORY);
        let _ = self.input.write_all(text.as_bytes()); // a failure shows in the end of the process
        loop {
            match self.answers.recv_timeout(POLL) {
                Ok(answer) => return Ok(answer),
                Err(RecvTimeoutError::Timeout) => match watch.excess() {
                    Some(Excess::Time) => {
                        let seconds = patience.as_secs_f32();
                        return Err(format!("the driver did not end within {seconds:.0} s of the processor"));
                    }
                    Some(Excess::Memory) => {
                        return Err(format!("the driver took more than {} GiB of memory", PEAK_MEMORY >> 30));
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

/// Next answer and its pixels; `None` at the end.
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
    pub fn render_anew(&mut self, scene: &Scene) -> Result<Frame, RenderError> {
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
            let _ = process.input.write_all(line(&Request::Forget(self.number)).as_bytes());
        }
    }
}
