//! `web` and `export`: a scene for a browser, and for other hosts.

use super::picture::{draw, smooth};
use super::scene_arguments::{ObjectFlags, SceneArguments, SceneInput};
use super::session::check_folder;
use super::{absolute, say, try_in_sandbox, with_device, with_progress};
use clap::Args;
use hypertexture::gpu::Options;
use hypertexture::output::{self, Depth, Provenance, encode_png};
use hypertexture::render::variant::Variant;
use hypertexture::render::{Portable, RenderError, Subject, widest};
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
    /// Output folder, or file with --single-file [default: page or page.html].
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

/// A scene with its object loaded.
struct Loaded {
    variant: Variant,
    library: Library,
    subject: Subject,
    portable: Portable,
    /// The command that makes the output, without its name.
    command: String,
}

/// Loads a scene and makes its programs and inputs.
fn load(
    (name, input): (&str, &str),
    (arguments, object): (&SceneArguments, &ObjectFlags),
    options: Option<&Options>,
    quiet: bool,
) -> Result<Loaded, Box<dyn Error>> {
    let SceneInput { mut scene, sets_rays_of_a_pixel, .. } = arguments.scene_and_base(input, object)?;
    let command = command_of(name, &scene, &scene.library()?);
    if !sets_rays_of_a_pixel {
        smooth(&mut scene);
    }
    let (variant, library) = super::checked(&scene)?;
    try_in_sandbox(&variant, &library, options)?;
    loaded(command, &scene, (variant, library), quiet)
}

/// Loads the object of a checked scene and makes its programs and inputs.
fn loaded(
    command: String,
    scene: &Scene,
    (variant, library): (Variant, Library),
    quiet: bool,
) -> Result<Loaded, Box<dyn Error>> {
    let widest = widest(scene, &library)?;
    let subject = with_progress(quiet, "distance field", |progress| Subject::load(&widest, &library, progress))?;
    let portable = with_progress(quiet, "program", |progress| Portable::of(&library, scene, &subject, progress))?;
    let still = portable.motion.iter().flat_map(|motion| &motion.still).cloned().collect::<Vec<_>>().join(", ");
    if !quiet && !still.is_empty() {
        say(&format!("note       {still}: without motion, since it changes the program, its images or the field\n"));
    }
    Ok(Loaded { variant, library, subject, portable, command })
}

/// Writes a page.
pub(super) fn web(command: &Web, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let path = command.path()?;
    let loaded = load(("web", &command.input), (&command.arguments, &command.object), Some(options), quiet)?;
    let stem = Path::new(&command.input).file_stem().unwrap_or_default().to_string_lossy().replace('_', " ");
    let title = command.arguments.effect.as_ref().map_or(stem.clone(), |effect| format!("{effect} on {stem}"));
    write_page(&loaded, (&path, &title, command.single_file), options, quiet)
}

/// Writes the page of a scene that the window shows.
#[cfg(feature = "viewer")]
pub(super) fn web_of(
    command: &Web,
    (mut scene, library): (Scene, Library),
    options: &Options,
    quiet: bool,
) -> Result<(), Box<dyn Error>> {
    let path = command.path()?;
    let line = command_of("web", &scene, &library);
    smooth(&mut scene);
    let loaded = loaded(line, &scene, (Variant::of(&scene, &library)?, library), quiet)?;
    let title = path.file_stem().unwrap_or_default().to_string_lossy().replace('_', " ");
    write_page(&loaded, (&path, &title, command.single_file), options, quiet)
}

impl Web {
    /// The checked path of the output.
    fn path(&self) -> Result<PathBuf, Box<dyn Error>> {
        let usual = if self.single_file { "page.html" } else { "page" };
        let path = self.output.clone().unwrap_or_else(|| usual.into());
        match self.single_file {
            true if path.extension().is_none_or(|end| !end.eq_ignore_ascii_case("html")) => {
                return Err(format!("--output {}: end the name in .html", path.display()).into());
            }
            true => output::check_all([("--output", path.clone())], [PathBuf::from(&self.input)])?,
            false => check_folder(&path)?,
        }
        Ok(path)
    }
}

fn write_page(
    loaded: &Loaded,
    (path, title, is_single): (&Path, &str, bool),
    options: &Options,
    quiet: bool,
) -> Result<(), Box<dyn Error>> {
    let Loaded { variant, library, subject, portable, command: line } = loaded;
    let picture = with_device(options, |gpu| {
        let frame = draw(gpu, library, (variant, subject), quiet)?;
        let provenance = Provenance::of(&variant.scene, &gpu.info().title(), &frame.measurements)?;
        Ok(encode_png(&frame, variant.scene.image.background, Depth::Eight, &provenance)?)
    })?;
    let flag = if is_single { " --single-file" } else { "" };
    let line = format!("{line}{flag} -o {}", path.file_name().unwrap_or_default().to_string_lossy());
    let files = page(portable, &Page { title, command: &line, picture: &picture, is_single })?;
    match is_single {
        true => {
            write(Path::new(""), &[(path.to_string_lossy().into(), files.into_iter().next().unwrap_or_default().1)])?
        }
        false => write(path, &files)?,
    }
    let shown = if is_single { path.to_path_buf() } else { path.join("index.html") };
    say_written(&shown, quiet)
}

/// Writes a folder for other hosts.
pub(super) fn export(command: &Export, quiet: bool) -> Result<(), Box<dyn Error>> {
    check_folder(&command.output)?;
    let loaded = load(("export", &command.input), (&command.arguments, &command.object), None, quiet)?;
    write(&command.output, &folder(&loaded.portable, &loaded.command)?)?;
    say_written(&command.output.join("scene.json"), quiet)
}

/// Writes the page of a checked scene beside others; false if the scene cannot be carried.
pub(super) fn live(
    (library, subject): (&Library, &Subject),
    scene: &Scene,
    (title, picture): (&str, &[u8]),
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

fn say_written(path: &Path, quiet: bool) -> Result<(), Box<dyn Error>> {
    if !quiet {
        say(&format!("wrote {}\n", absolute(path)));
    }
    Ok(())
}
