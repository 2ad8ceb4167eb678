//! The command line.

use super::compare::Compare;
use super::scene_arguments::{ObjectArguments, SceneArguments, metric, size};
use super::sequence::{Motion, ShardChoice, shard};
use crate::measure::pick::Metric;
use crate::output::Depth;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Texture and hypertexture volumetric objects: fur, fire, melting and more around a mesh, a scan or a formula.
#[derive(Parser)]
#[command(version, max_term_width = 100)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Part of the name of the Vulkan device to use.
    #[arg(long, global = true, env = "HYPERTEXTURE_DEVICE", value_name = "NAME")]
    pub device: Option<String>,
    /// Say nothing but errors.
    #[arg(long, short, global = true)]
    pub quiet: bool,
}

/// What the program does.
#[derive(Subcommand)]
pub enum Command {
    /// Render a picture.
    Render(Box<Render>),
    /// Show a window, in which the mouse turns the scene and panels change it.
    #[cfg(feature = "viewer")]
    View(Box<ViewArguments>),
    /// Join the shards of a picture, as `render --shard` writes them.
    Merge(Merge),
    /// Compute the distance field of an object and write it as NRRD.
    Field(Field),
    /// Render every example scene, or the six effects on one object, with a page that explains them.
    Gallery(Gallery),
    /// Measure error against run time: noise implementations, samples, blocks, formats and integrations, with a report.
    Compare(Box<Compare>),
    /// List the effects and their parameters.
    Effects,
    /// Check the device against analytic reference scenes in both passes, or a picture against the scene in it.
    Verify(Verify),
    /// Say which device was found, what is missing, and test what the renderer relies on.
    Doctor,
    /// Write completions for a shell to standard output.
    Completions(Completions),
    /// Write a manual page, for `man`, to standard output.
    Man(Man),
    /// Draw the pictures that standard input asks for: what `compare`, `gallery` and `--max-error` draw with.
    #[command(hide = true)]
    Draw,
    /// Compile the job on standard input: what the window runs a user's GLSL through.
    #[cfg(feature = "viewer")]
    #[command(hide = true)]
    Compile(Compile),
    /// Render a few rays of the scene on standard input: what the window tries a user's GLSL with.
    #[cfg(feature = "viewer")]
    #[command(hide = true)]
    Rays(Rays),
}

/// Arguments of `render`.
#[derive(Args)]
pub struct Render {
    /// A built-in object, a mesh, a scalar volume, a distance field, a scene file (.toml), an example scene such as fire_ball, or
    /// a picture that this program has written: its scene.
    pub input: String,
    /// Where the picture goes: .png or .exr.
    #[arg(long, short, default_value = "out.png", value_name = "FILE")]
    pub output: PathBuf,
    /// Bits of each channel of a PNG.
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    pub depth: String,
    /// Write the scene in use, complete with defaults.
    #[arg(long, value_name = "FILE")]
    pub save_scene: Option<PathBuf>,
    /// Say what the picture will cost, from small ones, and write none.
    #[arg(long, conflicts_with_all = ["frames", "shard"])]
    pub predict: bool,
    /// Draw it with the fastest settings whose error is below this, such as 1e-3; the scene says what is drawn, and no longer how.
    #[arg(long, value_name = "ERROR", conflicts_with = "shard")]
    pub max_error: Option<f64>,
    /// How that error is measured: rmse, max, p999, opacity.
    #[arg(long, default_value = "rmse", value_parser = metric, requires = "max_error")]
    pub metric: Metric,
    /// Render part K, from 0 to N - 1, of a picture or of the frames; without a value, the part that Slurm or
    /// Kubernetes gives to this process.
    #[arg(long, value_name = "K/N", num_args = 0..=1, default_missing_value = "auto", value_parser = shard)]
    pub shard: Option<ShardChoice>,
    /// Many frames.
    #[command(flatten)]
    pub motion: Motion,
    /// The object.
    #[command(flatten)]
    pub object: ObjectArguments,
    /// What the picture shows.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

impl Render {
    /// Bits of each channel of a PNG.
    pub fn depth(&self) -> Depth {
        if self.depth == "16" { Depth::Sixteen } else { Depth::Eight }
    }
}

/// Arguments of `view`.
#[cfg(feature = "viewer")]
#[derive(Args)]
pub struct ViewArguments {
    /// A built-in object, a mesh, a scalar volume, a distance field, a scene file (.toml), or an example scene such as fire_ball.
    #[arg(default_value = "furry_donut")]
    pub input: String,
    /// Refine a picture that stands still until its root mean square error is about this [default: 0.001].
    #[arg(long, value_name = "RMSE", value_parser = error)]
    pub max_error: Option<f64>,
    /// Let time run from the beginning.
    #[arg(long)]
    pub play: bool,
    /// Width and height of the window, in points.
    #[arg(long, default_value = "1280x800", value_parser = size, value_name = "WxH")]
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
    pub object: ObjectArguments,
    /// What the picture shows.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

#[cfg(feature = "viewer")]
fn error(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|error| (1e-7..=1.0).contains(error));
    parsed.ok_or_else(|| "write a number from 1e-7 to 1; a code of 8 bits is 0.004".into())
}

/// Arguments of `merge`.
#[derive(Args)]
pub struct Merge {
    /// Where the picture goes: .png or .exr.
    pub output: PathBuf,
    /// All shards of the picture, in any order.
    #[arg(required = true, value_name = "SHARD")]
    pub shards: Vec<PathBuf>,
}

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
    /// The root mean square error that is allowed; without it, what the codes of the file and its step explain.
    #[arg(long, requires = "image", value_parser = bound)]
    pub bound: Option<f64>,
}

fn bound(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|bound| (0.0..=1.0).contains(bound)).ok_or_else(|| "must be from 0 to 1".into())
}

/// Arguments of `completions`.
#[derive(Args)]
pub struct Completions {
    /// The shell that reads them.
    pub shell: clap_complete::Shell,
}

/// Arguments of `man`.
#[derive(Args)]
pub struct Man {
    /// The command that the page is about, such as render; without one, the program.
    pub command: Option<String>,
}

/// Arguments of `compile`: the limits of the process.
#[cfg(feature = "viewer")]
#[derive(Args)]
pub struct Compile {
    /// Time of the processor, seconds.
    #[arg(long, default_value_t = 10)]
    pub seconds: u64,
    /// Address space, MiB.
    #[arg(long, default_value_t = 1024)]
    pub memory_mib: u64,
}

/// Arguments of `rays`: the limit of the process.
#[cfg(feature = "viewer")]
#[derive(Args)]
pub struct Rays {
    /// Time of the processor, seconds.
    #[arg(long, default_value_t = 20)]
    pub seconds: u64,
}

/// Arguments of `field`.
#[derive(Args)]
pub struct Field {
    /// A built-in object, a mesh, a scalar volume or a distance field.
    pub input: String,
    /// Where the field goes: .nrrd.
    #[arg(long, short, default_value = "field.nrrd", value_name = "FILE")]
    pub output: PathBuf,
    /// The object.
    #[command(flatten)]
    pub object: ObjectArguments,
    /// How far the field reaches beyond the object; 1 is half of its longest side.
    #[arg(long, default_value_t = 0.25, allow_negative_numbers = true)]
    pub margin: f32,
}

/// Arguments of `gallery`.
#[derive(Args)]
pub struct Gallery {
    /// The object of the six effects; without one, every example scene has its own object.
    pub input: Option<String>,
    /// Where pictures and page go.
    #[arg(long, short, default_value = "out", value_name = "FOLDER")]
    pub output: PathBuf,
    /// Width and height in pixels.
    #[arg(long, default_value = "512x512", value_parser = size, value_name = "WxH")]
    pub size: [u32; 2],
    /// Samples of a ray through the object; what the scene says without it.
    #[arg(long)]
    pub samples: Option<u32>,
    /// The object.
    #[command(flatten)]
    pub object: ObjectArguments,
}
