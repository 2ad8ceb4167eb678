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
use clap::{Arg, Args, Parser, Subcommand};
use std::path::PathBuf;

/// Help of the program, with fewer blank lines than clap's.
const TEMPLATE: &str = "{about}\n{usage-heading} {usage}\n{subcommands}\nOptions:\n{options}{after-help}";
/// Flags of a scene that meshes and volumes do not depend on.
const OF_VIEWS: [&str; 4] = ["camera", "light", "size", "samples"];

/// Texture and hypertexture volumetric objects.
///
/// Fur, fire, melting and more around a mesh, a scan or a formula.
#[derive(Parser)]
#[command(name = "hypertexture", version, max_term_width = 100, help_template = TEMPLATE)]
#[command(after_help = examples("render teapot --effect fur -o fur.png", "view fire_ball"))]
pub struct Arguments {
    /// Command.
    #[command(subcommand)]
    pub command: Command,
    /// Part of the name of the Vulkan device to use.
    #[arg(long, global = true, env = "HYPERTEXTURE_DEVICE", value_name = "NAME", hide_short_help = true)]
    pub device: Option<String>,
    /// Print only errors.
    #[arg(long, short, global = true)]
    pub quiet: bool,
}

/// Commands.
#[derive(Subcommand)]
pub enum Command {
    /// Render a picture.
    #[command(after_help = examples("render teapot --effect fur -o fur.png", "render torus --effect fire --frames 0..99 --turntable -o fire_####.png"))]
    Render(Box<Render>),
    /// Show the live window.
    ///
    /// The mouse turns the scene, and panels change it.
    #[cfg(feature = "viewer")]
    #[command(after_help = examples("view teapot --effect fur", "view fire_ball --play"))]
    View(Box<ViewArguments>),
    /// Join the shards of a picture, as `render --shard` writes them.
    #[command(after_help = examples("merge fur.png fur.shard-*", "merge fur.exr fur.shard-*"))]
    Merge(Merge),
    /// Compute the distance field of an object and write it.
    ///
    /// Formats: NRRD, MetaImage, NIfTI, OpenVDB, .npy.
    #[command(after_help = examples("field teapot --resolution 256 -o teapot.nrrd", "field head.nrrd --iso 0.5 -o skull.vdb"))]
    Field(Field),
    /// Write the surface of a hypertextured object as a closed mesh.
    ///
    /// It lies where the density crosses a value.
    #[command(after_help = examples("mesh noisy_sphere -o stone.stl", "mesh knot --effect fur --grid 256 -o knot.glb"), mut_args = without_view)]
    Mesh(Box<Mesh>),
    /// Write density and color as a fog volume, for Blender, Houdini and EmberGen.
    ///
    /// Formats: OpenVDB, NRRD, .npy.
    #[command(after_help = examples("volume fire_ball -o fire.vdb", "volume teapot --effect fire --half --frames 1..48 -o fire_####.vdb"), mut_args = without_view)]
    Volume(Box<Volume>),
    /// Paint length, density, color, direction and amount on an object, by expressions.
    ///
    /// Modules of the effect read it.
    #[command(after_help = examples("groom torus --length 1.0-p.y", "groom teapot --density 1.0+p.x -o thin.nrrd"))]
    Groom(GroomArguments),
    /// Write a page that shows a scene in a browser, by WebGPU.
    #[command(after_help = examples("web fire_ball -o page", "web teapot --effect fur --single-file -o fur.html"))]
    Web(Box<Web>),
    /// Write the program of a scene and its inputs for other hosts.
    ///
    /// Files: GLSL, SPIR-V, WGSL, texels, and JSON that describes them.
    #[command(after_help = examples("export fire_ball -o program", "export teapot --effect fur -o fur"))]
    Export(Box<Export>),
    /// Render every example scene, or the six effects on one object.
    ///
    /// A page explains them.
    #[command(after_help = examples("gallery -o out", "gallery teapot --web -o out"))]
    Gallery(GalleryArguments),
    /// Measure error against run time.
    ///
    /// Noise implementations, samples, blocks, formats and integrations, with a report.
    #[command(after_help = examples("compare sphere --effect fire -o report", "compare --paper -o report"))]
    Compare(Box<Compare>),
    /// Explain a picture.
    ///
    /// Its inputs, its program and the work that its scene leaves out, with reasons and savings.
    #[command(after_help = examples("explain teapot --effect fire", "explain fire_ball --json"))]
    Explain(Box<Explain>),
    /// Describe a mesh or a volume.
    ///
    /// Counts, box, open edges, range of values, proposed iso-values.
    #[command(after_help = examples("info head.nrrd", "info teapot --json"))]
    Info(Info),
    /// Write a volume or a mesh in another format, or values without a header as a volume.
    #[command(after_help = examples("convert phantom -o head.nrrd", "convert scan.raw --dims 256,256,128 --type uint16 -o scan.nrrd"))]
    Convert(Convert),
    /// Measure the cost of effects, example scenes and fields on this device.
    ///
    /// --baseline compares with a saved run.
    #[command(after_help = examples("bench --quick --json mine.json", "bench effects --baseline mine.json"))]
    Bench(Bench),
    /// List the effects and their parameters.
    #[command(after_help = examples("effects", "effects | less"))]
    Effects,
    /// List every setting of a scene.
    ///
    /// Default, range, flag.
    #[command(after_help = examples("settings", "settings > settings.md"))]
    Settings,
    /// Stress-test extreme parameters, or those of a scene, and tabulate the error.
    #[command(after_help = examples("stress --cases 10,12", "stress torus --effect fur"))]
    Stress(Box<Stress>),
    /// Check the device against reference scenes, or a picture against the scene in it.
    ///
    /// The reference scenes are analytic and drawn by both passes.
    #[command(after_help = examples("verify", "verify fur.png --bound 1e-2"))]
    Verify(Verify),
    /// Describe the device, name what is missing, and run self-tests.
    #[command(after_help = examples("doctor", "doctor --device llvmpipe"))]
    Doctor(Doctor),
    /// Write completions for a shell to standard output.
    #[command(hide = true)]
    #[command(after_help = examples("completions bash", "completions fish > hypertexture.fish"))]
    Completions(Completions),
    /// Write a manual page, for `man`, to standard output, or all of them into a folder.
    #[command(hide = true)]
    #[command(after_help = examples("man render | man -l -", "man --all man1"))]
    Man(Man),
    /// Answer the requests of the parent on standard input: a child process of this program.
    #[command(hide = true)]
    Job,
}

/// Arguments of `doctor`.
#[derive(Args)]
pub(crate) struct Doctor {
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
pub(crate) struct Man {
    /// Command of the page, such as render [default: the program].
    pub command: Option<String>,
    /// Write the pages of the program and of all commands into a folder.
    #[arg(long, value_name = "FOLDER", conflicts_with = "command")]
    pub all: Option<PathBuf>,
}

/// Examples of a command, below its help.
fn examples(first: &str, second: &str) -> String {
    format!("Examples: hypertexture {first}\n          hypertexture {second}")
}

/// Leaves flags of the view out of the short help.
fn without_view(argument: Arg) -> Arg {
    let is_hidden = argument.is_hide_short_help_set() || OF_VIEWS.contains(&argument.get_id().as_str());
    argument.hide_short_help(is_hidden)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    /// Lines and columns of a screen.
    const SCREEN: [usize; 2] = [30, 100];

    #[test]
    fn short_help_fits_one_screen_and_has_examples_that_are_taken() {
        let mut program = Arguments::command();
        program.build();
        let commands =
            program.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help");
        for mut command in commands.cloned().chain([program.clone()]) {
            let help = command.render_help().to_string();
            let [lines, columns] = [help.lines().count(), help.lines().map(|line| line.chars().count()).max().unwrap()];
            assert!(lines <= SCREEN[0] && columns <= SCREEN[1], "{lines} lines of {columns} columns:\n{help}");
            let examples = help.lines().rev().take(2).map(|line| line.split_once(" hypertexture ").unwrap().1);
            for example in examples {
                let words = example.split(['|', '>']).next().unwrap().split_whitespace();
                let parsed = Arguments::try_parse_from(std::iter::once("hypertexture").chain(words));
                assert!(parsed.is_ok(), "{example}: {}", parsed.err().unwrap());
            }
            let long = command.render_long_help().to_string();
            let flags = command.get_arguments().filter(|argument| !argument.is_hide_set());
            for flag in flags.filter_map(|argument| argument.get_long()) {
                assert!(long.contains(&format!("--{flag}")), "{flag}: {long}");
            }
        }
    }
}
