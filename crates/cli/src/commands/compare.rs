//! Error against run time, from the command line.

use super::export::live;
use crate::arguments::{ObjectFlags, SceneArguments, SceneInput};
use crate::session::{
    CheckedScene, Failed, Interrupted, Outputs, Preparation, Prepared, make_folder, say_fault, start, stop_flag,
};
use crate::terminal::{absolute, announced, say};
use clap::Args;
use hypertexture::field::Progress;
use hypertexture::gpu::{Gpu, Options};
use hypertexture::output::{Depth, Provenance, encode_png};
use hypertexture::render::Frame;
use hypertexture::scene::{Scene, to_text};
use hypertexture_measure::compare::candidates::{Candidate, Sweep, candidates};
use hypertexture_measure::compare::report::{self, Environment, Report};
use hypertexture_measure::compare::{Comparison, Forecast, Session, Settings, compare, paper};
use hypertexture_measure::reference::{Reference, TOLERANCE, reference};
use hypertexture_measure::worker::{Load, Worker};
use std::cell::Cell;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// The object of the paper's tables, unless another is given.
const OBJECT: &str = "teapot";
/// Share of the progress that candidates take; the rest is the paper's table.
const CANDIDATES: f32 = 0.8;

/// Pixels of the pictures that are compared, unless said otherwise.
const SIZE: [u32; 2] = [128, 128];

/// Arguments of `compare`.
#[derive(Args)]
pub struct Compare {
    /// An object, a scene file (.toml), or an effect or example scene such as fire.
    ///
    /// With --paper, the object [default: teapot].
    #[arg(value_name = "SCENE", required_unless_present = "paper")]
    input: Option<String>,
    /// Replay the tables of Miller and Jones 2005.
    ///
    /// Frames per second of six effects and four sources of turbulence, with errors, beside the printed ones; on
    /// --samples slices [default: 128].
    #[arg(long, conflicts_with_all = ["effect", "debug_view", "sweep", "strategies", "pass", "integration", "msaa", "anisotropy"])]
    pub paper: bool,
    /// With --paper: scale of the paper's windows in width and height. It leaves out the largest block of noise.
    #[arg(long, requires = "paper", value_name = "PART", hide_short_help = true)]
    pub scale: Option<f64>,
    /// Folder of the report.
    #[arg(long, short, default_value = "compare", value_name = "FOLDER")]
    pub output: PathBuf,
    /// Try every candidate, block and format, with up to 512 samples.
    ///
    /// Without this and --sweep, the front of the scene's own noise doubles its samples up to an error of 0.001, for at
    /// most 60 seconds. With --paper, all windows in place of 300 x 300 without smoothing.
    #[arg(long)]
    pub thorough: bool,
    /// Write a live page of each picture of the fronts too.
    #[arg(long, hide_short_help = true)]
    pub web: bool,
    /// Timed runs of each candidate, at most, 1 to 1000 [default: 7; thorough: 31].
    #[arg(long, value_name = "RUNS", hide_short_help = true)]
    pub repeat: Option<usize>,
    /// Samples to try, such as 32,64,128.
    #[arg(long, value_delimiter = ',', value_name = "LIST")]
    pub sweep: Option<Vec<u32>>,
    /// Strategies of turbulence and noise to try.
    ///
    /// Such as encoded,procedural.
    #[arg(long, value_delimiter = ',', value_name = "LIST")]
    pub strategies: Option<Vec<String>>,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// The scene, at 128 x 128 pixels by default.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

impl Compare {
    /// The scene to compare.
    pub fn input(&self) -> &str {
        self.input.as_deref().unwrap_or(OBJECT)
    }
}

/// Compares, and writes the report.
pub fn run(command: &Compare, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let (scene, mut settings) = plan(command)?;
    let scene = CheckedScene::of(scene)?;
    // Faults of the settings are reported before the work begins.
    candidates(&scene.moving, &scene.library, &settings.sweep)?;
    let (input, outputs) = (command.input(), &Outputs::Folder(command.output.clone()));
    let preparation = Preparation { input, outputs, device: Some(options), serves_all_moments: false, quiet };
    let Prepared { moving: scene, library, subject, fault, .. } = scene.prepare(&preparation)?;
    let gpu = Gpu::new(options)?;
    settings.sweep.filters = gpu.info().filters_by_few_bits();
    let flag = stop_flag()?;
    make_folder(&command.output)?;
    let stop = || flag.load(Ordering::Relaxed);
    let worker = Worker::new(&start(options)?, &library, Load::Scene(to_text(&scene)));
    let session = Session { gpu: &gpu, library: &library, subject: &subject, worker: Some(&worker), stop: &stop };
    let environment = Environment::of(&gpu);
    let title = title(command);
    let report = announced(quiet, "compare", |progress| -> Result<Report, Box<dyn Error>> {
        progress(0.0);
        let tell = |line: &str| {
            if !quiet {
                say(&format!("{line}\n"));
            }
        };
        let forecast = Forecast::of(session, &scene, &settings)?;
        tell(&format!("compare    {}", forecast.text()));
        let (references, candidates) = (Cell::new(0u32), Cell::new(0.0f32));
        let done = |references: f32, candidates: f32| {
            CANDIDATES * forecast.done(f64::from(references), f64::from(candidates)) as f32
        };
        let mut compute_reference = |scene: &Scene| {
            let (before, candidates) = (references.get() as f32, candidates.get());
            references.set(references.get() + 1);
            truth(session, scene, &|part| progress(done(before + part, candidates)))
        };
        let part = |fraction: f32| {
            candidates.set(fraction);
            progress(done(references.get() as f32, fraction));
        };
        let mut comparison = compare(session, &scene, &settings, &mut compute_reference, &tell, &part)?;
        let mut failures = Vec::new();
        let part = |fraction: f32| progress(CANDIDATES + (1.0 - CANDIDATES) * fraction);
        let table = paper::table(session, &comparison, !command.thorough, &mut failures, &part);
        let crops = paper::figure(session, &comparison, &mut failures);
        let pictures = report::pictures(session, &comparison, &mut failures);
        comparison.failures.extend(failures);
        let comparison = Comparison { partial: comparison.partial || stop(), ..comparison };
        let live = if command.web { live_pages(session, &comparison, &pictures, &command.output)? } else { Vec::new() };
        let environment = Environment { load_after: report::load(), ..environment };
        let hash = report::hash(&scene);
        Ok(Report { title, hash, tolerance: TOLERANCE, environment, comparison, pictures, live, table, crops })
    })?;
    let page = report::write(&report, &command.output)?;
    if !quiet {
        say_fault(fault);
    }
    conclude(&report, &page, quiet)
}

/// Writes the live pages of pictures; the rows that have one.
fn live_pages(
    session: Session<'_>,
    comparison: &Comparison,
    pictures: &[(usize, Frame)],
    folder: &Path,
) -> Result<Vec<usize>, Box<dyn Error>> {
    let mut rows = Vec::new();
    for (row, frame) in pictures {
        let Candidate { scene, .. } = &comparison.rows[*row].candidate;
        let title = comparison.rows[*row].candidate.label();
        let provenance = Provenance::of(scene, &session.gpu.info().title(), &frame.measurements)?;
        let picture = encode_png(frame, scene.image.background, Depth::Eight, &provenance)?;
        let path = folder.join(report::live_page(*row));
        if live(session.library, session.subject, scene, &title, &picture, &path)? {
            rows.push(*row);
        }
    }
    Ok(rows)
}

/// The scene and what to do with it.
fn plan(command: &Compare) -> Result<(SceneInput, Settings), Box<dyn Error>> {
    let repeat = command.repeat.unwrap_or(if command.thorough { 31 } else { 7 });
    if !(1..=1000).contains(&repeat) {
        return Err(format!("--repeat {repeat}: must be from 1 to 1000").into());
    }
    let mut scene = command.arguments.scene_and_base(command.input(), &command.object)?.still()?;
    if !command.arguments.settings.has("image.size") {
        scene.scene.image.size = SIZE;
    }
    let (samples, strategies) = (command.sweep.clone(), command.strategies.clone());
    Ok((scene, Settings { sweep: Sweep { quick: !command.thorough, samples, strategies, filters: false }, repeat }))
}

fn title(command: &Compare) -> String {
    let input = report::file_name(command.input());
    command.arguments.effect.as_ref().map_or(input.clone(), |effect| format!("{effect} on {input}"))
}

/// The end: what was written, and whether it is good.
fn conclude(report: &Report, page: &Path, quiet: bool) -> Result<(), Box<dyn Error>> {
    let Comparison { rows, failures, planned, partial, .. } = &report.comparison;
    if !quiet {
        for (number, group) in report.comparison.groups().iter().enumerate() {
            let own = if group.truth.is_own { ", the scene's own" } else { "" };
            say(&format!("truth {number}    {}{own}\n", group.truth.pattern));
            for row in group.front.iter().map(|&index| &rows[index]) {
                say(&format!("front      {}\n", row.text()));
            }
        }
        say(&format!("wrote {}\n", absolute(page)));
    }
    if *partial {
        let measured = rows.len();
        return Err(Interrupted(format!(
            "interrupted: {measured} of {planned} candidates are in the report, which is marked as partial"
        ))
        .into());
    }
    match failures.first() {
        None => Ok(()),
        Some(first) => {
            let (count, label, message) = (failures.len(), &first.label, &first.message);
            Err(Failed(format!("{count} of {planned} candidates failed; the first, {label}: {message}")).into())
        }
    }
}

/// The exact picture of a scene.
pub(crate) fn truth(session: Session<'_>, scene: &Scene, progress: Progress<'_>) -> Result<Arc<Reference>, String> {
    let found = reference(session.library, scene, session.subject, TOLERANCE, progress, session.stop);
    found.map(Arc::new).map_err(|error| error.to_string())
}
