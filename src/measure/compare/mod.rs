//! Comparison: what accuracy costs, measured.
//!
//! Role: a scene into candidates ([`candidates`]), each rendered, held against its reference ([`metrics`]) and timed
//! ([`timing`]); from these the front of what is worth its time ([`front`]), and a report ([`report`]). Invariants: what
//! failed is told and fails the report; every time has its spread and every picture its error; the same scene gives the
//! same errors, digit by digit.
//!
//! A candidate is measured against the truth of its own scene: a block of noise repeats the lattice noise that it was
//! made of, so its truth is that noise, summed exactly, and what the block lost is part of its error. Another strategy
//! has another noise, and a truth of its own.

#[doc(hidden)] // for the tests of this crate
pub mod candidates;
#[doc(hidden)] // for the tests of this crate
pub mod front;
pub mod metrics;
#[doc(hidden)] // for the tests of this crate
pub mod paper;
pub mod report;
mod ssim;
#[doc(hidden)] // for the tests of this crate
pub mod timing;

use crate::gpu::Gpu;
use crate::measure::metric::Errors;
use crate::measure::reference::{Reference, truth_of};
use crate::measure::statistics::rms;
use crate::measure::worker::{Painter, Worker};
use crate::render::{Frame, RenderError, Subject};
use crate::scene::{Color, Integration, Pass, Scene, SceneError};
use crate::shader::{Library, LibraryError};
use crate::support::random::SplitMix;
use candidates::{Candidate, Sweep};
use metrics::{Angles, Metrics};
use std::sync::Arc;
use timing::{FEWEST_RUNS, Run, Spread, interleave};

/// Background of a scene that has none, where a person looks at the picture: that of the gallery.
pub const BACKGROUND: Color = Color([24, 26, 31]);
/// Order of the candidates and of their runs.
const SEED: u64 = 2005;
/// Bytes of images on the device that are timed together. More: the device runs out of memory. Less: runs that are
/// compared lie farther apart in time.
const BATCH_BYTES: u64 = 768 << 20;
/// Candidates that are timed together, at most.
const BATCH: usize = 48;
/// Time that the repetitions of one candidate may take, milliseconds; quick, and in full. A candidate that needs more has
/// fewer runs, but not fewer than six.
const REPEAT_MS: [f64; 2] = [250.0, 2000.0];
/// The same of its warm-ups, of which there is at least one.
const WARM_MS: [f64; 2] = [50.0, 300.0];
/// Runs before those that are timed, at most.
const WARM_UPS: usize = 5;
/// Samples of the picture of normals that others are held against.
const NORMAL_SAMPLES: u32 = 4096;

/// What to compare.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The candidates.
    pub sweep: Sweep,
    /// Timed runs of each candidate, at most.
    pub repeat: usize,
}

/// Why there is no comparison.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// A module is missing, or its header cannot be read.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// The scene is not valid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Every candidate is refused.
    #[error("no candidate is left; sweep fewer samples")]
    Nothing,
    /// A picture of the report cannot be made.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A file of the report cannot be written.
    #[error(transparent)]
    Output(#[from] crate::output::OutputError),
}

/// A candidate that was measured.
#[derive(Clone, Debug)]
pub struct Row {
    /// What was drawn.
    pub candidate: Candidate,
    /// The truth of its scene.
    pub truth: Arc<Reference>,
    /// How far it is from the truth.
    pub metrics: Metrics,
    /// Root mean square of what the reference says of its own error.
    pub reference_error: f64,
    /// How far its surface is turned from that of many samples, where the scene has a surface.
    pub normals: Option<Angles>,
    /// Every run, in the order in which they were made.
    pub runs: Vec<Run>,
    /// What it took to begin with.
    pub first: Frame,
}

impl Row {
    /// Milliseconds on the device.
    pub fn gpu(&self) -> Spread {
        Spread::of(&self.runs.iter().map(|run| run.gpu_ms).collect::<Vec<_>>())
    }

    /// Milliseconds from scene to pixels.
    pub fn wall(&self) -> Spread {
        Spread::of(&self.runs.iter().map(|run| run.wall_ms).collect::<Vec<_>>())
    }

    /// Time on the device and linear error: the axes of the report.
    pub fn point(&self) -> (f64, f64) {
        (self.gpu().median, self.metrics.errors.rmse)
    }

    /// 1 / (mean square error x seconds): how much is had for the time.
    pub fn efficiency(&self) -> f64 {
        1.0 / (self.metrics.errors.rmse.powi(2) * self.gpu().median * 1e-3)
    }
}

/// A candidate that has no row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The candidate in words.
    pub label: String,
    /// What went wrong.
    pub message: String,
}

impl Failure {
    /// That of a candidate.
    pub fn of((candidate, error): &(Candidate, RenderError)) -> Failure {
        Failure { label: candidate.label(), message: error.to_string() }
    }
}

/// What was measured.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The scene, with the size that was compared.
    pub scene: Scene,
    /// The candidates, curve by curve.
    pub rows: Vec<Row>,
    /// Those that failed.
    pub failures: Vec<Failure>,
    /// Candidates that were planned.
    pub planned: usize,
    /// Whether it was stopped before its end.
    pub partial: bool,
}

impl Comparison {
    /// The indices of the rows that no other row beats, by rising time.
    pub fn front(&self) -> Vec<usize> {
        front::front(&self.points())
    }

    /// Time and error of every row.
    pub fn points(&self) -> Vec<(f64, f64)> {
        self.rows.iter().map(Row::point).collect()
    }
}

/// Computes the reference of a scene.
pub type Refer<'a> = dyn FnMut(&Scene) -> Result<Arc<Reference>, String> + 'a;

/// The references that were asked for so far, each computed once.
#[derive(Clone, Debug, Default)]
struct Truths(Vec<(Scene, Result<Arc<Reference>, String>)>);

impl Truths {
    /// The reference of a scene, whatever its quality.
    fn of(&mut self, library: &Library, scene: &Scene, refer: &mut Refer<'_>) -> Result<Arc<Reference>, String> {
        let truth = truth_of(scene, library).map_err(|error| error.to_string())?;
        if let Some(known) = self.get(&truth) {
            return known.clone();
        }
        let found = refer(&truth);
        self.0.push((truth, found.clone()));
        found
    }

    fn get(&self, truth: &Scene) -> Option<&Result<Arc<Reference>, String>> {
        self.0.iter().find(|(known, _)| known == truth).map(|(_, reference)| reference)
    }
}

/// All that pictures are made with.
#[derive(Clone, Copy)]
pub struct Stage<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// The modules.
    pub library: &'a Library,
    /// The object of the scene.
    pub subject: &'a Subject,
    /// Who draws the candidates, so that one by which the driver ends costs no other; `None`: this process.
    pub worker: Option<&'a Worker>,
    /// Whether the person or the scheduler wants an end.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Stage<'a> {
    /// Whoever draws a candidate.
    pub fn painter(&self) -> Painter<'a> {
        Painter::new(self.gpu, self.library, self.subject, self.worker)
    }
}

/// Draws, measures and times every candidate for a scene; `refer` gives the truth of a scene. Stopped, it keeps the
/// candidates that were timed.
///
/// # Errors
/// The scene has no candidate. What goes wrong with one of several is a [`Failure`].
pub fn compare(
    stage: Stage<'_>,
    scene: &Scene,
    settings: &Settings,
    refer: &mut Refer<'_>,
    progress: &dyn Fn(f32),
) -> Result<Comparison, CompareError> {
    let mut waiting: Vec<(usize, Candidate)> =
        candidates::candidates(scene, stage.library, &settings.sweep)?.into_iter().enumerate().collect();
    let planned = waiting.len();
    let mut random = SplitMix(SEED);
    random.shuffle(&mut waiting); // so that a batch holds a bit of everything
    let mut normals = Normals::new(stage, scene);
    let mut rows: Vec<(usize, Row)> = Vec::new();
    let mut comparison =
        Comparison { scene: scene.clone(), rows: Vec::new(), failures: Vec::new(), planned, partial: false };
    let mut truths = Truths::default();
    while !waiting.is_empty() && !(stage.stop)() {
        let mut batch: Vec<(usize, Row, Painter<'_>)> = Vec::new();
        let mut bytes = 0;
        while bytes < BATCH_BYTES && batch.len() < BATCH && !(stage.stop)() {
            let Some((index, candidate)) = waiting.pop() else { break };
            let mut renderer = stage.painter();
            let label = candidate.label();
            match first(stage.library, candidate, &mut renderer, &mut truths, refer) {
                Ok(mut row) => {
                    bytes += row.first.measurements.device_bytes;
                    row.normals = normals.angles(&row.candidate.scene);
                    batch.push((index, row, renderer));
                }
                Err(_) if (stage.stop)() => {} // whatever it was in the middle of
                Err(message) => comparison.failures.push(Failure { label, message }),
            }
            progress((planned - waiting.len()) as f32 / planned as f32 - 0.5 * batch.len() as f32 / planned as f32);
        }
        let done = (planned - waiting.len()) as f32 / planned as f32;
        let share = 0.5 * batch.len() as f32 / planned as f32;
        let within = |fraction: f32| progress(done - share * (1.0 - fraction));
        comparison.failures.extend(time(&mut batch, settings, &mut random, stage.stop, &within));
        rows.extend(batch.into_iter().filter(|(_, row, _)| !row.runs.is_empty()).map(|(index, row, _)| (index, row)));
    }
    comparison.partial = (stage.stop)();
    rows.sort_by_key(|(index, _)| *index);
    comparison.rows = rows.into_iter().map(|(_, row)| row).collect();
    Ok(comparison)
}

/// A candidate's first picture, held against its truth.
fn first(
    library: &Library,
    candidate: Candidate,
    renderer: &mut Painter<'_>,
    truths: &mut Truths,
    refer: &mut Refer<'_>,
) -> Result<Row, String> {
    let truth = truths.of(library, &candidate.scene, refer).map_err(|reason| format!("no reference: {reason}"))?;
    let first = renderer.render(&candidate.scene).map_err(|error| error.to_string())?;
    if truth.size != first.size {
        return Err(format!("the reference is {:?} pixels and the picture {:?}", truth.size, first.size));
    }
    let background = candidate.scene.image.background.unwrap_or(BACKGROUND);
    let mut metrics = Metrics::of(&first.pixels, &truth, background);
    if let Some(own) = own_octaves(library, &candidate)? {
        let own = own.map(|own| truths.of(library, &own, refer)).transpose();
        let own = own.map_err(|reason| format!("no reference of its octaves: {reason}"))?;
        metrics.own_rmse = own.map(|own| Errors::between(&first.pixels, &own.pixels).rmse);
    }
    if metrics.not_finite > 0 || !metrics.errors.rmse.is_finite() {
        return Err(format!("{} values are not finite", metrics.not_finite.max(1)));
    }
    let reference_error = rms(truth.estimate.iter().copied());
    let first = Frame { pixels: Vec::new(), ..first }; // many pictures would not fit into memory
    Ok(Row { candidate, truth, metrics, reference_error, normals: None, runs: Vec::new(), first })
}

/// The scene whose truth has the octaves alone that a candidate's turbulence has; `None` where those are all that are asked
/// for. `Some(None)` where there is no such scene: a sum of noise of all octaves is read beside it.
#[expect(clippy::option_option, reason = "none is needed, or none can be had")]
fn own_octaves(library: &Library, candidate: &Candidate) -> Result<Option<Option<Scene>>, String> {
    let (scene, held) = (&candidate.scene, candidate.scene.octaves_held(library));
    let variant = crate::render::variant::Variant::of(scene, library).map_err(|error| error.to_string())?;
    if held == scene.effect.octaves || !variant.reads("turbulence") {
        return Ok(None);
    }
    let files = library.files_reached(&variant.entries, &variant.slots).map_err(|error| error.to_string())?;
    let mut own = scene.unbaked(library).map_err(|error| error.to_string())?;
    own.effect.octaves = held;
    Ok(Some((!files.iter().any(|file| file == "fractal_sum.glsl")).then_some(own)))
}

/// Times the candidates of a batch; whoever fails on the way is told and loses its runs.
fn time(
    batch: &mut [(usize, Row, Painter<'_>)],
    settings: &Settings,
    random: &mut SplitMix,
    stop: &dyn Fn() -> bool,
    progress: &dyn Fn(f32),
) -> Vec<Failure> {
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
            Ok(run) if timed => row.runs.push(run),
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
    let m = renderer.render(scene)?.measurements;
    Ok(Run { gpu_ms: m.gpu_ms + m.shadow_ms.unwrap_or(0.0), wall_ms: m.total_ms - m.compile_ms })
}

/// The normals of the hard surface, as candidates see them.
struct Normals<'a> {
    renderer: Painter<'a>,
    finest: Option<Frame>,
    /// Look and angles of every way to sample it.
    known: Vec<(Scene, Option<Angles>)>,
}

impl<'a> Normals<'a> {
    fn new(stage: Stage<'a>, scene: &Scene) -> Normals<'a> {
        let mut renderer = stage.painter();
        let mut look = look(scene);
        let quality = &mut look.quality;
        (quality.pass, quality.integration, quality.samples) = (Pass::March, Integration::Segment, NORMAL_SAMPLES);
        let has_surface = scene.quality.supersampling == 1 && scene.effect.warp.is_empty() && !scene.has_several();
        let finest = if has_surface { renderer.render(&look).ok() } else { None };
        Normals { renderer, finest, known: Vec::new() }
    }

    /// The angles of a candidate; `None` where there is no surface of its own to look at.
    fn angles(&mut self, scene: &Scene) -> Option<Angles> {
        let finest = self.finest.as_ref()?;
        let look = look(scene);
        if let Some((_, known)) = self.known.iter().find(|(other, _)| *other == look) {
            return *known;
        }
        let frame = self.renderer.render(&look).ok();
        let angles = frame.and_then(|frame| metrics::normal_angles(&frame.pixels, &finest.pixels));
        self.known.push((look, angles));
        angles
    }
}

/// The look `normals` of a scene: its bare surface, with what decides where that is found and nothing else.
fn look(scene: &Scene) -> Scene {
    let effect = crate::scene::Effect { surface: "normals".into(), ..Default::default() };
    let mut look = Scene { effect, parameters: Default::default(), ..scene.clone() };
    look.light.shadows = false;
    let default = crate::scene::Quality::default();
    let quality = &mut look.quality;
    (quality.block_size, quality.turbulence_cells) = (default.block_size, default.turbulence_cells);
    quality.target = default.target;
    look
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::preset;

    #[test]
    fn a_truth_is_computed_once_for_all_qualities() {
        let mut asked = 0;
        let mut refer = |scene: &Scene| {
            asked += 1;
            let [width, height] = scene.image.size;
            let count = (width * height) as usize;
            let (pixels, estimate, open) = (vec![[0.0; 4]; count], vec![0.0; count], vec![0.0; count]);
            Ok(Arc::new(Reference { size: scene.image.size, pixels, estimate, open }))
        };
        let (library, mut truths) = (crate::shader::shipped(), Truths::default());
        let mut scene = preset("fire").unwrap();
        for samples in [8, 16, 32] {
            scene.quality.samples = samples;
            truths.of(&library, &scene, &mut refer).unwrap();
        }
        scene.effect.turbulence = "procedural".into();
        truths.of(&library, &scene, &mut refer).unwrap();
        assert_eq!(asked, 2);
        let failed = truths.of(&library, &preset("lit").unwrap(), &mut |_| Err("no such function".into()));
        assert_eq!(failed.unwrap_err(), "no such function");
    }
}
