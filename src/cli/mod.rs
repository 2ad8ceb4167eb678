//! The command line: arguments to calls of the library, errors to one line and an exit code.

mod args;
mod compare;
#[cfg(all(test, feature = "viewer"))]
mod docs_tests;
pub mod doctor;
pub mod gallery;
mod ignored;
#[cfg(all(test, feature = "viewer"))]
mod line_tests;
mod log;
mod manual;
mod modules;
mod paper;
mod scene_arguments;
mod sequence;
mod verify;
#[cfg(feature = "viewer")]
mod view;

use args::Arguments;
use args::{Command, Field, Gallery, Merge, Render};
use compare::Failed;
use sequence::Interrupted;
use sequence::ShardChoice;
use verify::Disagreement;
#[cfg(feature = "viewer")]
use view::NoWindow;

use crate::gpu::{Format, Gpu, Options};
use crate::measure::compare::{Failure, Stage};
use crate::measure::pick::{ErrorBound, Pick, remembered};
use crate::measure::predict::{Estimate, Prediction, predict};
use crate::measure::worker::{self, Load, PATIENCE, Start, Worker};
use crate::output::shard::{self, Shard};
use crate::output::{self, Provenance};
use crate::render::variant::Variant;
use crate::render::{Frame, Renderer, Subject, open, request};
use crate::scene::{self, Object, ParameterValue, Pass, Scene};
use crate::shader::{self, Library, ParameterKind};
use crate::support::write_whole;
#[cfg(feature = "viewer")]
use crate::viewer::author::{compile, rays};
use crate::{field, shape};
use clap::Parser;
use clap::error::ErrorKind;
use indicatif::{ProgressBar, ProgressStyle};
use std::error::Error;
use std::io::Write;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Exit code of anything that the person at the keyboard can mend.
const BAD_INPUT: u8 = 2;
/// Exit code of a window that could not be shown, or not be shown on.
#[cfg(feature = "viewer")]
const NO_WINDOW: u8 = 1;
/// Exit code of `verify` where a device or a picture is not as it must be.
const DISAGREES: u8 = 1;

/// Exit code of a program that was interrupted, as shells have it: 128 and the number of SIGINT.
pub const INTERRUPTED: u8 = 130;

/// Exit code of a report that holds failures.
pub const FAILED: u8 = 1;

/// The program: arguments to calls, errors to one line and an exit code.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            say(&error.render().to_string());
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            let text = match error.kind() {
                ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => "error: no command".into(),
                _ => error.to_string(),
            };
            let is_end = |line: &&str| line.starts_with("Usage:") || line.starts_with("For more information");
            let lines = text.lines().map(str::trim).take_while(|line| !is_end(line));
            let line = lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ");
            eprintln!("{line}; see `hypertexture --help`");
            return ExitCode::from(BAD_INPUT);
        }
    };
    match run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.is::<Interrupted>() => {
            eprintln!("{error}");
            ExitCode::from(INTERRUPTED)
        }
        #[cfg(feature = "viewer")]
        Err(error) if error.is::<NoWindow>() => {
            eprintln!("error: {}", error.to_string().replace('\n', " "));
            ExitCode::from(NO_WINDOW)
        }
        Err(error) if error.is::<Disagreement>() => {
            eprintln!("{error}");
            ExitCode::from(DISAGREES)
        }
        Err(error) => {
            eprintln!("error: {}", error.to_string().replace('\n', " "));
            ExitCode::from(if error.is::<Failed>() { FAILED } else { BAD_INPUT })
        }
    }
}

/// Runs the command that was asked for.
fn run(arguments: Arguments) -> Result<(), Box<dyn Error>> {
    log::start(arguments.quiet);
    let options = Options {
        device: arguments.device.filter(|name| !name.is_empty()),
        validation: std::env::var_os("HYPERTEXTURE_VALIDATION").is_some_and(|value| value == "1"),
        cache: crate::support::disk_cache::default_folder(),
    };
    let quiet = arguments.quiet;
    match arguments.command {
        Command::Render(command) => run_render(&command, &options, quiet),
        #[cfg(feature = "viewer")]
        Command::View(command) => view::run(*command, options),
        Command::Merge(command) => merge(&command, quiet),
        Command::Field(command) => write_field(&command, quiet),
        Command::Gallery(command) => write_gallery(&command, &options, quiet),
        Command::Compare(command) => compare::run(&command, &options, quiet),
        Command::Effects => list_effects(),
        Command::Verify(command) => verify::run(&command, &options, quiet),
        Command::Doctor => {
            let report = doctor::examine(&options);
            say(&report.text);
            if report.healthy { Ok(()) } else { Err("the tests above did not all pass".into()) }
        }
        Command::Completions(command) => {
            say(&manual::completions(command.shell));
            Ok(())
        }
        Command::Man(command) => {
            say(&manual::page(command.command.as_deref())?);
            Ok(())
        }
        Command::Draw => Ok(worker::serve(std::io::stdin().lock(), &mut std::io::stdout().lock(), &options)?),
        #[cfg(feature = "viewer")]
        Command::Compile(limits) => {
            compile::limit(limits.seconds, Some(limits.memory_mib))?;
            Ok(compile::serve(std::io::stdin().lock(), &mut std::io::stdout().lock())?)
        }
        #[cfg(feature = "viewer")]
        Command::Rays(limits) => {
            compile::limit(limits.seconds, None)?;
            Ok(rays::serve(std::io::stdin().lock(), &mut std::io::stdout().lock(), &options)?)
        }
    }
}

/// Writes to standard output; a closed pipe is no error.
pub fn say(text: &str) {
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
}

/// How workers are started: as this very program, on the same device.
pub fn start(options: &Options) -> Result<Start, Box<dyn Error>> {
    let program = std::env::current_exe()?;
    Ok(Start { program, device: options.device.clone(), patience: PATIENCE })
}

/// All that a picture is made of.
#[derive(Clone, Copy)]
struct Picture<'a> {
    gpu: &'a Gpu,
    library: &'a Library,
    scene: &'a Scene,
    subject: &'a Subject,
}

fn run_render(command: &Render, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let (mut scene, base) = command.arguments.scene_and_base(&command.input, &command.object)?;
    let library = scene.library()?;
    scene.check(&library)?;
    let bound = command.max_error.map(|error| ErrorBound::new(command.metric, error)).transpose()?;
    output::check(&command.output)?;
    command.save_scene.iter().try_for_each(|file| output::check_folder(file))?;
    let shard = command.shard.map(ShardChoice::shard).transpose()?;
    let sequence = command.motion.sequence()?;
    if let Some(sequence) = &sequence {
        sequence.scene(&scene, sequence.frames.last).check(&library)?;
    }
    let subject = with_progress(quiet, "distance field", |progress| Subject::load(&scene, &library, progress))?;
    let gpu = Gpu::new(options)?;
    let asked = scene.clone();
    if let Some(bound) = bound {
        let worker = Worker::new(&start(options)?, &library, Load::Scene(scene::to_text(&scene)));
        let worker = Some(&worker);
        let stage = Stage { gpu: &gpu, library: &library, subject: &subject, worker, stop: &|| false };
        let pick = with_progress(quiet, "fastest settings", |progress| remembered(stage, &scene, bound, progress))?;
        if !quiet {
            say(&explain(&pick, bound));
        }
        scene = pick.scene;
    }
    if !quiet {
        let line = command.ignored(&library, &subject, [&base, &asked, &scene]);
        say(&line.map_or(String::new(), |fields| format!("ignored    {fields}: the picture is the same without\n")));
    }
    let picture = Picture { gpu: &gpu, library: &library, scene: &scene, subject: &subject };
    if command.predict {
        let prediction = predict(&mut Renderer::new(&gpu, &library, &subject), &scene)?;
        say(&format_prediction(&scene, &prediction));
    } else if let Some(sequence) = &sequence {
        sequence::render_frames(command, &picture, sequence, shard, quiet)?;
    } else if let Some(shard) = shard {
        render_shard(command, &picture, shard, quiet)?;
    } else {
        render_picture(command, &picture, quiet)?;
    }
    if let Some(file) = &command.save_scene {
        write_whole(file, scene::to_text(&scene).as_bytes())
            .map_err(|error| format!("{}: {error}; nothing was written", file.display()))?;
    }
    Ok(())
}

fn render_picture(command: &Render, picture: &Picture<'_>, quiet: bool) -> Result<(), Box<dyn Error>> {
    let Picture { gpu, library, scene, subject } = *picture;
    let frame = with_progress(quiet, "noise", |progress| {
        Renderer::new(gpu, library, subject).with_progress(progress).render(scene)
    })?;
    let provenance = Provenance::of(scene, &gpu.info().title(), &frame.measurements.modules)?;
    output::write(&frame, scene.image.background, command.depth(), &provenance, &command.output)?;
    if !quiet {
        say(&summary(gpu, scene, subject, &frame));
        say(&format!("wrote {}\n", absolute(&command.output)));
    }
    Ok(())
}

fn render_shard(command: &Render, picture: &Picture<'_>, shard: Shard, quiet: bool) -> Result<(), Box<dyn Error>> {
    let Picture { gpu, library, scene, subject } = *picture;
    let bands = shard.bands(scene.image.size[1]);
    let frame = with_progress(quiet, "noise", |progress| {
        Renderer::new(gpu, library, subject).with_progress(progress).render_bands(scene, &bands)
    })?;
    let whole = shard::Whole {
        identity: shard::identity(scene, library, subject)?,
        size: scene.image.size,
        background: scene.image.background,
        depth: command.depth(),
        provenance: Provenance::of(scene, &gpu.info().title(), &frame.measurements.modules)?,
    };
    let path = shard.path(&command.output);
    write_whole(&path, &shard::encode(&whole, shard, &frame))
        .map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
    if !quiet {
        say(&summary(gpu, scene, subject, &frame));
        say(&format!("wrote {}\n", absolute(&path)));
    }
    Ok(())
}

fn merge(command: &Merge, quiet: bool) -> Result<(), Box<dyn Error>> {
    output::check(&command.output)?;
    let (frame, whole, others) = shard::merge(&command.shards)?;
    if !others.is_empty() {
        let all = &whole.provenance.device;
        ::log::warn!("the shards were rendered on several devices, which may round another way: {all}");
    }
    output::write(&frame, whole.background, whole.depth, &whole.provenance, &command.output)?;
    if !quiet {
        say(&format!("wrote {}\n", absolute(&command.output)));
    }
    Ok(())
}

/// A pick in words.
fn explain(pick: &Pick, bound: ErrorBound) -> String {
    let [left_out, drawn, kept] = pick.counts;
    let remembered = if pick.remembered { ", remembered" } else { "" };
    let mut text = format!("settings   {}{remembered}\n", pick.settings);
    text += &match (&pick.verified, &pick.unverified) {
        (Some(found), _) => format!(
            "error      {} {:.1e}, asked for {:.1e}; by the f64 reference (own error {:.0e}) in {} pixels\n",
            bound.metric, found.error, bound.error, found.estimate, found.pixels
        ),
        (None, why) => format!(
            "error      {} {:.1e}, asked for {:.1e}; by a finer picture: {}\n",
            bound.metric,
            pick.error,
            bound.error,
            why.as_deref().unwrap_or_default()
        ),
    };
    text += &format!(
        "why        the fastest of {kept} that fit, of {drawn} drawn small ({:.2} ms); {left_out} could not fit",
        pick.small_ms
    );
    let other =
        pick.other.as_ref().map(|(settings, ms)| format!("; {settings} takes {:.1}x", ms / pick.small_ms.max(1e-6)));
    text = text + &other.unwrap_or_default() + "\n";
    for Failure { label, message } in &pick.failures {
        text += &format!("failed     {label}: {message}\n");
    }
    text
}

/// A prediction in words.
fn format_prediction(scene: &Scene, prediction: &Prediction) -> String {
    let seconds = |ms: f64| format!("{:.2} s", ms * 1e-3);
    let time = |e: &Estimate| format!("{} ({} to {})", seconds(e.expected), seconds(e.low), seconds(e.high));
    let [width, height] = scene.image.size;
    let Prediction { probes, slices, .. } = prediction;
    let sizes = probes.chunk_by(|a, b| a.size == b.size);
    let sizes = sizes.map(|same| format!("{} of {} x {}", same.len(), same[0].size[0], same[0].size[1]));
    let millions = |count: f64| count * 1e-6;
    let count = match (scene.quality.pass, prediction.fragments) {
        (Pass::March, Some(rays)) => {
            let rays = millions(rays.expected);
            format!("rays       {rays:.2} M, {:.0} M samples at most", rays * f64::from(*slices))
        }
        (Pass::Slices, Some(Estimate { low, expected, high })) => {
            let [low, expected, high] = [low, expected, high].map(millions);
            format!("slices     {slices}, {expected:.1} M fragments ({low:.1} to {high:.1} M)")
        }
        (_, None) => format!("slices     {slices}; the device does not count fragments"),
    };
    format!(
        "probes     {}: {} in all\n{count}\ndevice     {} for {width} x {height}\n\
         expected   {} in all, without the distance field and the writing of the file\n",
        sizes.collect::<Vec<_>>().join(", "),
        seconds(prediction.spent_ms),
        time(&prediction.device_ms),
        time(&prediction.total_ms),
    )
}

/// What a render took, and what it left out.
fn summary(gpu: &Gpu, scene: &Scene, subject: &Subject, frame: &Frame) -> String {
    let info = gpu.info();
    let m = &frame.measurements;
    let mut lines = vec![
        format!("device     {} ({}, Vulkan {})", info.name, info.driver, info.api),
        format!("program    {}{}", m.modules, if m.shipped { "" } else { " (linked now)" }),
        format!("left out   {}", if m.left_out.is_empty() { "nothing".into() } else { m.left_out.join(", ") }),
    ];
    if let (Some(field), Some(report)) = (&subject.field, &subject.report) {
        let [x, y, z] = field.grid.size;
        let origin = if report.from_cache { "from the cache" } else { "computed" };
        lines.push(format!(
            "field      {x} x {y} x {z}, {origin} in {:.0} ms; {} triangles, {} open edges, {} closing; stored to {:.1e} object units",
            report.ms, report.triangles, report.open_edges, report.closing_triangles, m.quantization
        ));
    }
    if let Some([held, asked]) = m.octaves.filter(|[held, asked]| held < asked) {
        lines.push(format!("octaves    {held} of {asked}: {}", scene.octaves_limit()));
    }
    let fragments = m.fragments.map_or(String::new(), |count| format!(", {:.1} M fragments", count as f64 * 1e-6));
    lines.push(format!("slices     {} of thickness {:.5} object units{fragments}", m.slices, m.step));
    if let Some(radius) = m.held_beyond {
        lines.push(format!(
            "held       beyond {radius:.2} object units from the center a warp keeps its step: lobes are shorter than its formula"
        ));
    }
    if let Some(shadow_ms) = m.shadow_ms {
        lines.push(format!("shadows    {shadow_ms:.1} ms"));
    }
    lines.push(format!(
        "time       {:.1} ms on the device (longest submission {:.1} ms), {:.0} ms to compile, {:.0} ms in all",
        m.gpu_ms, m.longest_ms, m.compile_ms, m.total_ms
    ));
    if let Some(sparse) = m.sparse {
        let [bytes, dense] = [sparse.bytes, sparse.dense_bytes].map(|bytes| bytes as f64 / f64::from(1 << 20));
        let (stored, bricks) = (sparse.stored, sparse.bricks);
        lines.push(format!("bricks     {stored} of {bricks} stored: {bytes:.1} MiB in place of {dense:.1} MiB"));
    }
    lines.push(format!("memory     {:.1} MiB of images on the device\n", m.device_bytes as f64 / f64::from(1 << 20)));
    lines.join("\n")
}

fn write_field(command: &Field, quiet: bool) -> Result<(), Box<dyn Error>> {
    if !command.output.extension().is_some_and(|end| end.eq_ignore_ascii_case("nrrd")) {
        return Err(format!("{}: a field is written as NRRD; end the name in .nrrd", command.output.display()).into());
    }
    output::check_folder(&command.output)?;
    let mut object = Object { input: command.input.clone(), ..Object::default() };
    command.object.apply(&mut object)?;
    if !(0.0..=4.0).contains(&command.margin) {
        return Err(format!(
            "--margin {}: must be from 0 to 4 (1 is half of the object's longest side)",
            command.margin
        )
        .into());
    }
    let shape = open(&object)?;
    let request = request(&shape, &object, command.margin);
    let (field, report) =
        with_progress(quiet, "distance field", |progress| field::load_or_compute(&shape, &request, progress))?;
    let field = field.turned(object.up.turn());
    let mut bytes = Vec::new();
    shape::write_nrrd(&field.to_volume(), &mut bytes)?;
    write_whole(&command.output, &bytes)
        .map_err(|error| format!("{}: {error}; nothing was written", command.output.display()))?;
    if !quiet {
        let [x, y, z] = field.grid.size;
        let (low, high) = field.range();
        say(&format!(
            "field      {x} x {y} x {z}, spacing {:?}, distances {low:.4} to {high:.4} world units\n\
             exact      within {:.4} of the surface; a lower bound beyond\n\
             surface    {} triangles, {} open edges, {} closing; {:.0} ms\nwrote {}\n",
            field.grid.spacing.to_array(),
            request.band,
            report.triangles,
            report.open_edges,
            report.closing_triangles,
            report.ms,
            absolute(&command.output)
        ));
    }
    Ok(())
}

fn write_gallery(command: &Gallery, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let library = shader::shipped();
    let gpu = Gpu::new(options)?;
    // Smooth edges, where the device has them for the default target.
    let smooth = gpu.sample_counts(Format::Rgba32Float).contains(&4) && gpu.info().sample_shading;
    let mut scenes = match &command.input {
        Some(input) => gallery::effects(input)?,
        None => gallery::examples()?,
    };
    for (_, scene) in &mut scenes {
        scene.image.size = command.size;
        scene.quality.samples = command.samples.unwrap_or(scene.quality.samples);
        // Among many scenes only those are smoothed that have hard edges and are quick: it takes four times as long.
        let quick = scene.effect.softness == "hard" && scene.effect.warp.is_empty();
        let smooth = smooth && (command.input.is_some() || quick);
        scene.quality.msaa = if smooth { 4 } else { 1 };
        command.object.apply(&mut scene.object)?;
    }
    let (began, start) = (Instant::now(), start(options)?);
    let gallery::Gallery { page, failures } = with_progress(quiet, "gallery", |progress| {
        gallery::write(&gpu, &library, &scenes, Some(&start), &command.output, progress)
    })?;
    if !quiet {
        say(&format!(
            "rendered {} scenes in {:.1} s on {}\nwrote {}\n",
            scenes.len() - failures.len(),
            began.elapsed().as_secs_f64(),
            gpu.info().name,
            absolute(&page)
        ));
    }
    let count = failures.len();
    failures.into_iter().next().map_or(Ok(()), |(name, reason)| {
        Err(Failed::new(format!("{count} of {} scenes failed; the first, {name}: {reason}", scenes.len())).into())
    })
}

fn list_effects() -> Result<(), Box<dyn Error>> {
    let library = shader::shipped();
    let mut text = String::new();
    for name in scene::names() {
        let scene = scene::preset(name)?;
        text.push_str(&format!("{name}: {}\n", scene.about));
        let kinds = library.kinds(scene.dmfs())?;
        if !kinds.is_empty() {
            text.push_str(&format!("    {kinds}\n"));
        }
        for (name, parameter, value) in Variant::of(&scene, &library)?.all_parameters() {
            let value = match (value, parameter.kind) {
                (ParameterValue::Number(value), ParameterKind::Number(_, [low, high])) => {
                    format!("{value} in [{low}, {high}]")
                }
                (ParameterValue::Number(value), ParameterKind::Color(_)) => value.to_string(),
                (ParameterValue::Color(color), _) => String::from(*color),
            };
            text.push_str(&format!("    {name:<24} {value:<24} {}\n", parameter.doc));
        }
    }
    say(&text);
    Ok(())
}

/// Runs a computation; a bar appears on a terminal when it takes longer than a second.
fn with_progress<T>(quiet: bool, what: &'static str, run: impl FnOnce(field::Progress<'_>) -> T) -> T {
    const STEPS: u64 = 1000;
    let style = ProgressStyle::with_template("{msg} [{bar:40}] {percent} % {eta} left");
    let bar = ProgressBar::new(STEPS).with_message(what).with_style(style.expect("the template is valid"));
    let start = Instant::now();
    let result = run(&|fraction| {
        if fraction >= 1.0 {
            bar.finish_and_clear(); // what follows is something else
        } else if !quiet && start.elapsed() > Duration::from_secs(1) {
            bar.set_position((f64::from(fraction) * STEPS as f64) as u64);
        }
    });
    bar.finish_and_clear();
    result
}

fn absolute(path: &std::path::Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf()).display().to_string()
}
