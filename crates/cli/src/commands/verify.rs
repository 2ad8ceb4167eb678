//! `verify`: analytic cases on the device at hand, or a picture compared with its scene.

use super::stress::conclude;
use crate::arguments::reach;
use crate::session::{Failed, checked, say_fault, try_in_sandbox};
use crate::terminal::{announced, say, say_json};
use clap::Args;
use hypertexture::field::Progress;
use hypertexture::gpu::{Gpu, Options};
use hypertexture::output::{self, PROGRAM};
use hypertexture::render::{Subject, eye_inside, find_module_fault, render};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use hypertexture_measure::cases::{self, Suite};
use hypertexture_measure::guard::own_files;
use hypertexture_measure::picture_check::{self, CheckError, CheckOptions, PixelTruth, Verdict};
use hypertexture_measure::reference::{Reference, ReferenceError, TOLERANCE, converged_settings, reference_pixels};
use hypertexture_support::words;
use serde_json::json;
use std::cell::RefCell;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `verify`.
#[derive(Args)]
pub struct Verify {
    /// A picture written by this program, .png or .exr; without one, the device is verified.
    pub image: Option<PathBuf>,
    /// Number of pixels that are compared with the ground truth.
    #[arg(long, default_value_t = 1000, requires = "image", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub pixels: u32,
    /// Seed of the choice of pixels.
    #[arg(long, default_value_t = 0, requires = "image")]
    pub seed: u64,
    /// Largest error of linear light: rmse, or rgb over a background.
    ///
    /// Without it, 0.1 plus `quality.early_termination`.
    #[arg(long, requires = "image", value_parser = bound)]
    pub bound: Option<f64>,
    /// Prints one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Lets the picture name any file.
    ///
    /// Without this, its files must be below its folder or the current one.
    #[arg(long, requires = "image")]
    pub outside: bool,
}

fn bound(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|bound| (0.0..=1.0).contains(bound)).ok_or_else(|| "must be from 0 to 1".into())
}

/// Verifies the device, or a picture.
pub fn run(command: &Verify, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    match &command.image {
        None => device(options, command.json, quiet),
        Some(image) => picture(image, command, options, quiet),
    }
}

fn device(options: &Options, json: bool, quiet: bool) -> Result<(), Box<dyn Error>> {
    let gpus = cases::devices(Gpu::new(options)?, options)?;
    let gpu = &gpus[0];
    let start = Instant::now();
    let chosen: Vec<cases::Case> = cases::suite(Suite::Verify).collect();
    let report = announced(quiet, "cases", |progress| cases::run(&gpus, &cases::library(), &chosen, progress))?;
    if json {
        let (holds, seconds) = (report.failed().next().is_none(), start.elapsed().as_secs_f64());
        say_json(&json!({
            "program": PROGRAM, "device": gpu.info().title(), "holds": holds, "rows": report.rows, "seconds": seconds,
        }))?;
    }
    conclude(&report, gpu, quiet || json)
}

fn picture(image: &Path, command: &Verify, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let provenance = output::read_provenance(image)?; // before a device is opened
    let reach = reach(command.outside);
    let scene = provenance.scene(image, reach)?;
    let (variant, library) = checked(&scene).map_err(|error| format!("{}: {error}", image.display()))?;
    try_in_sandbox(&variant, &library, Some(options))?;
    // Picture and reference may share a fault of a module.
    let module = if own_files(&variant, &library)?.is_empty() {
        None
    } else {
        find_module_fault(&library, &variant, &Subject::load(&variant, &library, &|_| ())?)?
    };
    let gpu = Gpu::new(options)?;
    let asked = CheckOptions { pixels: command.pixels, seed: command.seed, bound: command.bound, reach };
    let inside = RefCell::new(None);
    let known = |scene: &Scene, subject: &Subject, pixels: &[[u32; 2]], progress: Progress<'_>| {
        *inside.borrow_mut() = eye_inside(&variant, subject, &library);
        truth(&gpu, &library, scene, subject, pixels, progress)
    };
    let verdict =
        announced(quiet, "verifying", |progress| picture_check::check(&gpu, &library, image, &asked, progress, &known));
    let verdict = match verdict {
        Err(error @ CheckError::NotFinite { .. }) => Err(error.to_string()),
        verdict => Ok(verdict?),
    };
    let inside: Option<String> = inside.into_inner();
    let disagreement = match &verdict {
        Ok(verdict) => fault(verdict).map(|wrong| format!("{}: {wrong}", image.display())),
        Err(error) => Some(error.clone()),
    };
    if command.json {
        let facts = verdict.as_ref().ok().map(|found| {
            json!({
                "is_of_scene": found.is_of_scene(), "is_accurate": found.is_accurate(), "same_device": found.same_device,
                "redrawn": { "pixels": found.rerendered[1], "changed": found.rerendered[0], "foreign": found.foreign },
                "truth": {
                    "source": found.source, "pixels": found.pixels, "proven": found.proven,
                    "known_by_samples": found.truth_error[0], "known_by_proof": found.truth_error[1],
                },
                "errors": found.errors, "metric": found.metric.to_string(), "error": found.error(), "bound": found.bound,
                "explained_by_codes": found.codes, "explained_by_step": found.step, "pixels_beyond": found.beyond,
            })
        });
        say_json(&json!({
            "picture": image.display().to_string(), "program": provenance.program, "device": provenance.device,
            "scene_hash": provenance.scene_hash, "disagreement": disagreement, "agreement": facts,
            "module": module.map(|fault| fault.to_string()), "notes": inside.iter().collect::<Vec<_>>(),
        }))?;
    } else if let Some(verdict) = verdict.ok().filter(|_| !quiet) {
        let hash = provenance.scene_hash.get(..16).unwrap_or(&provenance.scene_hash);
        let inputs: Vec<&str> = provenance.inputs.keys().map(String::as_str).collect();
        let inputs = if inputs.is_empty() { String::new() } else { format!("; unchanged: {}", inputs.join(", ")) };
        let about = format!("by {} on {}; scene {hash}{inputs}", provenance.program, provenance.device);
        say(&format!("picture    {}\n{}", words::line(&about), verdict.text()));
        if let Some(line) = inside {
            say(&format!("note       {line}\n"));
        }
        say_fault(module);
        if disagreement.is_none() {
            let (metric, error) = (verdict.metric, verdict.error());
            say(&format!("its scene gives this picture, with an error of {metric} {error:.1e}\n"));
        }
    }
    disagreement.map_or(Ok(()), |line| Err(Failed(line).into()))
}

/// The fault of a picture, if any.
fn fault(verdict: &Verdict) -> Option<String> {
    let Verdict { rerendered: [changed, all], foreign, metric, bound, .. } = verdict;
    match (verdict.is_of_scene(), verdict.is_accurate()) {
        (true, true) => None,
        (false, _) => Some(format!(
            "its scene gives another picture: {changed} of {all} pixels changed, {foreign} of them beyond the values around them"
        )),
        (true, false) => Some(format!(
            "its scene gives this picture, but it is not accurate: an error of {metric} {:.1e}, above the bound of {bound:.1e}",
            verdict.error()
        )),
    }
}

/// Ground truth of pixels: the f64 reference, or a second rendering in its place.
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
