//! `render`: a picture, its frames or a shard of them, with the fastest settings or with its cost in advance.

mod depth_map;
mod error_map;
pub(crate) mod picture;
mod sequence;
mod validity;

use crate::arguments::{Motion, ObjectFlags, SceneArguments, ShardChoice, frames_of, metric, shard};
use crate::session::{CheckedScene, Outputs, Preparation, Prepared, fault_line, start, with_device};
use crate::terminal::{absolute, announced, aside, say, say_json, silent};
use clap::Args;
use depth_map::write_depth_map;
use error_map::write_error_map;
use hypertexture::gpu::{Gpu, Options};
use hypertexture::output::sequence::{Sequence, manifest_path};
use hypertexture::output::shard::Shard;
use hypertexture::output::{self, PROGRAM};
use hypertexture::render::variant::Variant;
use hypertexture::render::{Renderer, check_depth, unused_overrides};
use hypertexture::scene::{self, Pass, Scene};
use hypertexture_measure::compare::{Failure, Session};
use hypertexture_measure::guard::edited;
use hypertexture_measure::metric::Metric;
use hypertexture_measure::pick::{ErrorBound, Pick, Verified, remembered};
use hypertexture_measure::predict::{Estimate, Prediction, predict};
use hypertexture_measure::statistics::rounded_up;
use hypertexture_measure::worker::{Load, Worker};
use hypertexture_support::write_whole;
use picture::{Picture, STANDARD_OUTPUT, render_picture, render_shard};
use sequence::render_frames;
use serde_json::{Map, Value, json};
use std::borrow::Cow;
use std::error::Error;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use validity::write_validity;

/// Arguments of `render`.
#[derive(Args)]
pub struct Render {
    /// An object, a scene file (.toml), an example scene such as fire_ball, or a picture.
    ///
    /// An object is built in, a mesh, a scalar volume or a distance field; a picture of this program holds its scene.
    pub input: String,
    /// Output, .png or .exr.
    ///
    /// With --frames also .webp, .gif or .apng, of PNG files beside it. - is standard output, as PNG.
    #[arg(long, short, default_value = "out.png", value_name = "FILE")]
    pub output: PathBuf,
    /// Bits of each channel of a PNG.
    #[arg(long, default_value = "8", value_parser = ["8", "16"], hide_short_help = true)]
    pub depth: String,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Write the scene in use, complete with defaults.
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    pub save_scene: Option<PathBuf>,
    /// Predict the cost from smaller pictures, without writing a file.
    #[arg(long, conflicts_with_all = ["frames", "shard"])]
    pub predict: bool,
    /// Draw with the fastest settings within this error, such as 1e-3.
    ///
    /// They replace the scene's settings for accuracy.
    #[arg(long, value_name = "ERROR", conflicts_with = "shard")]
    pub max_error: Option<f64>,
    /// Metric of --max-error: rmse (linear RGBA), covered (rmse of covered pixels), rgb, opacity, max, p999.
    #[arg(long, default_value = "rmse", value_parser = metric, requires = "max_error", hide_short_help = true)]
    pub metric: Metric,
    /// Write the error of each pixel against the f64 reference: .exr (absolute error of premultiplied linear RGBA, `estimate`, the
    /// estimated error of the reference, and `open`, opacity that its samples may have overlooked) or .png (colors, from 1e-5 to 1).
    #[arg(long, value_name = "FILE", conflicts_with_all = ["frames", "shard", "predict"], hide_short_help = true)]
    pub error_map: Option<PathBuf>,
    /// Write doubtful pixels in the color of their cause, as .png: pixels that change when samples, parts of a pixel, voxels or formats
    /// improve, and pixels that the bounds of the f64 reference leave open.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["frames", "shard", "predict"], hide_short_help = true)]
    pub validity: Option<PathBuf>,
    /// Write the depth of each pixel as .exr: channel `Z` is the distance from the eye along the axis of view, in object
    /// units, at which a ray through the middle of the pixel meets an opacity of 1/2, infinite where it meets less.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["frames", "shard", "predict"], hide_short_help = true)]
    pub depth_map: Option<PathBuf>,
    /// Render part K, from 0 to N - 1, of a picture or of the frames; without a value, the part that Slurm or
    /// Kubernetes gives to this process.
    #[arg(long, value_name = "K/N", num_args = 0..=1, default_missing_value = "auto", value_parser = shard, hide_short_help = true)]
    pub shard: Option<ShardChoice>,
    /// Frames.
    #[command(flatten)]
    pub motion: Motion,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// The scene.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

impl Render {
    /// Options without effect on the scene `drawn`, separated by commas, if any. `--max-error` may have changed that scene.
    fn ignored(&self, prepared: &Prepared, drawn: &Variant) -> Option<String> {
        let Prepared { base, library, subject, variant: asked, .. } = prepared;
        let (before, after) = (base.fields(), drawn.scene.fields());
        let set: Vec<_> = asked.scene.fields().into_iter().filter(|field| !before.contains(field)).collect();
        let said = |(name, value): &(String, toml::Value)| format!("{name} = {value}");
        let replaced = set.iter().filter(|field| !after.contains(field));
        let mut all: Vec<String> = replaced.map(|field| format!("{} (--max-error chooses)", said(field))).collect();
        // A picture has no motion; a loop changes the noise of one all the same.
        let is_still = self.motion.times.frames.is_none();
        let moves =
            |(name, _): &&(String, _)| name.starts_with("animation.") && !(is_still && name == "animation.loop");
        let own: Vec<String> = set.iter().filter(|field| !moves(field)).map(said).collect();
        all.extend(unused_overrides(library, subject, base, drawn).into_iter().filter(|field| own.contains(field)));
        if self.depth != "8" && (ends(&self.output, "exr") || self.predict) {
            all.push(format!("--depth {}", self.depth));
        }
        if self.predict && self.output != Path::new("out.png") {
            all.push(format!("--output {}", self.output.display()));
        }
        (!all.is_empty()).then(|| all.join(", "))
    }

    /// Whether the picture goes to standard output.
    fn is_piped(&self) -> bool {
        self.output == Path::new(STANDARD_OUTPUT)
    }

    /// Refuses options and terminals that exclude a picture on standard output.
    fn check_piped(&self) -> Result<(), String> {
        let also = [
            ("--frames", self.motion.times.frames.is_some()),
            ("--shard", self.shard.is_some()),
            ("--json", self.json),
        ];
        let also = also.into_iter().find_map(|(flag, is_given)| is_given.then_some(flag));
        match also {
            _ if !self.is_piped() || self.predict => Ok(()),
            Some(flag) => Err(format!("--output -: standard output has one picture, and nothing for {flag}; name a file")),
            None if std::io::stdout().is_terminal() => {
                Err("--output -: standard output is a terminal, which shows no picture; name a file, or put a | or > behind".into())
            }
            None => Ok(()),
        }
    }

    /// Output files, and the options that name them.
    fn written(
        &self,
        shard: Option<Shard>,
        sequence: Option<&Sequence>,
    ) -> Result<Vec<(&'static str, PathBuf)>, Box<dyn Error>> {
        let pictures = match (sequence, shard) {
            _ if self.predict => Vec::new(),
            (Some(sequence), _) => {
                let pattern = self.motion.pattern(&self.output);
                let frames = frames_of(&pattern, sequence, shard)?.into_iter().map(|(_, path)| path);
                frames.chain([manifest_path(&pattern, shard)]).chain(self.motion.joined(&self.output)).collect()
            }
            (None, Some(shard)) => vec![shard.path(&self.output)],
            (None, None) if self.is_piped() => Vec::new(),
            (None, None) => vec![self.output.clone()],
        };
        let maps = [("--error-map", &self.error_map), ("--validity", &self.validity), ("--depth-map", &self.depth_map)];
        let more = [("--save-scene", &self.save_scene)]
            .into_iter()
            .chain(maps)
            .filter_map(|(flag, file)| Some((flag, file.clone()?)));
        Ok(pictures.into_iter().map(|path| ("--output", path)).chain(more).collect())
    }
}

/// Whether a file name has this extension.
fn ends(path: &Path, end: &str) -> bool {
    path.extension().is_some_and(|own| own.eq_ignore_ascii_case(end))
}

/// Renders, or predicts the cost.
pub(crate) fn run(command: &Render, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let scene = command.arguments.scene_and_base(&command.input, &command.object)?;
    let scene = if command.max_error.is_none() { scene.smooth() } else { scene };
    render(command, options, quiet, CheckedScene::of(scene)?)
}

/// Renders a checked scene, or predicts its cost.
pub(crate) fn render(
    command: &Render,
    options: &Options,
    quiet: bool,
    scene: CheckedScene,
) -> Result<(), Box<dyn Error>> {
    let plan = Plan::of(command, &scene)?;
    let (input, outputs) = (command.input.as_str(), &plan.outputs);
    let preparation = Preparation { input, outputs, device: Some(options), serves_all_moments: false, quiet };
    let prepared = scene.prepare(&preparation)?;
    let tell: fn(&str) = if quiet || command.json {
        silent
    } else if command.is_piped() && !command.predict {
        aside
    } else {
        say
    };
    let mut object =
        with_device(options, |gpu| draw(command, &plan, &prepared, gpu, options, Console { quiet, tell }))?;
    let fault = prepared.fault.as_ref();
    tell(&fault_line(fault));
    if command.json {
        object.insert("module".into(), json!(fault.map(|fault| fault.to_string())));
        say_json(&object)?;
    }
    Ok(())
}

/// Options of a command after their checks.
struct Plan {
    bound: Option<ErrorBound>,
    shard: Option<Shard>,
    sequence: Option<Sequence>,
    outputs: Outputs,
}

impl Plan {
    /// Checks the options of a command for its scene.
    fn of(command: &Render, scene: &CheckedScene) -> Result<Plan, Box<dyn Error>> {
        let CheckedScene { moving, variant: Variant { scene, .. }, library, .. } = scene;
        let bound = command.max_error.map(|error| ErrorBound::new(command.metric, error)).transpose();
        let bound = bound.map_err(|error| format!("--max-error: {error}"))?;
        command.check_piped()?;
        let shard = command.shard.map(ShardChoice::shard).transpose()?;
        command.motion.check(&command.output, scene.image.size, shard)?;
        let maps = [&command.error_map, &command.validity, &command.depth_map].map(Option::as_ref);
        let pattern = command.motion.pattern(&command.output);
        let files = [Some(&pattern).filter(|_| !command.is_piped())].into_iter().chain(maps);
        files.flatten().try_for_each(|file| output::check(file))?;
        if let Some(file) = command.validity.as_ref().filter(|file| !ends(file, "png")) {
            return Err(format!("--validity {}: its colors are words; write .png", file.display()).into());
        }
        if let Some(file) = command.depth_map.as_ref().filter(|file| !ends(file, "exr")) {
            return Err(format!("--depth-map {}: a color file cannot store a depth; write .exr", file.display()).into());
        }
        if command.depth_map.is_some() {
            check_depth(scene, library)?;
        }
        let sequence = command.motion.sequence()?;
        if let Some(sequence) = &sequence {
            sequence.scene(moving, sequence.frames.last).check(library)?;
        }
        let outputs = Outputs::Files(command.written(shard, sequence.as_ref())?);
        Ok(Plan { bound, shard, sequence, outputs })
    }
}

/// Messages of a command.
#[derive(Clone, Copy)]
struct Console {
    quiet: bool,
    /// Writes a message to the stream that carries no picture.
    tell: fn(&str),
}

/// Draws the picture or predicts its cost. Result: measurements as JSON.
fn draw(
    command: &Render,
    plan: &Plan,
    prepared: &Prepared,
    gpu: &Gpu,
    options: &Options,
    console: Console,
) -> Result<Map<String, Value>, Box<dyn Error>> {
    let Console { quiet, tell } = console;
    let Plan { bound, shard, sequence, outputs } = plan;
    let Prepared { moving, library, subject, .. } = prepared;
    let (mut variant, mut drawn) = (Cow::Borrowed(&prepared.variant), None);
    let mut object = Map::from_iter([("program".into(), json!(PROGRAM)), ("device".into(), json!(gpu.info().title()))]);
    let mut add = |name: &str, value: Value| drop(object.insert(name.into(), value));
    if let Some(bound) = *bound {
        let worker = Worker::new(&start(options)?, library, Load::Scene(scene::to_text(&variant.scene)));
        let session = Session { gpu, library, subject, worker: Some(&worker), stop: &|| false };
        let pick = announced(quiet, "fastest settings", |progress| {
            remembered(session, &prepared.variant.scene, bound, progress)
        })?;
        tell(&explain(&pick, bound));
        add("settings", settings(&pick, bound));
        (variant, drawn) = (Cow::Owned(Variant::of(&pick.scene, library)?), pick.picture);
    }
    let variant = &*variant;
    let Scene { effect, quality, .. } = variant.scene.clone();
    let moving = if bound.is_some() { Scene { effect, quality, ..moving.clone() } } else { moving.clone() };
    if !quiet || command.json {
        let fields = command.ignored(prepared, variant);
        let line = |fields: &String| format!("ignored    {fields}: the picture is the same without\n");
        tell(&fields.as_ref().map_or(String::new(), line));
        add("ignored", json!(fields));
    }
    let pattern = command.motion.pattern(&command.output);
    let (output, depth) = (&*pattern, &*command.depth);
    let edited = &edited(variant, library)?;
    let picture = Picture { gpu, prepared, variant, edited, output, depth, quiet, tell };
    if command.predict {
        let prediction = predict(&mut Renderer::new(gpu, library, subject), &variant.scene)?;
        if !command.json {
            say(&format_prediction(&variant.scene, &prediction)); // all that was asked for: said where it is to be quiet, too
        }
        add("prediction", json!(prediction));
    } else if let Some(sequence) = sequence {
        add("frames", render_frames(&picture, &moving, sequence, *shard, command.motion.restart)?);
        for file in command.motion.join(&command.output, sequence, &moving)? {
            tell(&format!("wrote {}\n", absolute(&file)));
        }
    } else {
        let frame = match *shard {
            Some(shard) => render_shard(&picture, shard)?,
            None => render_picture(&picture, drawn)?,
        };
        if let Some(path) = &command.error_map {
            add("error_map", write_error_map(&picture, &frame, path)?);
        }
        if let Some(path) = &command.validity {
            add("validity", write_validity(&picture, &frame, path)?);
        }
        if let Some(path) = &command.depth_map {
            add("depth_map", write_depth_map(&picture, path)?);
        }
        if command.json {
            picture::object(&picture, &frame)?.into_iter().for_each(|(name, value)| add(&name, value));
        }
    }
    if let Some(file) = &command.save_scene {
        write_whole(file, scene::to_text(&moving).as_bytes())
            .map_err(|error| format!("{}: {error}; nothing was written", file.display()))?;
    }
    add("wrote", outputs.files().map(absolute).collect());
    Ok(object)
}

/// A pick as JSON.
fn settings(pick: &Pick, bound: ErrorBound) -> Value {
    let failures = pick.failures.iter().map(|Failure { label, message }| json!({ "label": label, "message": message }));
    let [left_out, drawn, kept, untried] = pick.counts;
    json!({
        "settings": pick.settings, "metric": bound.metric.to_string(), "asked": bound.error, "verified": pick.verified,
        "unverified": pick.unverified, "remembered": pick.remembered, "other": pick.other, "left_out": left_out, "drawn": drawn,
        "kept": kept, "untried": untried, "failures": failures.collect::<Vec<_>>(),
    })
}

/// Summary of a pick.
fn explain(pick: &Pick, bound: ErrorBound) -> String {
    let [left_out, drawn, kept, untried] = pick.counts;
    let remembered = if pick.remembered { ", remembered" } else { "" };
    let mut text = format!("settings   {}{remembered}\n", pick.settings);
    let Verified { error, found, estimate, open, pixels: [pixels, proven], ms } = pick.verified;
    let all = pick.scene.image.size.iter().map(|side| u64::from(*side)).product::<u64>();
    let by = match &pick.unverified {
        None => format!(
            "{found:.1e} by the f64 reference in {pixels} of {all} pixels (estimated error of the reference {estimate:.0e}; \
             proven bound {open:.0e}, {proven} of them fully proven)"
        ),
        Some(why) => format!("by a finer picture (own error {estimate:.0e}): {why}"),
    };
    let below = rounded_up(error).min(bound.error);
    // Matter that no sample of the reference met is in the figure by proof alone.
    let beyond = if pick.unverified.is_none() && pick.verified.by_proof() > bound.error {
        format!(
            " of what samples meet, and {:.1e} with all that bounds leave open",
            rounded_up(pick.verified.by_proof())
        )
    } else {
        String::new()
    };
    text += &format!("error      {} at most {below:e}{beyond}, asked for {:e}; {by}\n", bound.metric, bound.error);
    text += &format!(
        "why        {ms:.1} ms; the fastest of {kept} that should fit, of {drawn} drawn small; {left_out} could not fit"
    );
    if untried > 0 {
        text += &format!("; {untried} other ways were not tried, to be done in time");
    }
    let other = pick.other.as_ref().map(|(settings, times)| format!("; {settings} takes {times:.1}x"));
    text = text + &other.unwrap_or_default() + "\n";
    for Failure { label, message } in &pick.failures {
        text += &format!("failed     {label}: {message}\n");
    }
    text
}

/// Summary of a prediction.
fn format_prediction(scene: &Scene, prediction: &Prediction) -> String {
    let seconds = |ms: f64| format!("{:.2} s", ms * 1e-3);
    let time = |e: &Estimate| format!("{} ({} to {})", seconds(e.expected), seconds(e.low), seconds(e.high));
    let [width, height] = scene.image.size;
    let Prediction { probe, slices, .. } = prediction;
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
        (Pass::March, None) => format!("rays       of at most {slices} samples; the device does not count them"),
        (Pass::Slices, None) => format!("slices     {slices}; the device does not count fragments"),
    };
    format!(
        "probes     up to {} x {}: {} in all\n{count}\ndevice     {} for {width} x {height}\n\
         expected   {} in all, without the distance field and the writing of the file\n",
        probe[0],
        probe[1],
        seconds(prediction.spent_ms),
        time(&prediction.device_ms),
        time(&prediction.total_ms),
    )
}
