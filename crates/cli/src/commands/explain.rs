//! `explain`: inputs and program of a picture, the work that its scene leaves out, reasons and savings.

use crate::arguments::{ObjectFlags, SceneArguments};
use crate::session::{CheckedScene, Outputs, Preparation, Prepared, say_fault};
use crate::terminal::{announced, say, say_json};
use clap::Args;
use hypertexture::field::Progress;
use hypertexture::gpu::{Gpu, Options};
use hypertexture::output::PROGRAM;
use hypertexture::render::variant::Variant;
use hypertexture::render::{Frame, RenderError, Renderer, describe_frame};
use hypertexture::scene::{EmptySpace, Pass, Scene};
use hypertexture::shader::slots::FOLDED;
use hypertexture_measure::statistics::{largest, quantile};
use hypertexture_support::words;
use serde::Serialize;
use serde_json::json;
use std::error::Error;

/// Pictures of each of two scenes that are compared.
const PICTURES: usize = 3;
/// Spread of undisturbed times, in parts of the least.
const STEADY_SPREAD: f64 = 0.5;

/// Arguments of `explain`.
#[derive(Args)]
pub(crate) struct Explain {
    /// An object, a scene file, an example scene, or a picture of this program.
    pub input: String,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// The scene.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

/// Draws the picture, and again without each saving.
pub(crate) fn run(command: &Explain, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let scene = CheckedScene::of(command.arguments.scene_and_base(&command.input, &command.object)?.still()?)?;
    let (input, outputs) = (command.input.as_str(), &Outputs::NONE);
    let preparation = Preparation { input, outputs, device: Some(options), serves_all_moments: false, quiet };
    let prepared = scene.prepare(&preparation)?;
    let gpu = Gpu::new(options)?;
    let explained = announced(quiet, "pictures", |progress| explain(&gpu, &prepared, progress))?;
    let Prepared { moving: scene, fault, .. } = prepared;
    if command.json {
        let fault = fault.map(|fault| fault.to_string());
        let made_with: Vec<_> =
            explained.made_with.iter().map(|[about, what]| json!({ "about": about, "what": what })).collect();
        return Ok(say_json(&json!({
            "program": PROGRAM, "device": gpu.info().title(), "scene": scene, "made_with": made_with, "times_ms": explained.times,
            "without": explained.others, "module": fault,
        }))?);
    }
    let Explained { made_with, times, others } = explained;
    let mut lines: Vec<String> = made_with.iter().map(|[a, b]| format!("{a:<11}{}", words::line(b))).collect();
    let memory = lines.pop();
    lines.push(format!("time       {} on the device, median of {}", spread(&times), times.len()));
    lines.extend(others.iter().map(Other::line));
    lines.extend(memory);
    say(&(lines.join("\n") + "\n"));
    say_fault(fault);
    Ok(())
}

/// Parts of a picture, and its time beside the time without each saving.
struct Explained {
    made_with: Vec<[String; 2]>,
    /// Milliseconds on the device.
    times: Vec<f64>,
    others: Vec<Other>,
}

/// A picture without one saving, compared with the scene's.
#[derive(Serialize)]
struct Other {
    how: &'static str,
    #[serde(skip)]
    saves: &'static str,
    /// Milliseconds on the device, and those of the scene, drawn alternately.
    times_ms: Vec<f64>,
    scene_times_ms: Vec<f64>,
    /// Largest difference of a channel.
    difference: f64,
}

impl Other {
    fn line(&self) -> String {
        let error = match self.difference {
            0.0 => "no pixel differs".into(),
            most => format!("pixels differ by {most:.1e} at most"),
        };
        let saved = saved(self.saves, &self.scene_times_ms, &self.times_ms);
        format!("           {} {}: {saved}, {error}", spread(&self.times_ms), self.how)
    }
}

fn explain(gpu: &Gpu, prepared: &Prepared, progress: Progress<'_>) -> Result<Explained, Box<dyn Error>> {
    let Prepared { library, variant, subject, .. } = prepared;
    let warm = |scene: &Variant| -> Result<(Renderer, Frame), RenderError> {
        let mut renderer = Renderer::new(gpu, library, subject);
        // The second one: slices leave out empty space from there on.
        renderer.render(scene)?;
        let frame = renderer.render(scene)?;
        Ok((renderer, frame))
    };
    progress(0.0);
    let (mut renderer, frame) = warm(variant)?;
    let made_with = describe_frame(&frame.measurements, variant, subject, library);
    let (mut times, mut others) = (Vec::new(), Vec::new());
    let has_zeros = variant.slots.contains_key(FOLDED);
    let mores = without(&variant.scene);
    let share = 1.0 / mores.len() as f32;
    for (index, More { how, saves, change }) in mores.into_iter().enumerate() {
        progress(share * index as f32);
        let mut other = variant.scene.clone();
        change(&mut other);
        if other == variant.scene || !other.quality.fold_zero_terms && !has_zeros {
            continue;
        }
        let Ok(other) = Variant::of(&other, library) else { continue };
        let (mut fuller, full) = warm(&other)?;
        let differences =
            frame.pixels.as_flattened().iter().zip(full.pixels.as_flattened()).map(|(a, b)| f64::from((a - b).abs()));
        // Alternately: other load of the machine slows both down.
        let [scene_times_ms, times_ms] = by_turns([(&mut renderer, variant), (&mut fuller, &other)])?;
        times.extend(scene_times_ms.iter());
        others.push(Other { how, saves, times_ms, scene_times_ms, difference: largest(differences) });
    }
    if times.is_empty() {
        [times] = by_turns([(&mut renderer, variant)])?;
    }
    Ok(Explained { made_with, times, others })
}

fn median(times: &[f64]) -> f64 {
    quantile(times.to_vec(), 0.5)
}

/// The least and the greatest of some times.
fn ends(times: &[f64]) -> [f64; 2] {
    [0.0, 1.0].map(|share| quantile(times.to_vec(), share))
}

/// Times of the pictures of some scenes, drawn alternately.
fn by_turns<const N: usize>(mut scenes: [(&mut Renderer, &Variant); N]) -> Result<[Vec<f64>; N], RenderError> {
    let mut times = [const { Vec::new() }; N];
    for _ in 0..PICTURES {
        for ((renderer, scene), times) in scenes.iter_mut().zip(&mut times) {
            times.push(renderer.render(*scene)?.measurements.alone_ms());
        }
    }
    Ok(times)
}

/// Range of the time that one picture saves, or takes, against another, in words.
fn saved(saves: &str, times: &[f64], others: &[f64]) -> String {
    let ([least, most], [least_other, most_other]) = (ends(times), ends(others));
    let apart = (least_other - most).max(least - most_other);
    let spread = (most - least).max(most_other - least_other);
    if apart > spread {
        let interval = |ends: [f64; 2]| {
            let [low, high] = ends.map(|part| format!("{:.0}", 100.0 * part));
            if low == high { low } else { format!("{low} to {high}") }
        };
        if least > most_other {
            let (subject, verb) = saves.rsplit_once(' ').unwrap_or((saves, ""));
            let takes = if verb == "save" { "take" } else { "takes" };
            let more = interval([least / most_other - 1.0, most / least_other - 1.0]);
            return format!("{subject} {takes} {more} % longer");
        }
        return format!("{saves} {} %", interval([1.0 - most / least_other, 1.0 - least / most_other]));
    }
    if spread <= STEADY_SPREAD * least.min(least_other) {
        format!("{saves} nothing beyond the spread")
    } else {
        format!("{saves} an amount that cannot be measured now, as something else slows the device down")
    }
}

/// Median and range of times.
fn spread(times: &[f64]) -> String {
    let [least, most] = ends(times);
    format!("{:.1} ms ({least:.1} to {most:.1})", median(times))
}

/// A scene without one saving.
struct More {
    /// The change.
    how: &'static str,
    /// The saving of the scene.
    saves: &'static str,
    change: fn(&mut Scene),
}

/// The scene without each of its savings.
fn without(scene: &Scene) -> [More; 4] {
    [
        More {
            how: "with every sample (--empty-space sample)",
            saves: "skipping saves",
            change: |scene| scene.quality.empty_space = EmptySpace::Sample,
        },
        More {
            how: "with the terms that a 0 takes away (--set quality.fold_zero_terms=false)",
            saves: "leaving them out saves",
            change: |scene| scene.quality.fold_zero_terms = false,
        },
        More {
            how: "to the end of every ray (--set quality.early_termination=0)",
            saves: "ending early saves",
            change: |scene| scene.quality.early_termination = 0.0,
        },
        match scene.quality.pass {
            Pass::March => More {
                how: "by slices (--pass slices)",
                saves: "rays save",
                change: |scene| scene.quality.pass = Pass::Slices,
            },
            Pass::Slices => More {
                how: "by rays (--pass march)",
                saves: "slices save",
                change: |scene| scene.quality.pass = Pass::March,
            },
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::saved;

    #[test]
    fn savings_are_intervals_if_the_times_do_not_overlap() {
        for (times, others, said) in [
            ([9.0, 10.0, 11.0], [18.0, 20.0, 20.0], "39 to 55 %"),
            ([10.0; 3], [20.0; 3], "50 %"),
            ([9.0, 10.0, 11.0], [10.5, 12.0, 13.0], "nothing beyond the spread"),
            // Overlapping spreads: a chance of one in ten.
            ([9.0, 10.0, 11.0], [11.5, 12.0, 12.5], "nothing beyond the spread"),
            ([9.0, 10.0, 30.0], [19.0, 20.0, 40.0], "an amount that cannot be measured now"),
            ([40.0, 95.0, 110.0], [30.0, 35.0, 38.0], "an amount that cannot be measured now"),
        ] {
            let found = saved("it saves", &times, &others);
            assert!(found.starts_with(&format!("it saves {said}")), "{times:?}, {others:?}: {found}");
        }
        let slower = ([18.0, 20.0, 20.0], [9.0, 10.0, 11.0]);
        assert_eq!(saved("rays save", &slower.0, &slower.1), "rays take 64 to 122 % longer");
        assert_eq!(saved("skipping saves", &slower.0, &slower.1), "skipping takes 64 to 122 % longer");
    }
}
