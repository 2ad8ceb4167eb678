//! The window, by the arguments of `view`.

use super::scene_arguments::{ObjectFlags, SceneArguments, files_read, size};
use clap::Args;
use hypertexture::gpu::Options;
use std::error::Error;
use std::fmt;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Instant;
use viewer::{self, Start, ViewError};

/// Arguments of `view`.
#[derive(Args)]
pub struct ViewArguments {
    /// An object, a scene file (.toml) or an example scene. An object is built in, a mesh, a scalar volume or a distance field.
    /// fire_ball is an example scene.
    #[arg(default_value = "furry_donut")]
    pub input: String,
    /// Refine a picture at rest until its rms error is about this [default: 0.001].
    #[arg(long, value_name = "RMSE", value_parser = error)]
    pub max_error: Option<f64>,
    /// Let time run from the beginning.
    #[arg(long)]
    pub play: bool,
    /// Width and height of the window, in points.
    #[arg(long, default_value = "1280x800", value_parser = window, value_name = "WxH")]
    pub window: [u32; 2],
    /// Draw so many frames after the first picture, then end.
    #[arg(long, value_name = "NUMBER")]
    pub frames: Option<u32>,
    /// Write the picture that `render` makes, after those frames or when the picture has converged, then end.
    #[arg(long, value_name = "FILE")]
    pub screenshot: Option<PathBuf>,
    /// Do what this file says.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["frames", "screenshot"], hide = true)]
    pub script: Option<PathBuf>,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// What the picture shows.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

/// The sides that a window can have, points: no screen has more.
const SIDES: RangeInclusive<u32> = 1..=16384;

fn window(text: &str) -> Result<[u32; 2], String> {
    let wanted = size(text)?;
    let fits = wanted.iter().all(|side| SIDES.contains(side));
    fits.then_some(wanted).ok_or_else(|| format!("a side of a window has {} to {} points", SIDES.start(), SIDES.end()))
}

fn error(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|error| (1e-7..=1.0).contains(error));
    parsed.ok_or_else(|| "write a number from 1e-7 to 1; a code of 8 bits is 0.004".into())
}

/// There is no window: something outside of the scene is missing, or went wrong.
#[derive(Debug)]
pub struct NoWindow(ViewError);

impl fmt::Display for NoWindow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Error for NoWindow {}

/// Shows the window.
pub fn run(command: ViewArguments, options: Options) -> Result<(), Box<dyn Error>> {
    let began = Instant::now();
    let scene = command.arguments.scene(&command.input, &command.object)?;
    let library = super::library(&scene)?;
    if let Some(file) = &command.screenshot {
        hypertexture::output::check(file)?;
        hypertexture::output::check_all([("--screenshot", file.clone())], files_read(&command.input, &scene))?;
    }
    let ViewArguments { max_error, play, window, frames, screenshot, script, .. } = command;
    let start = Start { scene, library, options, max_error, play, window, frames, screenshot, script, began };
    viewer::run(start).map_err(|error| NoWindow(error).into())
}
