//! The window, by the arguments of `view`.

use crate::arguments::{ObjectFlags, SceneArguments, files_read, size};
use crate::session::checked;
use clap::Args;
use hypertexture::gpu::Options;
use hypertexture_viewer::{self, Start, ViewError};
use std::error::Error;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `view`.
#[derive(Args)]
pub(crate) struct ViewArguments {
    /// An object, a scene file (.toml) or an example scene.
    ///
    /// An object is built in, a mesh, a scalar volume or a distance field. fire_ball is an example scene.
    #[arg(default_value = "furry_donut")]
    pub input: String,
    /// RMS error at which a picture at rest has converged.
    ///
    /// [default: 0.001]
    #[arg(long, value_name = "RMSE", value_parser = error)]
    pub max_error: Option<f64>,
    /// Let time run from the beginning.
    #[arg(long)]
    pub play: bool,
    /// Width and height of the window, in points.
    #[arg(long, default_value = "1280x800", value_parser = window, value_name = "WxH")]
    pub window: [u32; 2],
    /// End after this number of frames behind the first picture.
    #[arg(long, value_name = "NUMBER", hide_short_help = true)]
    pub frames: Option<u32>,
    /// Write the picture of `render` after those frames or once the picture has converged, then end.
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    pub screenshot: Option<PathBuf>,
    /// Run a script.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["frames", "screenshot"], hide = true)]
    pub script: Option<PathBuf>,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// The scene.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

/// Range of the sides of a window, points.
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

/// Failure to open a window.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub(crate) struct NoWindow(ViewError);

/// Shows the window.
pub fn run(command: ViewArguments, options: Options) -> Result<(), Box<dyn Error>> {
    let began = Instant::now();
    let scene = command.arguments.scene_and_base(&command.input, &command.object)?.scene;
    let (_, library) = checked(&scene)?;
    if let Some(file) = &command.screenshot {
        hypertexture::output::check(file)?;
        hypertexture::output::check_all([("--screenshot", file.clone())], files_read(&command.input, &scene))?;
    }
    let ViewArguments { max_error, play, window, frames, screenshot, script, .. } = command;
    let is_scene = Path::new(&command.input).extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"));
    let file = is_scene.then(|| PathBuf::from(&command.input));
    let start = Start { scene, library, options, max_error, play, window, frames, screenshot, file, script, began };
    hypertexture_viewer::run(start).map_err(|error| NoWindow(error).into())
}
