//! `verify`: the truths on the device at hand, or a picture against its own scene.

use super::scene_arguments::reach;
use super::{announced, say, say_json};
use clap::Args;
use hypertexture::field::Progress;
use hypertexture::gpu::{Gpu, Options};
use hypertexture::output::{self, PROGRAM};
use hypertexture::render::{Subject, render};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use measure::reference::{Reference, ReferenceError, TOLERANCE, converged_settings, reference_pixels};
use measure::verify::{self, CheckError, CheckOptions, PixelTruth};
use serde_json::json;
use std::error::Error;
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Instant;
use support::words;

/// Arguments of `verify`.
#[derive(Args)]
pub struct Verify {
    /// A picture that this program has written: .png or .exr; without one, the device is verified.
    pub image: Option<PathBuf>,
    /// How many pixels of the picture are held against the truth.
    #[arg(long, default_value_t = 1000, requires = "image", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub pixels: u32,
    /// Which pixels.
    #[arg(long, default_value_t = 0, requires = "image")]
    pub seed: u64,
    /// The error of linear light that is allowed: rmse, or rgb over a background; without it, 0.1, and what `quality.early_termination` leaves out.
    #[arg(long, requires = "image", value_parser = bound)]
    pub bound: Option<f64>,
    /// Everything as JSON.
    #[arg(long)]
    pub json: bool,
    /// Let the picture name any file. Without this its files must be below its folder or the current one.
    #[arg(long, requires = "image")]
    pub outside: bool,
}

fn bound(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|bound| (0.0..=1.0).contains(bound)).ok_or_else(|| "must be from 0 to 1".into())
}

/// Something is not as it must be.
#[derive(Debug)]
pub struct Disagreement(String);

impl fmt::Display for Disagreement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Error for Disagreement {}

/// Verifies the device, or a picture.
pub fn run(command: &Verify, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    match &command.image {
        None => truths(options, command.json, quiet),
        Some(image) => picture(image, command, options, quiet),
    }
}

fn truths(options: &Options, json: bool, quiet: bool) -> Result<(), Box<dyn Error>> {
    let gpu = Gpu::new(options)?;
    let start = Instant::now();
    let report = announced(quiet, "truths", |progress| verify::run(&gpu, verify::TRUTHS, progress))?;
    let (missed, all) = (report.missed().map(verify::Row::failure).collect::<Vec<_>>(), report.rows.len());
    let (device, seconds) = (gpu.info().title(), start.elapsed().as_secs_f64());
    if json {
        say_json(&json!({
            "program": PROGRAM, "device": device, "holds": missed.is_empty(), "rows": report.rows, "seconds": seconds,
        }))?;
    } else if !quiet {
        let count = all - missed.len();
        say(&format!("{}{count} of {all} rows hold on {device}, in {seconds:.1} s\n", report.text()));
    }
    match missed.is_empty() {
        true => Ok(()),
        false => Err(Disagreement(format!("{} of {all} bounds missed: {}", missed.len(), missed.join("; "))).into()),
    }
}

fn picture(image: &Path, command: &Verify, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let provenance = output::read_provenance(image)?; // before a device is opened
    let reach = reach(command.outside);
    let scene = provenance.scene(image, reach)?;
    let library = super::library(&scene).map_err(|error| format!("{}: {error}", image.display()))?;
    super::try_modules(&scene, &library, Some(options))?;
    let gpu = Gpu::new(options)?;
    let asked = CheckOptions { pixels: command.pixels, seed: command.seed, bound: command.bound, reach };
    let known = |scene: &Scene, subject: &Subject, pixels: &[[u32; 2]], progress: Progress<'_>| {
        truth(&gpu, &library, scene, subject, pixels, progress)
    };
    let agreement =
        announced(quiet, "verifying", |progress| verify::check(&gpu, &library, image, &asked, progress, &known));
    let agreement = match agreement {
        Err(error @ CheckError::NotFinite { .. }) => Err(error.to_string()),
        agreement => Ok(agreement?),
    };
    let disagreement = match &agreement {
        Ok(agreement) => wrong(agreement).map(|wrong| format!("{}: {wrong}", image.display())),
        Err(error) => Some(error.clone()),
    };
    if command.json {
        let facts = agreement.as_ref().ok().map(|found| {
            json!({
                "is_of_scene": found.is_of_scene(), "is_accurate": found.is_accurate(), "same_device": found.same_device,
                "redrawn": { "pixels": found.redrawn[1], "changed": found.redrawn[0], "foreign": found.foreign },
                "truth": {
                    "source": found.source, "pixels": found.pixels, "proven": found.proven,
                    "known_by_samples": found.own[0], "known_by_proof": found.own[1],
                },
                "errors": found.errors, "metric": found.metric.to_string(), "error": found.error(), "bound": found.bound,
                "explained_by_codes": found.codes, "explained_by_step": found.step, "pixels_beyond": found.beyond,
            })
        });
        say_json(&json!({
            "picture": image.display().to_string(), "program": provenance.program, "device": provenance.device,
            "scene_hash": provenance.scene_hash, "disagreement": disagreement, "agreement": facts,
        }))?;
    } else if let Some(agreement) = agreement.ok().filter(|_| !quiet) {
        let hash = provenance.scene_hash.get(..16).unwrap_or(&provenance.scene_hash);
        let inputs: Vec<&str> = provenance.inputs.keys().map(String::as_str).collect();
        let inputs = if inputs.is_empty() { String::new() } else { format!("; unchanged: {}", inputs.join(", ")) };
        let about = format!("by {} on {}; scene {hash}{inputs}", provenance.program, provenance.device);
        say(&format!("picture    {}\n{}", words::line(&about), agreement.text()));
        if disagreement.is_none() {
            let (metric, error) = (agreement.metric, agreement.error());
            say(&format!("the picture is what its scene gives, and off by {metric} {error:.1e} from the truth\n"));
        }
    }
    disagreement.map_or(Ok(()), |line| Err(Disagreement(line).into()))
}

/// The fault of a picture that its scene or the truth contradicts.
fn wrong(agreement: &verify::Agreement) -> Option<String> {
    let verify::Agreement { redrawn: [changed, all], foreign, metric, bound, .. } = agreement;
    match (agreement.is_of_scene(), agreement.is_accurate()) {
        (true, true) => None,
        (false, _) => Some(format!(
            "this is not what its scene gives: {changed} of {all} pixels changed, {foreign} of them to what is not around them"
        )),
        (true, false) => Some(format!(
            "this is what its scene gives, and that is not accurate: off by {metric} {:.1e} from the truth where {bound:.1e} is \
             allowed",
            agreement.error()
        )),
    }
}

/// What knows the pixels of a scene: the f64 reference; where there is none, a second rendering.
fn truth(
    gpu: &Gpu,
    library: &Library,
    scene: &Scene,
    subject: &Subject,
    pixels: &[[u32; 2]],
    progress: Progress<'_>,
) -> Result<PixelTruth, Box<dyn Error>> {
    match reference_pixels(library, &converged_settings(scene), subject, pixels, TOLERANCE, progress, &|| false) {
        Ok(reference) => Ok(PixelTruth { reference, source: "the f64 reference" }),
        Err(ReferenceError::NoLimit(_) | ReferenceError::Exact(_)) => {
            let frame = render(gpu, library, scene, subject)?;
            let at = |[x, y]: &[u32; 2]| frame.pixels[(y * frame.size[0] + x) as usize].map(f64::from);
            let pixels: Vec<[f64; 4]> = pixels.iter().map(at).collect();
            let (size, estimate, open) = (frame.size, vec![0.0; pixels.len()], vec![1.0; pixels.len()]);
            let reference = Reference { size, pixels, estimate, open };
            Ok(PixelTruth { reference, source: "a second rendering" })
        }
        Err(error) => Err(error.into()),
    }
}
