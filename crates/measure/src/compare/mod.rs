//! Comparison: the measured cost of accuracy.
//!
//! Role: a scene into candidates ([`candidates`]), each rendered, held against its reference ([`metrics`]) and timed
//! ([`timing`]); from these the Pareto front of time and error ([`front`]), one for each truth (`truths`), and a report
//! ([`report`]). Invariants: a failure is reported and fails the report; every time has its spread and every picture
//! its error; the same scene gives the same errors, digit by digit.
//!
//! A candidate is measured against the truth of its own scene: a block of noise repeats the lattice noise that it was
//! made of, so its truth is that noise, summed exactly, and what the block lost is part of its error. Another strategy
//! has another noise, and a truth of its own.

mod answers;
pub mod candidates;
mod comparison;
mod digits;
mod forecast;
pub mod front;
mod ground_truths;
pub mod metrics;
mod normals;
pub mod paper;
mod refine;
pub mod report;
mod ssim;
mod strategies;
mod theory;
pub mod timing;

pub use comparison::{Comparison, Failure, Group, Row};
pub use forecast::Forecast;
pub use ground_truths::GroundTruth;

use crate::metric::{Errors, NotFinite};
use crate::reference::Reference;
use crate::worker::{Painter, Worker};
use candidates::{Candidate, Sweep};
use ground_truths::GroundTruths;
use hypertexture::gpu::Gpu;
use hypertexture::render::{Frame, RenderError, Subject};
use hypertexture::scene::{Color, Scene, SceneError};
use hypertexture::shader::{Library, LibraryError};
use hypertexture_support::random::SplitMix;
use metrics::Metrics;
use normals::Normals;
use std::sync::Arc;
use std::time::Instant;
use timing::{FEWEST_RUNS, Run, interleave};

/// Background of the report's pictures for a scene without one: that of the gallery.
pub const BACKGROUND: Color = Color([24, 26, 31]);
/// Order of the candidates and of their runs.
const SEED: u64 = 2005;
/// Bytes of images on the device that are timed together. More: the device runs out of memory. Less: runs that are
/// compared lie farther apart in time.
const BATCH_BYTES: u64 = 768 << 20;
/// Candidates that are timed together, at most.
const BATCH: usize = 48;
/// Time that the repetitions of one candidate may take, milliseconds; quick, and in full. A candidate that needs more
/// has fewer runs, but not fewer than six.
const REPEAT_MS: [f64; 2] = [250.0, 2000.0];
/// Time that the warm-ups of one candidate may take, milliseconds; at least one is made.
const WARM_MS: [f64; 2] = [50.0, 300.0];
/// Largest number of warm-ups.
const WARM_UPS: usize = 5;

/// Settings of a comparison.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The candidates.
    pub sweep: Sweep,
    /// Timed runs of each candidate, at most.
    pub repeat: usize,
}

/// The reason why a comparison failed.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// A module is missing, or its header cannot be read.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// The scene is not valid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Every candidate is refused.
    #[error(
        "no candidate is left: the scene refuses all samples and strategies asked for; give others by --sweep or --strategies"
    )]
    Nothing,
    /// A picture of the report cannot be made.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A file of the report cannot be written.
    #[error(transparent)]
    Output(#[from] hypertexture::output::OutputError),
}

/// Computes the reference of a scene.
pub type ComputeReference<'a> = dyn FnMut(&Scene) -> Result<Arc<Reference>, String> + 'a;

/// Device, library, object and worker of a comparison.
#[derive(Clone, Copy)]
pub struct Session<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// The modules.
    pub library: &'a Library,
    /// The object of the scene.
    pub subject: &'a Subject,
    /// Worker process that draws candidates, so that a driver crash loses one candidate; `None` draws in this process.
    pub worker: Option<&'a Worker>,
    /// Whether the comparison is to stop.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Session<'a> {
    /// A renderer of candidates.
    pub fn painter(&self) -> Painter<'a> {
        Painter::new(self.gpu, self.library, self.subject, self.worker)
    }
}

/// Draws, measures and times every candidate for a scene, those of the scene's own truth first; `compute_reference`
/// gives the truth of a scene. A quick sweep without samples of its own goes on with more of them along the front.
/// `tell` gets the front of the scene's own truth, line by line, once its candidates are timed. Stopped, it keeps the
/// candidates that were timed.
///
/// # Errors
/// The scene has no candidate. An error of one of several candidates is a [`Failure`].
pub fn compare(
    session: Session<'_>,
    scene: &Scene,
    settings: &Settings,
    compute_reference: &mut ComputeReference<'_>,
    tell: &dyn Fn(&str),
    progress: &dyn Fn(f32),
) -> Result<Comparison, CompareError> {
    let mut waiting: Vec<(usize, Candidate)> =
        candidates::candidates(scene, session.library, &settings.sweep)?.into_iter().enumerate().collect();
    let mut random = SplitMix(SEED);
    random.shuffle(&mut waiting); // so that a batch mixes all candidates of its truth
    let mut normals = Normals::new(session, scene);
    let mut rows: Vec<(usize, Row)> = Vec::new();
    let mut comparison = Comparison {
        scene: scene.clone(),
        rows: Vec::new(),
        failures: Vec::new(),
        planned: waiting.len(),
        partial: false,
    };
    let mut truths = GroundTruths::new(scene, session.library)?;
    // Candidates are taken from the end.
    waiting.sort_by_cached_key(|(_, candidate)| truths.is_own(session.library, &candidate.scene));
    let goes_on = settings.sweep.quick && settings.sweep.samples.is_none();
    let mut swept: Option<Instant> = None;
    let mut is_told = false;
    while !(session.stop)() {
        if waiting.is_empty() {
            if !goes_on || swept.get_or_insert_with(Instant::now).elapsed() > refine::BUDGET {
                break;
            }
            waiting = refine::finer(&rows, session.library);
            waiting.retain(|(_, next)| comparison.failures.iter().all(|failure| failure.label != next.label()));
            comparison.planned += waiting.len();
            if waiting.is_empty() {
                break;
            }
        }
        let planned = comparison.planned;
        let mut batch: Vec<(usize, Row, Painter<'_>)> = Vec::new();
        let mut bytes = 0;
        while bytes < BATCH_BYTES && batch.len() < BATCH && !(session.stop)() {
            let is_own = |(_, next): &mut (usize, Candidate)| truths.is_own(session.library, &next.scene);
            let is_of_batch = batch.first().map(|(_, row, _)| row.truth.is_own);
            let Some((index, candidate)) = waiting.pop_if(|next| is_of_batch.is_none_or(|own| own == is_own(next)))
            else {
                break;
            };
            let mut renderer = session.painter();
            let label = candidate.label();
            match first(session.library, candidate, &mut renderer, &mut truths, compute_reference) {
                Ok(mut row) => {
                    bytes += row.first.measurements.device_bytes;
                    row.normals = normals.angles(&row.candidate.scene);
                    batch.push((index, row, renderer));
                }
                Err(_) if (session.stop)() => {} // the candidate was interrupted
                Err(message) => comparison.failures.push(Failure { label, message }),
            }
            progress((planned - waiting.len()) as f32 / planned as f32 - 0.5 * batch.len() as f32 / planned as f32);
        }
        let done = (planned - waiting.len()) as f32 / planned as f32;
        let share = 0.5 * batch.len() as f32 / planned as f32;
        let within = |fraction: f32| progress(done - share * (1.0 - fraction));
        comparison.failures.extend(time(&mut batch, settings, &mut random, session, &within));
        rows.extend(batch.into_iter().filter(|(_, row, _)| !row.runs.is_empty()).map(|(index, row, _)| (index, row)));
        // Candidates of the own truth are taken first.
        let is_own = |(_, next): &(usize, Candidate)| truths.is_own(session.library, &next.scene);
        if !is_told && waiting.last().is_some_and(|next| !is_own(next)) {
            is_told = true;
            first_table(&rows, tell);
        }
    }
    comparison.partial = (session.stop)();
    rows.sort_by_key(|(index, row)| (*index, row.candidate.samples()));
    comparison.rows = rows.into_iter().map(|(_, row)| row).collect();
    Ok(comparison)
}

/// Reports the front of the scene's own truth.
fn first_table(rows: &[(usize, Row)], tell: &dyn Fn(&str)) {
    let own: Vec<&Row> = rows.iter().map(|(_, row)| row).filter(|row| row.truth.is_own).collect();
    let points: Vec<(f64, f64)> = own.iter().map(|row| row.point()).collect();
    for row in front::front(&points).into_iter().map(|index| own[index]) {
        tell(&format!("so far     {}", row.text()));
    }
}

/// A candidate's first picture, held against its truth.
fn first(
    library: &Library,
    candidate: Candidate,
    renderer: &mut Painter<'_>,
    truths: &mut GroundTruths,
    compute_reference: &mut ComputeReference<'_>,
) -> Result<Row, String> {
    let truth =
        truths.of(library, &candidate.scene, compute_reference).map_err(|reason| format!("no reference: {reason}"))?;
    let reference = &truth.reference;
    let first = renderer.render(&candidate.scene).map_err(|error| error.to_string())?;
    if reference.size != first.size {
        return Err(format!("the reference is {:?} pixels and the picture {:?}", reference.size, first.size));
    }
    let background = candidate.scene.image.background.unwrap_or(BACKGROUND);
    let mut metrics = Metrics::of(&first.pixels, reference, background);
    if let Some(own) = own_octaves(library, &candidate)? {
        let own = own.map(|own| truths.of(library, &own, compute_reference)).transpose();
        let own = own.map_err(|reason| format!("no reference of its octaves: {reason}"))?;
        metrics.own_rmse = own.map(|own| Errors::between(&first.pixels, &own.reference.pixels).rmse);
    }
    if let Some(bad) = NotFinite::of(&first.pixels, first.size[0]) {
        return Err(bad.to_string());
    }
    if !metrics.errors.rmse.is_finite() {
        return Err("its reference has pixels that are not finite".into());
    }
    let first = Frame { pixels: Vec::new(), ..first }; // many pictures would not fit into memory
    Ok(Row { candidate, truth, metrics, normals: None, runs: Vec::new(), first })
}

/// The scene whose truth has only the octaves of a candidate's turbulence; `None` if these are all octaves of the
/// scene. `Some(None)` if such a scene is impossible, as beside a sum of noise of all octaves.
#[expect(clippy::option_option, reason = "not needed, or not possible")]
fn own_octaves(library: &Library, candidate: &Candidate) -> Result<Option<Option<Scene>>, String> {
    let (scene, held) = (&candidate.scene, candidate.scene.octaves_held(library));
    let variant = hypertexture::render::variant::Variant::of(scene, library).map_err(|error| error.to_string())?;
    if held == scene.effect.octaves || !variant.reads("turbulence") {
        return Ok(None);
    }
    let files = library.files_reached(&variant.entries, &variant.slots).map_err(|error| error.to_string())?;
    let mut own = scene.unbaked(library).map_err(|error| error.to_string())?;
    own.effect.octaves = held;
    Ok(Some((!files.iter().any(|file| file == "fractal_sum.glsl")).then_some(own)))
}

/// Times a batch; a candidate that fails is reported and its runs are dropped.
fn time(
    batch: &mut [(usize, Row, Painter<'_>)],
    settings: &Settings,
    random: &mut SplitMix,
    session: Session<'_>,
    progress: &dyn Fn(f32),
) -> Vec<Failure> {
    let (stop, on_processor) = (session.stop, session.gpu.info().cpu);
    let full = usize::from(!settings.sweep.quick);
    let fit = |ms: f64, row: &Row| (ms / row.first.measurements.gpu_ms.max(1e-3)) as usize;
    let fewest = FEWEST_RUNS.min(settings.repeat);
    let warm: Vec<usize> = batch.iter().map(|(_, row, _)| fit(WARM_MS[full], row).clamp(1, WARM_UPS)).collect();
    let runs: Vec<usize> =
        batch.iter().map(|(_, row, _)| fit(REPEAT_MS[full], row).clamp(fewest, settings.repeat)).collect();
    let all = warm.iter().chain(&runs).sum::<usize>();
    let orders = [(interleave(&warm, random), false), (interleave(&runs, random), true)];
    let order = orders.iter().flat_map(|(order, timed)| order.iter().map(|&index| (index, *timed)));
    let mut failures: Vec<Failure> = Vec::new();
    for (done, (index, timed)) in order.enumerate() {
        if stop() {
            break;
        }
        let (_, row, renderer) = &mut batch[index];
        let label = row.candidate.label();
        if failures.iter().any(|failure| failure.label == label) {
            continue;
        }
        match run(renderer, &row.candidate.scene) {
            Ok(run) if timed => {
                row.runs.push(Run { processor_ms: run.processor_ms.filter(|_| on_processor), ..run });
            }
            Ok(_) => {}
            Err(error) => {
                row.runs.clear();
                failures.push(Failure { label, message: error.to_string() });
            }
        }
        progress((done + 1) as f32 / all as f32);
    }
    failures
}

/// One run of a renderer that is ready for the scene.
fn run(renderer: &mut Painter<'_>, scene: &Scene) -> Result<Run, RenderError> {
    let m = renderer.render_anew(scene)?.measurements;
    Ok(Run { gpu_ms: m.device_ms(), processor_ms: m.processor_ms, wall_ms: m.total_ms - m.compile_ms })
}
