//! `explain`: what a picture is made with, what its scene leaves out and why, and what that saves.

use super::picture::say_fault;
use super::scene_arguments::{ObjectFlags, SceneArguments};
use super::{say, with_progress};
use crate::gpu::{Gpu, Options};
use crate::measure::statistics::quantile;
use crate::render::variant::Variant;
use crate::render::{Frame, RenderError, Renderer, Subject, made_with, watch};
use crate::scene::{EmptySpace, Neutral, Pass, Scene};
use crate::shader::library::ZERO;
use clap::Args;
use std::error::Error;

/// Pictures of which the time is the median.
const PICTURES: usize = 3;

/// Arguments of `explain`.
#[derive(Args)]
pub struct Explain {
    /// What `render` takes: an object, a scene file, an example scene, or a picture that this program has written.
    pub input: String,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// What the picture shows.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

/// Draws the picture, and again without each of the things that leave work out.
pub(super) fn run(command: &Explain, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let scene = command.arguments.scene(&command.input, &command.object)?;
    let library = super::library(&scene)?;
    super::try_modules(&scene, &library, Some(options))?;
    let subject = with_progress(quiet, "distance field", |progress| Subject::load(&scene, &library, progress))?;
    let fault = watch(&library, &scene, &subject)?;
    let gpu = Gpu::new(options)?;
    let draw = |scene: &Scene| -> Result<(Frame, Vec<f64>), RenderError> {
        let mut renderer = Renderer::new(&gpu, &library, &subject);
        renderer.prepare(scene, &|_| ())?;
        // Not the first: slices leave out empty space from the second one on.
        renderer.render(scene)?;
        let frames = (0..PICTURES).map(|_| renderer.render(scene)).collect::<Result<Vec<Frame>, _>>()?;
        let times: Vec<f64> = frames.iter().map(|frame| frame.measurements.alone_ms()).collect();
        let last = frames.into_iter().next_back().ok_or(RenderError::Missing("picture"))?;
        Ok((last, times))
    };
    let (frame, times) = draw(&scene)?;
    let mut lines: Vec<String> = made_with(&frame.measurements, &scene, &subject, &library)?
        .into_iter()
        .map(|[a, b]| format!("{a:<11}{b}"))
        .collect();
    let memory = lines.pop();
    lines.push(format!("time       {} on the device, median of {PICTURES}", spread(&times)));
    let has_zeros = Variant::of(&scene, &library)?.slots.contains_key(ZERO);
    for More { how, saves, change } in without(&scene) {
        let mut other = scene.clone();
        change(&mut other);
        let keeps = other.quality.neutral == Neutral::Keep && !has_zeros;
        if other == scene || keeps || other.check(&library).is_err() {
            continue;
        }
        let (full, others) = draw(&other)?;
        let differences =
            frame.pixels.as_flattened().iter().zip(full.pixels.as_flattened()).map(|(a, b)| (a - b).abs());
        let error = match differences.fold(0.0, f32::max) {
            0.0 => "no pixel differs".into(),
            most => format!("pixels differ by {most:.1e} at most"),
        };
        let saved = saved(&times, &others);
        lines.push(format!("           {} {how}: {saves} {saved}, {error}", spread(&others)));
    }
    lines.extend(memory);
    say(&(lines.join("\n") + "\n"));
    say_fault(fault);
    Ok(())
}

fn median(times: &[f64]) -> f64 {
    quantile(times.to_vec(), 0.5)
}

/// The least and the greatest of some times.
fn ends(times: &[f64]) -> [f64; 2] {
    [0.0, 1.0].map(|share| quantile(times.to_vec(), share))
}

/// What one picture saves of the time of another, where their times lie apart.
fn saved(times: &[f64], others: &[f64]) -> String {
    let ([least, most], [least_other, most_other]) = (ends(times), ends(others));
    match most < least_other || most_other < least {
        true => format!("{} %", (100.0 * (1.0 - median(times) / median(others))).round()),
        false => "nothing beyond the spread".into(),
    }
}

/// The median of some times, and from which to which they are.
fn spread(times: &[f64]) -> String {
    let [least, most] = ends(times);
    format!("{:.1} ms ({least:.1} to {most:.1})", median(times))
}

/// A picture that costs more.
struct More {
    /// How it is drawn.
    how: &'static str,
    /// What the scene does in place of that.
    saves: &'static str,
    change: fn(&mut Scene),
}

/// The pictures that a scene is held against.
fn without(scene: &Scene) -> [More; 4] {
    [
        More {
            how: "with every sample (--empty-space sample)",
            saves: "skipping saves",
            change: |scene| scene.quality.empty_space = EmptySpace::Sample,
        },
        More {
            how: "with the terms that a 0 takes away (--set quality.neutral=keep)",
            saves: "leaving them out saves",
            change: |scene| scene.quality.neutral = Neutral::Keep,
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
    fn a_saving_is_a_number_where_the_times_lie_apart() {
        assert_eq!(saved(&[9.0, 10.0, 11.0], &[19.0, 20.0, 40.0]), "50 %");
        assert_eq!(saved(&[19.0, 20.0, 40.0], &[9.0, 10.0, 11.0]), "-100 %");
        assert_eq!(saved(&[9.0, 10.0, 11.0], &[10.5, 12.0, 13.0]), "nothing beyond the spread");
    }
}
