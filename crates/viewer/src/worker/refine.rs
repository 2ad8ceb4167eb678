//! Refinement of a resting scene: its own picture tile by tile, then means of sub-frames.

use super::background_renderer::BackgroundRenderer;
use super::job::{Event, Job, LoadedScene, Picture};
use super::mean::{Mean, resampled};
use super::progressive::{MAX_SUB_FRAMES, MIN_SUB_FRAMES, number, reference, tiles};
use super::render_thread::{Accumulation, RenderThread};
use super::renderers::{VariantRenderers, with_other_pass};
use super::status::{Cost, Stage};
use crate::background::{cancel_if, catch_cancellation};
use hypertexture::gpu::Area;
use hypertexture::render::variant::Variant;
use hypertexture::render::{Measurements, RenderError, Renderer, describe_frame, paste_areas, unused_overrides};
use hypertexture::scene::{Scene, nearest_preset};
use hypertexture::shader::shipped;
use hypertexture_measure::statistics::rms_difference;
use std::time::{Duration, Instant};

/// Interval between updates of an unfinished picture.
const SHOW_EVERY: Duration = Duration::from_millis(150);
/// Target time of a batch of tiles, milliseconds. Lower: overhead of submissions. Higher: fewer updates. Input
/// interrupts between submissions.
const TILES_MS: f64 = 100.0;
/// Tiles in the first batch, and largest growth of a batch.
const FIRST_TILES: usize = 4;
const MORE_TILES: f64 = 2.0;
/// Rest of the scene before a new program is compiled: meanwhile some devices draw nothing, not even the window.
const COMPILE_DELAY: Duration = Duration::from_millis(400);
/// Rest of the scene before its own picture is prepared: input may follow.
const PREPARE_DELAY: Duration = Duration::from_millis(150);
/// Interval between checks for new work.
const POLL: Duration = Duration::from_millis(5);
/// Number of timed previews of a pass, after the one that compiles.
const TRIALS: usize = 3;
/// Largest fraction of the time at which the other pass draws previews. Higher: within the noise of the times.
const FASTER: f64 = 0.8;

/// A picture drawn in tiles.
pub(super) struct Drawn {
    /// Time on the device, milliseconds.
    pub(super) ms: f64,
    /// Measurements of the last tiles.
    pub(super) measurements: Option<Measurements>,
}

impl RenderThread {
    /// Refines the picture until it is good enough or the job is stale.
    pub(super) fn refine(
        &mut self,
        job: &Job,
        renderers: &mut [VariantRenderers],
        accumulation: &mut Accumulation,
    ) -> Result<(), RenderError> {
        let finished = match self.refined(job, renderers, accumulation) {
            Err(RenderError::Stopped) => return Ok(()),
            other => other?,
        };
        if !finished {
            return Ok(());
        }
        if !job.held {
            self.send_mean(job, accumulation, true);
        }
        if !std::mem::replace(&mut accumulation.reported, true) {
            self.send_ignored(job);
        }
        if let (Some([own]), true) = (accumulation.own.as_deref(), job.validity) {
            if accumulation.validity.is_none() {
                accumulation.validity = self.examine(job, own)?;
            }
            let validity = accumulation.validity.iter();
            validity.for_each(|validity| self.send_validity(job, validity, own, accumulation.gpu_ms));
        }
        renderers
            .iter_mut()
            .zip(&job.variants)
            .try_for_each(|(renderers_of, variant)| self.time_passes(job, variant, renderers_of))
    }

    /// Whether the picture has reached its error target or the limit of sub-frames.
    fn refined(
        &mut self,
        job: &Job,
        renderers: &mut [VariantRenderers],
        accumulation: &mut Accumulation,
    ) -> Result<bool, RenderError> {
        match &accumulation.own {
            None => {
                if !self.own_pictures(job, renderers, accumulation)? {
                    return Ok(false);
                }
            }
            // The mean may be on the screen.
            Some(own) if job.held => {
                let ms = accumulation.costs.iter().map(|cost| cost.ms).sum();
                self.send_picture(job, accumulation, own, Picture::of(job, Stage::Scene, ms));
            }
            Some(_) => {}
        }
        let mut shown = Instant::now();
        let shared = self.shared.clone();
        let (size, job_number) = (job.variants[0].scene.image.size, job.number);
        while !job.held && accumulation.means[0].count < MAX_SUB_FRAMES && !is_converged(accumulation, job) {
            let mut pictures = Vec::new();
            let sub_frame = number(accumulation.means[0].count);
            accumulation.gpu_ms = 0.0;
            for (variant, renderers_of) in job.variants.iter().zip(&mut *renderers) {
                let scene = reference(&variant.scene);
                let stale = || shared.is_stale(job_number);
                if !renderers_of.mean.is_ready(&scene) && !self.rests(job, COMPILE_DELAY) {
                    return Ok(false);
                }
                let Some(renderer) = renderers_of.mean.prepared(&scene, &variant.subject.groom, &stale)? else {
                    return Ok(false);
                };
                let shared = shared.clone();
                renderer.stop_where(move |_| shared.is_stale(job_number));
                let frame = renderer.render_areas(&scene, &[Area::whole(size)], Some(sub_frame))?;
                accumulation.gpu_ms += frame.measurements.device_ms();
                pictures.push(frame.pixels);
            }
            for (mean, pixels) in accumulation.means.iter_mut().zip(&pictures) {
                mean.add(pixels);
            }
            if accumulation.means[0].count == 2 * MIN_SUB_FRAMES {
                self.judge(accumulation);
            }
            let done = accumulation.means[0].count == MAX_SUB_FRAMES || is_converged(accumulation, job);
            if !done && accumulation.means[0].count >= MIN_SUB_FRAMES && shown.elapsed() >= SHOW_EVERY {
                self.send_mean(job, accumulation, false);
                shown = Instant::now();
            }
            if self.shared.is_stale(job.number) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Waits; returns whether the job is still the newest.
    fn rests(&self, job: &Job, calm: Duration) -> bool {
        let until = Instant::now() + calm;
        while !self.shared.is_stale(job.number) && Instant::now() < until {
            std::thread::sleep(POLL);
        }
        !self.shared.is_stale(job.number)
    }

    /// Reports fields without an effect, which takes a fraction of a second.
    fn send_ignored(&self, job: &Job) {
        let LoadedScene { scene, library, subject } = &job.variants[0];
        // Compiling a custom module takes a child process, which this is not worth.
        if scene.modules.is_empty() && **library == shipped() && !self.shared.is_stale(job.number) {
            (self.send)(Event::Ignored(unused_overrides(library, subject, &nearest_preset(scene), &**scene)));
        }
    }

    /// Draws the scene's own picture of each variant; returns whether they are finished.
    fn own_pictures(
        &self,
        job: &Job,
        renderers: &mut [VariantRenderers],
        accumulation: &mut Accumulation,
    ) -> Result<bool, RenderError> {
        let size = job.variants[0].scene.image.size;
        let enlarged = |pixels: &Vec<[f32; 4]>| resampled(pixels, accumulation.size, size, |at| at, [0.0; 4]);
        let mut all = accumulation.partial.take().unwrap_or_else(|| accumulation.coarse.iter().map(enlarged).collect());
        let (mut gpu_ms, mut costs, mut shown) = (0.0, Vec::new(), Instant::now());
        for (index, variant) in job.variants.iter().enumerate() {
            if !renderers[index].own.is_ready(&*variant.scene) && !self.rests(job, PREPARE_DELAY) {
                accumulation.partial = Some(all);
                return Ok(false);
            }
            let mut pixels = std::mem::take(&mut all[index]);
            let others = &all;
            let count = job.variants.len() as f32;
            let mut show = |pixels: &[[f32; 4]], part: f32| {
                if shown.elapsed() >= SHOW_EVERY {
                    shown = Instant::now();
                    let of = |other: usize| if other == index { pixels } else { others[other].as_slice() };
                    let frames: Vec<&[[f32; 4]]> = (0..others.len()).map(of).collect();
                    let done = (index as f32 + part) / count;
                    let picture = Picture { done, ..Picture::of(job, Stage::Partial, accumulation.gpu_ms) };
                    self.send_picture(job, accumulation, &frames, picture);
                }
            };
            let drawn = self.in_tiles(job, &variant.scene, &mut renderers[index].own, &mut pixels, &mut show)?;
            all[index] = pixels;
            let Some(drawn) = drawn else {
                accumulation.partial = Some(all);
                return Ok(false);
            };
            gpu_ms += drawn.ms;
            costs.push(Cost { ms: drawn.ms, rmse: None });
            if let (0, Some(measurements)) = (index, &drawn.measurements) {
                let program = Variant::of(&variant.scene, &variant.library)?;
                (self.send)(Event::Made(describe_frame(measurements, &program, &variant.subject, &variant.library)));
            }
        }
        (accumulation.gpu_ms, accumulation.costs) = (gpu_ms, costs);
        let picture = Picture { error: self.own_error, ..Picture::of(job, Stage::Scene, gpu_ms) };
        self.send_picture(job, accumulation, &all, picture);
        accumulation.own = Some(all);
        Ok(true)
    }

    /// Draws a picture tile by tile into `pixels`, from the focus outwards; `None` if the job is stale.
    pub(super) fn in_tiles(
        &self,
        job: &Job,
        scene: &Scene,
        renderer: &mut Renderer,
        pixels: &mut Vec<[f32; 4]>,
        mut show: impl FnMut(&[[f32; 4]], f32),
    ) -> Result<Option<Drawn>, RenderError> {
        let (number, [width, height]) = (job.number, scene.image.size);
        let stale = || self.shared.is_stale(number);
        // Baking noise may take seconds.
        match catch_cancellation(|| renderer.prepare(scene, &|_| cancel_if(stale()))) {
            None => return Ok(None),
            Some(done) => done?,
        }
        let shared = self.shared.clone();
        renderer.stop_where(move |_| shared.is_stale(number));
        pixels.resize(width as usize * height as usize, [0.0; 4]);
        // With multisampling, areas of one batch must not touch. Half-angle slicing propagates light anew for each
        // area.
        let (all, at_once) = match scene.quality.msaa {
            _ if scene.is_half_angle() => (vec![Area::whole(scene.image.size)], 1),
            1 => (tiles(scene.image.size, job.focus), usize::MAX),
            _ => (bands(scene.image.size), 1),
        };
        let (mut left, mut count) = (all.as_slice(), FIRST_TILES);
        let mut drawn = Drawn { ms: 0.0, measurements: None };
        while !left.is_empty() {
            let (areas, rest) = left.split_at(count.min(at_once).min(left.len()));
            let start = Instant::now();
            let frame = match renderer.render_areas(scene, areas, None) {
                Err(RenderError::Stopped) => return Ok(None),
                other => other?,
            };
            paste_areas(&frame.pixels, areas, width, pixels);
            let ms = start.elapsed().as_secs_f64() * 1e3 - frame.measurements.compile_ms;
            count = (areas.len() as f64 * (TILES_MS / ms.max(1e-3)).min(MORE_TILES)).max(1.0) as usize;
            left = rest;
            drawn.ms += frame.measurements.device_ms();
            drawn.measurements = Some(frame.measurements);
            show(pixels, 1.0 - left.len() as f32 / all.len() as f32);
        }
        Ok(Some(drawn))
    }

    /// Times previews of both passes, once for a finished picture, and stores the faster one.
    fn time_passes(
        &self,
        job: &Job,
        variant: &LoadedScene,
        renderers_of: &mut VariantRenderers,
    ) -> Result<(), RenderError> {
        let LoadedScene { scene, library, subject } = variant;
        let own = scene.quality.pass;
        let is_known = renderers_of.faster.is_some_and(|[_, of]| of == own);
        let Some(other) = with_other_pass(scene, library).filter(|_| !is_known) else { return Ok(()) };
        if !self.rests(job, COMPILE_DELAY) {
            return Ok(());
        }
        let level = self.budget.level();
        let scenes = [&**scene, &other].map(|scene| level.scene(scene, true));
        let mut times = [0.0; 2];
        for (time, scene) in times.iter_mut().zip(scenes) {
            let (shared, number) = (self.shared.clone(), job.number);
            let stale = || self.shared.is_stale(job.number);
            let work = move |renderer: &mut Renderer| {
                renderer.stop_where(move |_| shared.is_stale(number));
                renderer.render(&scene)?;
                let frames = (0..TRIALS).map(|_| renderer.render(&scene).map(|frame| frame.measurements.alone_ms()));
                frames.collect::<Result<Vec<f64>, _>>().map(|times| times.into_iter().fold(f64::INFINITY, f64::min))
            };
            let renderer = || BackgroundRenderer::new(Renderer::new(&self.gpu, library, subject));
            match renderers_of.trial.get_or_insert_with(renderer).run(&stale, work) {
                Ok(Some(ms)) if ms > 0.0 => *time = ms,
                Ok(_) | Err(RenderError::Stopped) => return Ok(()),
                // The scene's own pass stays.
                Err(error) => {
                    log::debug!("previews by the other pass: {error}");
                    (renderers_of.faster, renderers_of.trial) = (Some([own; 2]), None);
                    return Ok(());
                }
            }
        }
        renderers_of.trial = None;
        let faster = if times[1] < FASTER * times[0] { other.quality.pass } else { own };
        log::debug!("previews take {:.1} ms by {own:?} and {:.1} ms by {:?}", times[0], times[1], other.quality.pass);
        renderers_of.faster = Some([faster, own]);
        Ok(())
    }

    /// Measures the errors of the preview and of the scene's own picture against the mean.
    fn judge(&mut self, accumulation: &mut Accumulation) {
        let all = accumulation
            .means
            .iter()
            .zip(&accumulation.coarse)
            .zip(accumulation.own.iter().flatten())
            .zip(&accumulation.scenes);
        let (mut worst, mut errors) = ([0.0f64; 2], Vec::new());
        for (((mean, coarse), own), scene) in all {
            let mean = mean.pixels();
            let coarse = resampled(coarse, accumulation.size, scene.image.size, |at| at, [0.0; 4]);
            worst[0] = worst[0].max(rms_difference(&coarse, &mean));
            let rmse = rms_difference(own, &mean);
            worst[1] = worst[1].max(rmse);
            errors.push(Some(rmse));
        }
        self.coarse_error = accumulation.level.map(|level| (worst[0], level)).or(self.coarse_error);
        self.own_error = Some(worst[1]);
        accumulation.costs.iter_mut().zip(errors).for_each(|(cost, rmse)| cost.rmse = rmse);
    }

    fn send_mean(&self, job: &Job, accumulation: &Accumulation, done: bool) {
        let count = accumulation.means[0].count;
        let means: Vec<_> = accumulation.means.iter().map(Mean::pixels).collect();
        let stage = if done { Stage::Converged(count) } else { Stage::Refined(count) };
        let worst = |of: fn(&Mean) -> Option<f64>| accumulation.means.iter().filter_map(of).reduce(f64::max);
        let (error, standard_error) = (worst(Mean::error), worst(Mean::standard_error));
        let picture = Picture { error, standard_error, ..Picture::of(job, stage, accumulation.gpu_ms) };
        self.send_picture(job, accumulation, &means, picture);
    }
}

/// Bands of a picture from the top, of even height.
fn bands([width, height]: [u32; 2]) -> Vec<Area> {
    let rows = height.div_ceil(16).max(1).next_multiple_of(2);
    (0..height.div_ceil(rows))
        .map(|band| Area { columns: 0..width, rows: band * rows..((band + 1) * rows).min(height) })
        .collect()
}

/// Whether the means are within the error target, after at least two doublings.
fn is_converged(accumulation: &Accumulation, job: &Job) -> bool {
    let good =
        |mean: &Mean| mean.count >= 2 * MIN_SUB_FRAMES && mean.error().is_some_and(|error| error <= job.max_error);
    accumulation.means.iter().all(good)
}
