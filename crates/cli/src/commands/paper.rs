//! The paper's tables, replayed from the command line.

use super::compare::{Compare, truth};
use crate::arguments::SceneArguments;
use crate::session::{Failed, Interrupted, checked, make_folder, start, stop_flag};
use crate::terminal::{absolute, announced, say, with_progress};
use hypertexture::gpu::{Gpu, Options};
use hypertexture::render::Subject;
use hypertexture::render::variant::Variant;
use hypertexture::scene::Scene;
use hypertexture_measure::compare::Session;
use hypertexture_measure::compare::paper::measure::replay;
use hypertexture_measure::compare::paper::numbers::EFFECTS;
use hypertexture_measure::compare::paper::replay::{Plan, SLICES, paper_quality};
use hypertexture_measure::compare::report::replay::{Replayed, text, write};
use hypertexture_measure::compare::report::{Environment, file_name, load};
use hypertexture_measure::worker::{Load, Worker};
use std::error::Error;
use std::iter;
use std::sync::atomic::Ordering;

/// Pixels of the pictures that are held against their reference, unless said otherwise.
const ERROR_SIZE: [u32; 2] = [64, 64];
/// Timed runs of a cell, at most, unless said otherwise.
const REPEAT: usize = 7;

/// Replays the tables, and writes the report.
pub fn run(command: &Compare, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let plan = plan(command)?;
    let first = &plan.effects[0];
    let (variant, library) = checked(first)?;
    let others = plan.effects[1..].iter().map(|scene| Variant::of(scene, &library));
    let variants = iter::once(Ok(variant)).chain(others).collect::<Result<Vec<_>, _>>()?;
    let margins = variants.iter().map(|variant| variant.parameters.outer_iso().unwrap_or(first.object.outer_iso));
    let (margin, closest) = (margins.fold(0.0, f32::max), variants.iter().any(Variant::reads_closest));
    let subject = with_progress(quiet, "distance field", |progress| {
        Subject::load_with_margin(&first.object, margin, closest, progress)
    })?;
    let gpu = Gpu::new(options)?;
    let flag = stop_flag()?;
    make_folder(&command.output)?;
    let stop = || flag.load(Ordering::Relaxed);
    let object = Box::new(first.object.clone());
    let worker = Worker::new(&start(options)?, &library, Load::Object { object, margin, closest });
    let session = Session { gpu: &gpu, library: &library, subject: &subject, worker: Some(&worker), stop: &stop };
    let (environment, object) = (Environment::of(&gpu), file_name(command.input()));
    let replay = announced(quiet, "paper", |progress| {
        progress(0.0);
        replay(session, plan, &mut |scene: &Scene| truth(session, scene, &|_| ()), &|part| progress(part))
    });
    let environment = Environment { load_after: load(), ..environment };
    let report = Replayed { object, environment, replay };
    let page = write(&report, &command.output)?;
    if !quiet {
        say(&text(&report));
        say(&format!("wrote {}\n", absolute(&page)));
    }
    if report.replay.partial {
        return Err(
            Interrupted("interrupted: the report has the measurements so far and is marked as partial".into()).into()
        );
    }
    match report.replay.failures().as_slice() {
        [] => Ok(()),
        [first, ..] => {
            Err(Failed(format!("{} cells failed; the first: {first}", report.replay.failures().len())).into())
        }
    }
}

/// The six effects on the object as the paper drew them, with the arguments over that.
fn plan(command: &Compare) -> Result<Plan, Box<dyn Error>> {
    let repeat = command.repeat.unwrap_or(REPEAT);
    if !(1..=1000).contains(&repeat) {
        return Err(format!("--repeat {repeat}: must be from 1 to 1000").into());
    }
    let scale = command.scale.unwrap_or(1.0);
    if !(0.02..=4.0).contains(&scale) {
        return Err(format!("--scale {scale}: must be from 0.02 to 4").into());
    }
    let arguments = &command.arguments;
    let effect = |(name, ..): &(&str, &str, _)| -> Result<Scene, Box<dyn Error>> {
        let mut scene = SceneArguments { effect: Some(name.to_string()), ..arguments.clone() }
            .scene(command.input(), &command.object)?;
        let asked = scene.quality.clone();
        scene.quality = paper_quality(&asked);
        let quality = &mut scene.quality;
        let has = |name: &str| arguments.settings.has(name);
        quality.samples = if has("quality.samples") { asked.samples } else { SLICES };
        quality.target = if has("quality.target") { asked.target } else { quality.target };
        quality.proxy = if has("quality.proxy") { asked.proxy } else { quality.proxy };
        Ok(scene)
    };
    let effects = EFFECTS.iter().map(effect).collect::<Result<Vec<_>, _>>()?;
    let asked = effects.first().filter(|_| arguments.settings.has("image.size")).map(|scene| scene.image.size);
    Ok(Plan { effects, scale, quick: !command.thorough, repeat, error_size: asked.unwrap_or(ERROR_SIZE) })
}
