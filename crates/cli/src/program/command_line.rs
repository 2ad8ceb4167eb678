//! The command line.

use crate::commands::bench::Bench;
use crate::commands::compare::Compare;
use crate::commands::convert::Convert;
use crate::commands::explain::Explain;
use crate::commands::export::{Export, Web};
use crate::commands::field::Field;
use crate::commands::gallery::GalleryArguments;
use crate::commands::groom::GroomArguments;
use crate::commands::info::Info;
use crate::commands::merge::Merge;
use crate::commands::mesh::Mesh;
use crate::commands::render::Render;
use crate::commands::stress::Stress;
use crate::commands::verify::Verify;
#[cfg(feature = "viewer")]
use crate::commands::view::ViewArguments;
use crate::commands::volume::Volume;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Texture and hypertexture volumetric objects: fur, fire, melting and more around a mesh, a scan or a formula.
#[derive(Parser)]
#[command(name = "hypertexture", version, max_term_width = 100)]
pub struct Arguments {
    /// Command.
    #[command(subcommand)]
    pub command: Command,
    /// Part of the name of the Vulkan device to use.
    #[arg(long, global = true, env = "HYPERTEXTURE_DEVICE", value_name = "NAME")]
    pub device: Option<String>,
    /// Print only errors.
    #[arg(long, short, global = true)]
    pub quiet: bool,
}

/// Commands.
#[derive(Subcommand)]
pub enum Command {
    /// Render a picture.
    Render(Box<Render>),
    /// Show the live window: the mouse turns the scene, and panels change it.
    #[cfg(feature = "viewer")]
    View(Box<ViewArguments>),
    /// Join the shards of a picture, as `render --shard` writes them.
    Merge(Merge),
    /// Compute the distance field of an object and write it. Formats: NRRD, MetaImage, NIfTI, OpenVDB, .npy.
    Field(Field),
    /// Write the surface of a hypertextured object as a closed mesh. It lies where the density crosses a value.
    Mesh(Box<Mesh>),
    /// Write density and color as a fog volume, for Blender, Houdini and EmberGen. Formats: OpenVDB, NRRD, .npy.
    Volume(Box<Volume>),
    /// Paint length, density, color and direction on an object, by expressions. Modules of the effect read it.
    Groom(GroomArguments),
    /// Write a page that shows a scene in a browser, by WebGPU.
    Web(Box<Web>),
    /// Write the program of a scene and its inputs for other hosts. Files: GLSL, SPIR-V, WGSL, texels, and JSON that describes them.
    Export(Box<Export>),
    /// Render every example scene, or the six effects on one object. A page explains them.
    Gallery(GalleryArguments),
    /// Measure error against run time: noise implementations, samples, blocks, formats and integrations, with a report.
    Compare(Box<Compare>),
    /// Explain a picture: its inputs, its program and the work that its scene leaves out, with reasons and savings.
    Explain(Box<Explain>),
    /// Describe a mesh or a volume: counts, box, open edges, range of values, proposed iso-values.
    Info(Info),
    /// Write a volume or a mesh in another format, or values without a header as a volume.
    Convert(Convert),
    /// Measure the cost of effects, example scenes and fields on this device. --baseline compares with a saved run.
    Bench(Bench),
    /// List the effects and their parameters.
    Effects,
    /// List every setting of a scene: default, range, flag.
    Settings,
    /// Stress-test extreme parameters, or those of a scene, and tabulate the error.
    Stress(Box<Stress>),
    /// Check the device against reference scenes, or a picture against the scene in it. The reference scenes are analytic and drawn by
    /// both passes.
    Verify(Verify),
    /// Describe the device, name what is missing, and run self-tests.
    Doctor(Doctor),
    /// Write completions for a shell to standard output.
    #[command(hide = true)]
    Completions(Completions),
    /// Write a manual page, for `man`, to standard output, or all of them into a folder.
    #[command(hide = true)]
    Man(Man),
    /// Answer the requests of the parent on standard input: a child process of this program.
    #[command(hide = true)]
    Job,
}

/// Arguments of `doctor`.
#[derive(Args)]
pub struct Doctor {
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `completions`.
#[derive(Args)]
pub struct Completions {
    /// Shell.
    pub shell: clap_complete::Shell,
}

/// Arguments of `man`.
#[derive(Args)]
pub struct Man {
    /// Command of the page, such as render [default: the program].
    pub command: Option<String>,
    /// Write the pages of the program and of all commands into a folder.
    #[arg(long, value_name = "FOLDER", conflicts_with = "command")]
    pub all: Option<PathBuf>,
}
