//! `web` and `export`: a scene for a browser, and for other hosts.

use super::render::picture::draw;
#[cfg(feature = "viewer")]
use crate::arguments::SceneInput;
use crate::arguments::{ObjectFlags, SceneArguments};
use crate::session::{CheckedScene, Outputs, Preparation, Prepared, say_fault, with_device};
use crate::terminal::{absolute, say, with_progress};
use clap::Args;
use hypertexture::gpu::Options;
use hypertexture::output::{Depth, Provenance, encode_png};
use hypertexture::render::{ModuleFault, Portable, RenderError, Subject};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use hypertexture_export::{File, Page, folder, page};
use hypertexture_support::write_whole;
use std::error::Error;
use std::fs::create_dir_all;
use std::path::{Path, PathBuf};

/// Arguments of `web`.
#[derive(Args)]
pub struct Web {
    /// An object, a scene file, an example scene, or a picture of this program.
    pub input: String,
    /// Output folder, or file with --single-file.
    ///
    /// [default: page or page.html]
    #[arg(long, short, value_name = "PATH")]
    pub output: Option<PathBuf>,
    /// Write one file, which also works from disk.
    #[arg(long)]
    pub single_file: bool,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// The scene.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

/// Arguments of `export`.
#[derive(Args)]
pub struct Export {
    /// An object, a scene file, an example scene, or a picture of this program.
    pub input: String,
    /// Output folder.
    #[arg(long, short, default_value = "export", value_name = "FOLDER")]
    pub output: PathBuf,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// The scene.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

/// A prepared scene, its programs and its inputs.
struct Exported {
    prepared: Prepared,
    portable: Portable,
    /// The command that makes the output, without its name.
    command: String,
}

/// A checked scene.
struct Source {
    scene: CheckedScene,
    /// The command that makes the output, without its name.
    command: String,
}

/// The checked scene of the command `name`.
fn checked(
    name: &str,
    input: &str,
    arguments: &SceneArguments,
    object: &ObjectFlags,
) -> Result<Source, Box<dyn Error>> {
    let scene = arguments.scene_and_base(input, object)?;
    let command = command_of(name, &scene.scene, &scene.scene.library()?);
    Ok(Source { scene: CheckedScene::of(scene.smooth())?, command })
}

/// Prepares a scene and makes its programs and inputs.
fn exported(source: Source, preparation: &Preparation<'_>) -> Result<Exported, Box<dyn Error>> {
    let quiet = preparation.quiet;
    let Source { scene, command } = source;
    let prepared = scene.prepare(preparation)?;
    let Prepared { moving, library, subject, .. } = &prepared;
    let portable = with_progress(quiet, "program", |progress| Portable::of(library, moving, subject, progress))?;
    let still = portable.motion.iter().flat_map(|motion| &motion.still).cloned().collect::<Vec<_>>().join(", ");
    if !quiet && !still.is_empty() {
        say(&format!("note       {still}: without motion, since it changes the program, its images or the field\n"));
    }
    Ok(Exported { prepared, portable, command })
}

/// Writes a page.
pub(crate) fn web(command: &Web, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    command.path()?;
    let source = checked("web", &command.input, &command.arguments, &command.object)?;
    let stem = Path::new(&command.input).file_stem().unwrap_or_default().to_string_lossy().replace('_', " ");
    let title = command.arguments.effect.as_ref().map_or(stem.clone(), |effect| format!("{effect} on {stem}"));
    write_page(command, source, &title, options, quiet)
}

/// Writes the page of a scene that the window shows.
#[cfg(feature = "viewer")]
pub(crate) fn web_of(
    command: &Web,
    scene: SceneInput,
    library: Library,
    options: &Options,
    quiet: bool,
) -> Result<(), Box<dyn Error>> {
    let command_line = command_of("web", &scene.scene, &library);
    let source = Source { scene: CheckedScene::with_library(scene.smooth(), library)?, command: command_line };
    let title = command.path()?.file_stem().unwrap_or_default().to_string_lossy().replace('_', " ");
    write_page(command, source, &title, options, quiet)
}

impl Web {
    /// The path of the output.
    fn path(&self) -> Result<PathBuf, String> {
        let usual = if self.single_file { "page.html" } else { "page" };
        let path = self.output.clone().unwrap_or_else(|| usual.into());
        if self.single_file && path.extension().is_none_or(|end| !end.eq_ignore_ascii_case("html")) {
            return Err(format!("--output {}: end the name in .html", path.display()));
        }
        Ok(path)
    }
}

fn write_page(
    command: &Web,
    source: Source,
    title: &str,
    options: &Options,
    quiet: bool,
) -> Result<(), Box<dyn Error>> {
    let (path, is_single) = (&command.path()?, command.single_file);
    let outputs =
        &if is_single { Outputs::Files(vec![("--output", path.clone())]) } else { Outputs::Folder(path.clone()) };
    let (input, device) = (command.input.as_str(), Some(options));
    let preparation = Preparation { input, outputs, device, serves_all_moments: true, quiet };
    let Exported { prepared, portable, command: line } = exported(source, &preparation)?;
    let Prepared { variant, library, subject, fault, .. } = prepared;
    let picture = with_device(options, |gpu| {
        let frame = draw(gpu, &library, &variant, &subject, quiet)?;
        let provenance = Provenance::of(&variant.scene, &gpu.info().title(), &frame.measurements)?;
        Ok(encode_png(&frame, variant.scene.image.background, Depth::Eight, &provenance)?)
    })?;
    let flag = if is_single { " --single-file" } else { "" };
    let line = format!("{line}{flag} -o {}", path.file_name().unwrap_or_default().to_string_lossy());
    let files = page(&portable, &Page { title, command: &line, picture: &picture, is_single })?;
    if is_single {
        write(Path::new(""), &[(path.to_string_lossy().into(), files.into_iter().next().unwrap_or_default().1)])?;
    } else {
        write(path, &files)?;
    }
    let shown = if is_single { path.to_path_buf() } else { path.join("index.html") };
    say_written(&shown, fault, quiet)
}

/// Writes a folder for other hosts.
pub(crate) fn export(command: &Export, quiet: bool) -> Result<(), Box<dyn Error>> {
    let outputs = &Outputs::Folder(command.output.clone());
    let input = command.input.as_str();
    let source = checked("export", input, &command.arguments, &command.object)?;
    let preparation = Preparation { input, outputs, device: None, serves_all_moments: true, quiet };
    let exported = exported(source, &preparation)?;
    write(&command.output, &folder(&exported.portable, &exported.command)?)?;
    say_written(&command.output.join("scene.json"), exported.prepared.fault, quiet)
}

/// Writes the page of a checked scene beside others; false if the scene cannot be carried.
pub(crate) fn live(
    library: &Library,
    subject: &Subject,
    scene: &Scene,
    title: &str,
    picture: &[u8],
    path: &Path,
) -> Result<bool, Box<dyn Error>> {
    let portable = match Portable::of(library, scene, subject, &|_| ()) {
        Err(RenderError::Portable(..)) => return Ok(false),
        portable => portable?,
    };
    let command = format!("{} -o page", command_of("web", scene, library));
    write(path, &page(&portable, &Page { title, command: &command, picture, is_single: false })?)?;
    Ok(true)
}

/// The command line of a scene for another command than `render`.
fn command_of(name: &str, scene: &Scene, library: &Library) -> String {
    scene.command_line(library).replacen(" render ", &format!(" {name} "), 1)
}

/// Writes files into a folder, which is created.
fn write(folder: &Path, files: &[File]) -> Result<(), Box<dyn Error>> {
    let fails = |path: &Path, error: std::io::Error| format!("{}: {error}", path.display());
    if folder != Path::new("") {
        create_dir_all(folder).map_err(|error| fails(folder, error))?;
    }
    for (name, bytes) in files {
        let path = folder.join(name);
        write_whole(&path, bytes).map_err(|error| fails(&path, error))?;
    }
    Ok(())
}

fn say_written(path: &Path, fault: Option<ModuleFault>, quiet: bool) -> Result<(), Box<dyn Error>> {
    if !quiet {
        say_fault(fault);
        say(&format!("wrote {}\n", absolute(path)));
    }
    Ok(())
}
