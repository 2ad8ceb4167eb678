//! Where pictures are made: coarse ones while the scene moves, means of many while it stands still.

use super::{Event, Job, Picture, Shared};
use crate::gpu::Gpu;
use crate::measure::statistics::rms_difference;
use crate::measure::validity::Validity;
use crate::render::{Frame, Measurements, RenderError, Renderer, Subject, ignored, made_with};
use crate::scene::{Scene, nearest_preset};
use crate::shader::compile::CompileError;
use crate::shader::{Library, shipped};
use crate::viewer::author::Gate;
use crate::viewer::progressive::{FEWEST, Level, MOST, Mean, enlarge, number, reference};
use crate::viewer::screen::encode_srgb;
use crate::viewer::status::Stage;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A band of a picture should take about this many milliseconds: after each, a newer scene is looked for. Shorter: the
/// copies of each band show. Longer: the first picture after a rest comes late.
const BAND_MS: f64 = 150.0;
/// A picture in the making is shown this often.
const SHOW_EVERY: Duration = Duration::from_millis(150);

/// Tells the window something.
type Tell = Box<dyn Fn(Event) + Send + Sync>;

/// Where pictures are made.
pub(super) struct RenderThread {
    pub(super) gpu: Gpu,
    gate: Arc<Gate>,
    pub(super) shared: Arc<Shared>,
    pub(super) tell: Tell,
    level: Level,
    budget_ms: f64,
    /// Error of the last coarse picture that a mean could be held against, and its level.
    coarse_error: Option<(f64, Level)>,
    /// Error of the scene's own picture, then.
    own_error: Option<f64>,
}

/// What is kept of a scene that stands still.
struct Accumulation {
    scenes: Vec<Scene>,
    /// The coarse pictures, their size and level.
    coarse: Vec<Frame>,
    level: Level,
    /// The scene's own pictures.
    own: Option<Vec<Vec<[f32; 4]>>>,
    means: Vec<Mean>,
    gpu_ms: f64,
    /// Whether it was said what changes nothing.
    told: bool,
    /// Which pixels of the first of the scene's own pictures are not to be trusted.
    validity: Option<Validity>,
}

impl Accumulation {
    fn of(job: &Job, coarse: Vec<Frame>, level: Level) -> Accumulation {
        let gpu_ms = coarse.iter().map(device_ms).sum();
        let means = vec![Mean::default(); coarse.len()];
        Accumulation { scenes: scenes(job), coarse, level, own: None, means, gpu_ms, told: false, validity: None }
    }
}

/// The two renderers of a variant: each keeps what it has made for one size.
pub(super) struct Pair {
    coarse: Renderer,
    fine: Renderer,
    /// Milliseconds of a row of the whole picture, about.
    row_ms: f64,
}

impl Pair {
    pub(super) fn new(gpu: &Gpu, library: &Library, subject: &Subject) -> Pair {
        let renderer = || Renderer::new(gpu, library, subject);
        Pair { coarse: renderer(), fine: renderer(), row_ms: 1.0 }
    }
}

/// A picture that was drawn in bands.
pub(super) struct Drawn {
    /// Milliseconds on the device.
    ms: f64,
    /// Those of the last band.
    measurements: Option<Measurements>,
}

fn scenes(job: &Job) -> Vec<Scene> {
    job.variants.iter().map(|variant| variant.scene.clone()).collect()
}

fn device_ms(frame: &Frame) -> f64 {
    frame.measurements.gpu_ms + frame.measurements.shadow_ms.unwrap_or(0.0)
}

impl RenderThread {
    pub(super) fn new(gpu: Gpu, gate: Arc<Gate>, shared: Arc<Shared>, budget_ms: f64, tell: Tell) -> RenderThread {
        let level = Level::first(gpu.info().cpu);
        RenderThread { gpu, gate, shared, tell, level, budget_ms, coarse_error: None, own_error: None }
    }

    pub(super) fn run(mut self) {
        let mut next = self.next_job();
        while let Some(job) = next {
            next = self.show(job);
        }
    }

    /// Does the tasks there are, and waits for a job; `None` at the end.
    fn next_job(&mut self) -> Option<Job> {
        loop {
            let mut inbox = self.shared.inbox();
            if self.shared.quits() {
                return None;
            }
            if let Some(task) = inbox.tasks.pop_front() {
                drop(inbox);
                let done = self.work(task);
                if !self.survives(done) {
                    return None;
                }
            } else if let Some(job) = inbox.job.take() {
                return Some(job);
            } else {
                drop(self.shared.wake.wait(inbox).ok()?);
            }
        }
    }

    /// Tells of an error; whether the device is still there.
    fn survives(&self, done: Result<(), RenderError>) -> bool {
        let Err(error) = done else { return true };
        let lost = matches!(&error, RenderError::Gpu(error) if error.is_lost());
        (self.tell)(if lost { Event::Lost } else { Event::Failed(error.to_string()) });
        !lost
    }

    /// Shows a job and those after it that have the same modules and objects; gives the first that has not.
    fn show(&mut self, mut job: Job) -> Option<Job> {
        let gpu = self.gpu.clone();
        let library = job.library.clone();
        let subjects: Vec<_> = job.variants.iter().map(|variant| variant.subject.clone()).collect();
        let mut pairs: Vec<Pair> = subjects.iter().map(|subject| Pair::new(&gpu, &library, subject)).collect();
        let mut still = None;
        loop {
            let done = self.picture(&job, &mut pairs, &mut still);
            if !self.survives(done) {
                return None;
            }
            let next = self.next_job()?;
            let same = Arc::ptr_eq(&next.library, &library)
                && next.variants.len() == subjects.len()
                && next.variants.iter().zip(&subjects).all(|(variant, own)| Arc::ptr_eq(&variant.subject, own));
            if !same {
                return Some(next);
            }
            job = next;
        }
    }

    fn picture(&mut self, job: &Job, pairs: &mut [Pair], still: &mut Option<Accumulation>) -> Result<(), RenderError> {
        if still.as_ref().is_none_or(|still| still.scenes != scenes(job)) {
            *still = None;
            if !job.variants.iter().all(|variant| self.admits(&variant.scene, &job.library)) {
                return Ok(());
            }
            *still = Some(self.coarse(job, pairs)?);
        }
        match still {
            Some(still) if !job.moving => self.refine(job, pairs, still),
            _ => Ok(()),
        }
    }

    /// Whether the device may meet the programs of a scene; tells why not.
    pub(super) fn admits(&self, scene: &Scene, library: &Library) -> bool {
        match self.gate.validate(scene, library, &|| self.shared.quits()) {
            Ok(()) => true,
            Err(CompileError::Abandoned) => false,
            Err(error) => {
                let reason = error.to_string();
                (self.tell)(Event::Refused(reason.lines().next().unwrap_or_default().into()));
                false
            }
        }
    }

    /// A picture in time for the next one.
    fn coarse(&mut self, job: &Job, pairs: &mut [Pair]) -> Result<Accumulation, RenderError> {
        let level = self.level;
        let mut frames = Vec::new();
        for (variant, pair) in job.variants.iter().zip(pairs) {
            let frame = pair.coarse.render(&level.scene(&variant.scene))?;
            let rows = f64::from(variant.scene.image.size[1]);
            pair.row_ms = level.whole(device_ms(&frame)) / rows;
            frames.push(frame);
        }
        let still = Accumulation::of(job, frames, level);
        self.level = level.next(still.gpu_ms, self.budget_ms);
        let frames: Vec<&[[f32; 4]]> = still.coarse.iter().map(|frame| frame.pixels.as_slice()).collect();
        let error = self.coarse_error.filter(|(_, of)| *of == level).map(|(error, _)| error);
        let (size, samples) = (still.coarse[0].size, still.coarse[0].measurements.slices);
        let picture = Picture { size, samples, error, ..Picture::of(job, Stage::Coarse, still.gpu_ms) };
        self.tell_picture(job, &frames, picture);
        Ok(still)
    }

    /// The scene's own picture, then means of more and more, until they are good enough or something else is to be done.
    fn refine(&mut self, job: &Job, pairs: &mut [Pair], still: &mut Accumulation) -> Result<(), RenderError> {
        if still.own.is_none() && !self.own_pictures(job, pairs, still)? {
            return Ok(());
        }
        let mut shown = Instant::now();
        while still.means[0].count < MOST && !is_converged(still, job) {
            let mut pictures = Vec::new();
            let start = number(still.means[0].count);
            still.gpu_ms = 0.0;
            for (variant, pair) in job.variants.iter().zip(&mut *pairs) {
                let mut pixels = Vec::new();
                let made = self.in_bands(job, &reference(&variant.scene), pair, Some(start), &mut pixels, |_| ())?;
                let Some(drawn) = made else { return Ok(()) };
                still.gpu_ms += drawn.ms;
                pictures.push(pixels);
            }
            for (mean, pixels) in still.means.iter_mut().zip(&pictures) {
                mean.add(pixels);
            }
            if still.means[0].count == 2 * FEWEST {
                self.judge(still);
            }
            let done = still.means[0].count == MOST || is_converged(still, job);
            if done || still.means[0].count >= FEWEST && shown.elapsed() >= SHOW_EVERY {
                self.tell_mean(job, still, done);
                shown = Instant::now();
            }
        }
        if still.means[0].count > 0 && (is_converged(still, job) || still.means[0].count == MOST) {
            self.tell_mean(job, still, true);
            if !std::mem::replace(&mut still.told, true) {
                self.tell_ignored(job);
            }
            if let ([pair], Some([own]), true) = (pairs, still.own.as_deref(), job.validity) {
                if still.validity.is_none() {
                    still.validity = self.examine(job, own, pair)?;
                }
                still.validity.iter().for_each(|validity| self.tell_validity(job, validity, own, still.gpu_ms));
            }
        }
        Ok(())
    }

    /// Says what changes nothing in a picture that is finished: it takes a part of a second.
    fn tell_ignored(&self, job: &Job) {
        let (scene, subject) = (&job.variants[0].scene, &job.variants[0].subject);
        // A custom module is compiled in a process of its own, and never for this.
        if scene.modules.is_empty() && *job.library == shipped() && !self.shared.is_stale(job.number) {
            (self.tell)(Event::Ignored(ignored(&job.library, subject, &nearest_preset(scene), scene)));
        }
    }

    /// The scene's own picture of each variant; whether they were finished.
    fn own_pictures(&self, job: &Job, pairs: &mut [Pair], still: &mut Accumulation) -> Result<bool, RenderError> {
        let size = job.variants[0].scene.image.size;
        let mut all: Vec<Vec<[f32; 4]>> =
            still.coarse.iter().map(|frame| enlarge(&frame.pixels, frame.size, size)).collect();
        let mut gpu_ms = 0.0;
        let mut shown = Instant::now();
        for (index, variant) in job.variants.iter().enumerate() {
            let mut pixels = std::mem::take(&mut all[index]);
            let others = &all;
            let mut show = |pixels: &[[f32; 4]]| {
                if shown.elapsed() >= SHOW_EVERY {
                    shown = Instant::now();
                    let of = |other: usize| if other == index { pixels } else { others[other].as_slice() };
                    let frames: Vec<&[[f32; 4]]> = (0..others.len()).map(of).collect();
                    self.tell_picture(job, &frames, Picture::of(job, Stage::Partial, still.gpu_ms));
                }
            };
            let made = self.in_bands(job, &variant.scene, &mut pairs[index], None, &mut pixels, &mut show)?;
            let Some(drawn) = made else { return Ok(false) };
            gpu_ms += drawn.ms;
            if let (0, Some(measurements)) = (index, &drawn.measurements) {
                (self.tell)(Event::Made(made_with(measurements, &variant.scene, &variant.subject, &job.library)?));
            }
            all[index] = pixels;
        }
        still.gpu_ms = gpu_ms;
        let frames: Vec<&[[f32; 4]]> = all.iter().map(Vec::as_slice).collect();
        let picture = Picture { error: self.own_error, ..Picture::of(job, Stage::Scene, gpu_ms) };
        self.tell_picture(job, &frames, picture);
        still.own = Some(all);
        Ok(true)
    }

    /// A whole picture, or one of its sub-frames, band by band into `pixels`; `None` where something else is to be done.
    pub(super) fn in_bands(
        &self,
        job: &Job,
        scene: &Scene,
        pair: &mut Pair,
        number: Option<u32>,
        pixels: &mut Vec<[f32; 4]>,
        mut show: impl FnMut(&[[f32; 4]]),
    ) -> Result<Option<Drawn>, RenderError> {
        let [width, height] = scene.image.size;
        pixels.resize(width as usize * height as usize, [0.0; 4]);
        let (mut row, mut drawn) = (0, Drawn { ms: 0.0, measurements: None });
        while row < height {
            if self.shared.is_stale(job.number) {
                return Ok(None);
            }
            let rows = (BAND_MS / pair.row_ms.max(1e-6)) as u32;
            let band = row..row.saturating_add(rows.max(height / 16).max(1)).min(height);
            let bands = std::slice::from_ref(&band);
            let frame = match number {
                Some(number) => pair.fine.render_part(scene, bands, &[number])?,
                None => pair.fine.render_bands(scene, bands)?,
            };
            let own = (band.start * width) as usize..(band.end * width) as usize;
            pixels[own.clone()].copy_from_slice(&frame.pixels[own]);
            drawn.ms += device_ms(&frame);
            pair.row_ms = device_ms(&frame) / f64::from(band.end - band.start);
            row = band.end;
            show(pixels);
            drawn.measurements = Some(frame.measurements);
        }
        Ok(Some(drawn))
    }

    /// Holds the coarse picture and the scene's own against the mean.
    fn judge(&mut self, still: &mut Accumulation) {
        let all = still.means.iter().zip(&still.coarse).zip(still.own.iter().flatten()).zip(&still.scenes);
        let mut worst = [0.0f64; 2];
        for (((mean, coarse), own), scene) in all {
            let mean = mean.pixels();
            let coarse = enlarge(&coarse.pixels, coarse.size, scene.image.size);
            worst[0] = worst[0].max(rms_difference(&coarse, &mean));
            worst[1] = worst[1].max(rms_difference(own, &mean));
        }
        self.coarse_error = Some((worst[0], still.level));
        self.own_error = Some(worst[1]);
    }

    fn tell_mean(&self, job: &Job, still: &Accumulation, done: bool) {
        let count = still.means[0].count;
        let means: Vec<_> = still.means.iter().map(Mean::pixels).collect();
        let frames: Vec<&[[f32; 4]]> = means.iter().map(Vec::as_slice).collect();
        let stage = if done { Stage::Converged(count) } else { Stage::Refined(count) };
        let worst = |of: fn(&Mean) -> Option<f64>| still.means.iter().filter_map(of).reduce(f64::max);
        let (error, standard_error) = (worst(Mean::error), worst(Mean::standard_error));
        self.tell_picture(job, &frames, Picture { error, standard_error, ..Picture::of(job, stage, still.gpu_ms) });
    }

    fn tell_picture(&self, job: &Job, frames: &[&[[f32; 4]]], mut picture: Picture) {
        let backgrounds: Vec<_> = job.variants.iter().map(|variant| variant.scene.image.background).collect();
        picture.images = encode_srgb(frames, &backgrounds, picture.size, job.variants[0].scene.image.size);
        picture.difference = match frames {
            // Rows of one may be finer than those of the other.
            [a, b] if picture.stage != Stage::Partial => Some(rms_difference(a, b)),
            _ => None,
        };
        picture.frames = frames.iter().map(|pixels| Arc::from(*pixels)).collect();
        (self.tell)(Event::Picture(picture));
    }
}

impl Picture {
    /// As large as the scene asks, with its samples; no images yet, and nothing known of its error.
    pub(super) fn of(job: &Job, stage: Stage, gpu_ms: f64) -> Picture {
        let scene = &job.variants[0].scene;
        let (size, samples) = (scene.image.size, scene.quality.samples);
        Picture { number: job.number, size, samples, stage, gpu_ms, ..Picture::default() }
    }
}

/// Whether the means are good enough. Two doublings are the least that says something.
fn is_converged(still: &Accumulation, job: &Job) -> bool {
    let good = |mean: &Mean| mean.count >= 2 * FEWEST && mean.error().is_some_and(|error| error <= job.max_error);
    still.means.iter().all(good)
}
