//! Empty cells for recorded pictures, proven on a thread.
//!
//! Invariant: a picture uses cells that are proven for it or none, and has equal pixels either way. While time moves,
//! proofs cover an interval around the present: a proof for one moment would be out of date on arrival.

use super::grid::{distances, image, side};
use super::prover::{CellGrid, CellProver, Reads, STACK};
use crate::gpu::{Gpu, Image, Uploads};
use crate::render::camera::FrameContext;
use crate::render::error::RenderError;
use crate::render::inputs::{ImageInfo, Values};
use crate::shader::Library;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

/// Seconds before and after the current time that proofs cover while time moves. Higher: fewer empty cells where matter
/// has a long period. Lower: more pictures without cells.
const PROVEN_SECONDS: f32 = 60.0;
/// Lowest number of pictures that share a proof.
const MIN_SHARING: u32 = 64;
/// Largest ratio of a camera's distance to that of the camera that cells are proven for.
const MAX_DISTANCE_RATIO: f64 = 4.0;

/// Proof thread and the latest proven cells.
pub(crate) struct BackgroundCells {
    library: Library,
    thread_state: ProverThread,
    proven: Option<Proven>,
    /// Time of the previous picture.
    last: Option<f32>,
    /// The thread stops after this is dropped.
    here: Arc<()>,
}

enum ProverThread {
    Idle(CellProver),
    Running(JoinHandle<Result<(CellProver, Option<Proven>), RenderError>>),
}

/// Proven cells with the conditions of their proof.
struct Proven {
    reads: Arc<Reads>,
    timeless: Vec<u8>,
    /// First and last time of validity.
    times: [f32; 2],
    /// Whether a proof for a single moment would find no more empty cells.
    is_best: bool,
    boxes: CellGrid,
    /// Distances to the next cell that may hold matter; empty if all cells may.
    texels: Vec<u8>,
    image: Option<Arc<Image>>,
}

/// Input of the proof thread.
struct Job {
    library: Library,
    frame: FrameContext,
    values: Values,
    times: [f32; 2],
    /// Images of the picture's program, by binding name.
    images: BTreeMap<String, ImageInfo>,
    is_cpu: bool,
}

impl BackgroundCells {
    pub(crate) fn new(library: &Library) -> BackgroundCells {
        let thread_state = ProverThread::Idle(CellProver::Idle(0));
        BackgroundCells { library: library.clone(), thread_state, proven: None, last: None, here: Arc::new(()) }
    }

    /// The cell grid of a picture as an image; `None` if no cell is known to be empty. `images` describes those of its
    /// program.
    pub(crate) fn image(
        &mut self,
        gpu: &Gpu,
        frame: &FrameContext,
        values: &Values,
        images: impl FnOnce() -> BTreeMap<String, ImageInfo>,
        uploads: &Uploads,
    ) -> Result<Option<Arc<Image>>, RenderError> {
        self.take();
        let time = values.time;
        let rests = self.last.replace(time) == Some(time);
        let holds = |proven: &Proven| proven.holds(frame, values, time);
        let held = self.proven.as_ref().map(holds).transpose()?.unwrap_or(false);
        if !held || rests && self.proven.as_ref().is_some_and(|proven| !proven.is_best) {
            let times = if rests { [time; 2] } else { [time - PROVEN_SECONDS, time + PROVEN_SECONDS] };
            self.start(gpu, frame, values, times, images);
        }
        let Some(proven) = self.proven.as_mut().filter(|_| held) else { return Ok(None) };
        if proven.image.is_none() && !proven.texels.is_empty() {
            proven.image = Some(image(gpu, uploads, proven.boxes.side, &proven.texels)?);
        }
        Ok(proven.image.clone())
    }

    /// Whether the thread has finished the next cells, and the empty share of the current ones.
    #[cfg(test)]
    pub(crate) fn found(&self) -> (bool, f32) {
        let texels = self.proven.iter().flat_map(|proven| &proven.texels);
        let (empty, all) = texels.fold((0, 0), |(empty, all), away| (empty + u32::from(*away > 0), all + 1));
        let is_done = matches!(&self.thread_state, ProverThread::Running(thread) if thread.is_finished());
        (is_done, empty as f32 / all.max(1) as f32)
    }

    /// Takes the result of a finished thread.
    fn take(&mut self) {
        let is_done = matches!(&self.thread_state, ProverThread::Running(thread) if thread.is_finished());
        if !is_done {
            return;
        }
        let unmade = ProverThread::Idle(CellProver::Idle(0));
        let ProverThread::Running(thread) = std::mem::replace(&mut self.thread_state, unmade) else { return };
        match thread.join() {
            Ok(Ok((prover, proven))) => {
                self.thread_state = ProverThread::Idle(prover);
                self.proven = proven.or(self.proven.take());
            }
            Ok(Err(error)) => self.thread_state = ProverThread::Idle(CellProver::Unavailable(error.to_string())),
            Err(reason) => std::panic::resume_unwind(reason),
        }
    }

    /// Starts a proof for an interval of time, if it pays and the thread is idle.
    fn start(
        &mut self,
        gpu: &Gpu,
        frame: &FrameContext,
        values: &Values,
        times: [f32; 2],
        images: impl FnOnce() -> BTreeMap<String, ImageInfo>,
    ) {
        let texels = match &self.thread_state {
            ProverThread::Idle(CellProver::Idle(texels)) => *texels,
            ProverThread::Idle(CellProver::Ready(bounded)) => bounded.texels,
            _ => return,
        };
        let is_cpu = gpu.info().cpu;
        if side(is_cpu, frame, texels, false, MIN_SHARING) == 0 {
            return;
        }
        let unmade = ProverThread::Idle(CellProver::Idle(texels));
        let ProverThread::Idle(prover) = std::mem::replace(&mut self.thread_state, unmade) else { return };
        let job = Job {
            library: self.library.clone(),
            frame: frame.clone(),
            values: values.clone(),
            times,
            images: images(),
            is_cpu,
        };
        let here = Arc::downgrade(&self.here);
        let prove = move || job.prove(prover, &|| here.strong_count() == 0);
        self.thread_state = match thread::Builder::new().stack_size(STACK).spawn(prove) {
            Ok(thread) => ProverThread::Running(thread),
            Err(error) => ProverThread::Idle(CellProver::Unavailable(format!("cannot start a thread: {error}"))),
        };
    }
}

impl Proven {
    /// Whether the cells are valid for a picture at a time.
    fn holds(&self, frame: &FrameContext, values: &Values, time: f32) -> Result<bool, RenderError> {
        let is_then = self.times[0] <= time && time <= self.times[1];
        let is_there = self.boxes.hold_for(&CellGrid::of(frame, self.boxes.side));
        Ok(is_then && is_there && self.reads.timeless(values)? == self.timeless)
    }
}

impl Job {
    /// Loads the prover if necessary. Proves cells if the estimated saving exceeds the cost, until `stop` returns true.
    fn prove(
        self,
        mut prover: CellProver,
        stop: &dyn Fn() -> bool,
    ) -> Result<(CellProver, Option<Proven>), RenderError> {
        let frame = &self.frame;
        let side_of = |texels| side(self.is_cpu, frame, texels, false, MIN_SHARING);
        if let CellProver::Idle(_) = prover {
            let image_of = |name: &str| self.images.get(name).cloned();
            prover = CellProver::new(&self.library, frame, &image_of, |texels| side_of(texels) > 0)?;
        }
        prover.wait(stop)?;
        let CellProver::Ready(bounded) = &mut prover else { return Ok((prover, None)) };
        let boxes = CellGrid::of(frame, side_of(bounded.texels)).wider(MAX_DISTANCE_RATIO);
        if boxes.side == 0 {
            return Ok((prover, None));
        }
        let read = bounded.fill(&self.values, [self.times[0]; 2])?;
        bounded.fill(&self.values, self.times)?;
        let is_timeless = self.times[0] < self.times[1] && bounded.inputs.until.is_empty();
        let is_best = is_timeless || self.times[0] == self.times[1];
        let times = if is_timeless { [f32::MIN, f32::MAX] } else { self.times };
        let (empty, _) = bounded.proven(&boxes, &read, stop)?.ok_or(RenderError::Stopped)?;
        let texels = if empty.contains(&true) { distances(&empty, boxes.side as usize) } else { Vec::new() };
        let (reads, timeless) = (bounded.reads.clone(), bounded.reads.timeless(&self.values)?);
        let proven = Proven { reads, timeless, times, is_best, boxes, texels, image: None };
        Ok((prover, Some(proven)))
    }
}
