//! The loop of the render thread.

use super::job::{Event, Job, LoadedScene, Picture};
use super::mean::{Mean, resampled};
use super::progressive::{Budget, Level, MIN_SUB_FRAMES};
use super::renderers::{VariantRenderers, pose_of};
use super::shared::Shared;
use super::status::{Cost, Stage};
use super::stroke_budget::StrokeBudget;
use crate::document::author::Gate;
use crate::screen::{Encoded, behind, encode_srgb};
use hypertexture::gpu::{Encoder, Gpu, Image};
use hypertexture::render::{RenderError, ViewPose};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use hypertexture::shader::compile::CompileError;
use hypertexture_measure::statistics::rms_difference;
use std::borrow::Borrow;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Sends an event to the window.
type SendEvent = Box<dyn Fn(Event) + Send + Sync>;

/// The render thread.
pub(super) struct RenderThread {
    pub(super) gpu: Gpu,
    /// Encoder of previews, once used.
    encoder: Option<Encoder>,
    gate: Arc<Gate>,
    pub(super) shared: Arc<Shared>,
    pub(super) send: SendEvent,
    pub(super) budget: Budget,
    pub(super) strokes: StrokeBudget,
    /// Measured error of the last preview, and its level.
    pub(super) coarse_error: Option<(f64, Level)>,
    /// Measured error of the scene's own picture.
    pub(super) own_error: Option<f64>,
}

/// Accumulated pictures of a resting scene.
#[derive(Default)]
pub(super) struct Accumulation {
    pub(super) scenes: Vec<Arc<Scene>>,
    pub(super) poses: Vec<ViewPose>,
    /// The first pictures and the level of the preview; `None` after a resize.
    pub(super) coarse: Vec<Vec<[f32; 4]>>,
    pub(super) size: [u32; 2],
    pub(super) level: Option<Level>,
    /// Unfinished own pictures of the scene.
    pub(super) partial: Option<Vec<Vec<[f32; 4]>>>,
    /// Finished own pictures of the scene.
    pub(super) own: Option<Vec<Vec<[f32; 4]>>>,
    pub(super) means: Vec<Mean>,
    pub(super) gpu_ms: f64,
    /// Costs of the own pictures.
    pub(super) costs: Vec<Cost>,
    /// Whether fields without an effect were reported.
    pub(super) reported: bool,
    /// Validity of the first own picture.
    pub(super) validity: Option<hypertexture_measure::validity::Validity>,
}

impl Accumulation {
    pub(super) fn of(job: &Job, poses: Vec<ViewPose>, coarse: Vec<Vec<[f32; 4]>>, size: [u32; 2]) -> Accumulation {
        let means = vec![Mean::default(); coarse.len()];
        Accumulation { scenes: scenes(job), poses, coarse, size, means, ..Accumulation::default() }
    }

    /// Whether a job differs in the size only.
    fn is_resized_by(&self, job: &Job) -> bool {
        let same = |(own, variant): (&Arc<Scene>, &LoadedScene)| {
            let mut resized = Scene::clone(own);
            resized.image.size = variant.scene.image.size;
            resized == *variant.scene
        };
        self.scenes.len() == job.variants.len() && self.scenes.iter().zip(&job.variants).all(same)
    }

    /// The best pictures and their size.
    pub(super) fn best(&self) -> (Vec<Vec<[f32; 4]>>, [u32; 2]) {
        let size = self.scenes[0].image.size;
        match (&self.own, &self.partial) {
            (Some(_), _) if self.means[0].count >= MIN_SUB_FRAMES => {
                (self.means.iter().map(Mean::pixels).collect(), size)
            }
            (Some(pictures), _) | (None, Some(pictures)) => (pictures.clone(), size),
            (None, None) => (self.coarse.clone(), self.size),
        }
    }
}

fn scenes(job: &Job) -> Vec<Arc<Scene>> {
    job.variants.iter().map(|variant| variant.scene.clone()).collect()
}

impl RenderThread {
    pub(super) fn new(gpu: Gpu, gate: Arc<Gate>, shared: Arc<Shared>, budget_ms: f64, send: SendEvent) -> RenderThread {
        let budget = Budget::new(budget_ms, gpu.info().cpu);
        let strokes = StrokeBudget::new(budget_ms);
        RenderThread { gpu, encoder: None, gate, shared, send, budget, strokes, coarse_error: None, own_error: None }
    }

    pub(super) fn run(mut self) {
        let mut next = self.next_job();
        while let Some(job) = next {
            next = self.show(job);
        }
    }

    /// Searches on request, and waits for a job; `None` at the end.
    fn next_job(&mut self) -> Option<Job> {
        loop {
            let mut inbox = self.shared.inbox();
            if self.shared.quits() {
                return None;
            }
            if let Some((variant, bound)) = inbox.search.take() {
                drop(inbox);
                let done = self.pick(&variant, bound);
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

    /// Reports an error; returns whether the device is still there.
    fn survives(&self, done: Result<(), RenderError>) -> bool {
        let Err(error) = done else { return true };
        let lost = matches!(&error, RenderError::Gpu(error) if error.is_lost());
        (self.send)(if lost { Event::Lost } else { Event::Failed(error.to_string()) });
        !lost
    }

    /// Shows a job and later ones with the same modules and objects; returns the first other one.
    fn show(&mut self, mut job: Job) -> Option<Job> {
        let gpu = self.gpu.clone();
        let own = job.variants.clone();
        let mut renderers: Vec<VariantRenderers> =
            job.variants.iter().map(|variant| VariantRenderers::new(&gpu, variant)).collect();
        let mut accumulation = None;
        loop {
            let done = self.picture(&job, &mut renderers, &mut accumulation);
            if !self.survives(done) {
                return None;
            }
            let next = self.next_job()?;
            let same = next.variants.len() == own.len()
                && next.variants.iter().zip(&own).all(|(variant, own)| variant.has_same_program(own));
            if !same {
                return Some(next);
            }
            job = next;
        }
    }

    fn picture(
        &mut self,
        job: &Job,
        renderers: &mut [VariantRenderers],
        accumulation: &mut Option<Accumulation>,
    ) -> Result<(), RenderError> {
        for (variant, renderers_of) in job.variants.iter().zip(&mut *renderers) {
            renderers_of.own.paint(&variant.subject.groom, job.moving)?;
        }
        if accumulation.as_ref().is_none_or(|accumulation| accumulation.scenes != scenes(job)) {
            let before = accumulation.take();
            if !job.variants.iter().all(|variant| self.admits(&variant.scene, &variant.library)) {
                return Ok(());
            }
            *accumulation = match before {
                Some(before) if before.is_resized_by(job) => Some(self.resized(job, &before)?),
                Some(before) => match self.repainted(job, renderers, &before)? {
                    None => self.preview(job, renderers)?,
                    repainted => repainted,
                },
                None => self.preview(job, renderers)?,
            };
        }
        match accumulation {
            Some(accumulation) if !job.moving => self.refine(job, renderers, accumulation),
            _ => Ok(()),
        }
    }

    /// Whether the programs of a scene may run; reports a refusal.
    pub(super) fn admits(&self, scene: &Scene, library: &Library) -> bool {
        match self.gate.validate(scene, library, &|| self.shared.quits()) {
            Ok(()) => true,
            Err(CompileError::Abandoned) => false,
            Err(error) => {
                let reason = error.to_string();
                (self.send)(Event::Refused(reason.lines().next().unwrap_or_default().into()));
                false
            }
        }
    }

    /// Draws a preview within the budget; `None` if the thread ends.
    fn preview(&mut self, job: &Job, renderers: &mut [VariantRenderers]) -> Result<Option<Accumulation>, RenderError> {
        let poses: Result<Vec<ViewPose>, _> = job.variants.iter().map(pose_of).collect();
        let poses = poses?;
        let first = &job.variants[0].scene;
        self.shared.wait_until_shown();
        'level: loop {
            let (start, level) = (Instant::now(), self.budget.level());
            let (mut frames, mut device, mut compile_ms) = (Vec::new(), 0.0, 0.0);
            for (variant, renderers_of) in job.variants.iter().zip(&mut *renderers) {
                let (ends, shared) = (self.budget.ends(), self.shared.clone());
                renderers_of.own.stop_where(move |ms| shared.quits() || ends(device + ms));
                let scene = renderers_of.preview(&variant.scene, level);
                match renderers_of.own.render(&scene) {
                    Ok(frame) => {
                        device += frame.measurements.device_ms();
                        compile_ms += frame.measurements.compile_ms;
                        frames.push(frame);
                    }
                    Err(RenderError::Stopped) if self.shared.quits() => return Ok(None),
                    Err(RenderError::Stopped) => {
                        self.budget.gave_up(first);
                        continue 'level;
                    }
                    Err(error) => return Err(error),
                }
            }
            let images = self.encoded(job, renderers)?;
            let (size, samples) = (frames[0].size, frames[0].measurements.slices);
            let coarse: Vec<Vec<[f32; 4]>> = frames.into_iter().map(|frame| frame.pixels).collect();
            let mut accumulation = Accumulation::of(job, poses, coarse, size);
            (accumulation.level, accumulation.gpu_ms) = (Some(level), device);
            self.shared.reported.store(job.number, Ordering::Relaxed);
            let error = self.coarse_error.filter(|(_, of)| *of == level).map(|(error, _)| error);
            let picture = Picture { images, size, samples, error, ..Picture::of(job, Stage::Coarse, device) };
            self.send_picture(job, &accumulation, &accumulation.coarse, picture);
            let ms = start.elapsed().as_secs_f64() * 1e3 - compile_ms;
            log::debug!("preview {:?}: {device:.1} ms on the device of {ms:.1} ms", size);
            self.budget.took(first, device, ms - device);
            return Ok(Some(accumulation));
        }
    }

    /// The latest pictures of the renderers, encoded on the device.
    fn encoded(&mut self, job: &Job, renderers: &[VariantRenderers]) -> Result<Encoded, RenderError> {
        let encoder = match &self.encoder {
            Some(encoder) => encoder,
            None => self.encoder.insert(Encoder::new(&self.gpu)?),
        };
        let backgrounds: Vec<_> = job.variants.iter().map(|variant| variant.scene.image.background).collect();
        let latest = renderers.iter().filter_map(|own| own.own.latest()).zip(&backgrounds);
        let encode = |(picture, background): (&Arc<Image>, &_)| encoder.encode(picture, behind(*background));
        let images: Vec<Arc<Image>> = latest.map(encode).collect::<Result<_, _>>()?;
        Ok(if images.len() == renderers.len() { Encoded::Device(images, backgrounds) } else { Encoded::default() })
    }

    /// Resamples the pictures of the previous window size.
    fn resized(&mut self, job: &Job, before: &Accumulation) -> Result<Accumulation, RenderError> {
        let poses: Result<Vec<ViewPose>, _> = job.variants.iter().map(pose_of).collect();
        let (poses, size) = (poses?, job.variants[0].scene.image.size);
        let (pictures, from) = before.best();
        let all = pictures.iter().zip(before.poses.iter().zip(&poses)).map(|(pixels, (old, new))| {
            let place =
                |at: [f32; 2]| new.reproject(old, at.map(|part| 2.0 * part - 1.0)).map(|place| 0.5 + 0.5 * place);
            resampled(pixels, from, size, place, [0.0; 4])
        });
        let accumulation = Accumulation::of(job, poses.clone(), all.collect(), size);
        self.send_picture(job, &accumulation, &accumulation.coarse, Picture::of(job, Stage::Partial, 0.0));
        Ok(accumulation)
    }

    pub(super) fn send_picture(
        &self,
        job: &Job,
        accumulation: &Accumulation,
        frames: &[impl Borrow<[[f32; 4]]>],
        mut picture: Picture,
    ) {
        let frames: Vec<&[[f32; 4]]> = frames.iter().map(Borrow::borrow).collect();
        if picture.images.of_device().is_empty() {
            let backgrounds: Vec<_> = job.variants.iter().map(|variant| variant.scene.image.background).collect();
            picture.images = Encoded::Host(encode_srgb(&frames, &backgrounds, picture.size));
        }
        picture.difference = match frames[..] {
            // Partial pictures may be sampled unequally.
            [a, b] if picture.stage != Stage::Partial => Some(rms_difference(a, b)),
            _ => None,
        };
        picture.frames = frames.iter().map(|pixels| Arc::from(*pixels)).collect();
        picture.costs.clone_from(&accumulation.costs);
        picture.pose = accumulation.poses.first().copied();
        (self.send)(Event::Picture(Box::new(picture)));
    }
}

impl Picture {
    /// A picture in the size and with the samples of the scene, without images.
    pub(super) fn of(job: &Job, stage: Stage, gpu_ms: f64) -> Picture {
        let scene = &job.variants[0].scene;
        let (size, samples) = (scene.image.size, scene.quality.samples);
        Picture { number: job.number, size, samples, stage, gpu_ms, ..Picture::default() }
    }
}
