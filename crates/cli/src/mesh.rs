//! `mesh`: the surface of a hypertextured object, as a file.

use super::convert::MESH_ENDS;
use super::picture::say_fault;
use super::scene_arguments::{ObjectFlags, SceneArguments, files_read};
use super::sequence::{FrameObject, Times};
use super::{absolute, say, with_progress};
use clap::Args;
use hypertexture::output;
use hypertexture::render::variant::Variant;
use hypertexture::render::{PolygonizeError, Polygons, Subject, polygonize, polygonize_with_looks, try_custom_modules};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use hypertexture::shape::MeshFormat;
use hypertexture_support::write_whole;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Arguments of `mesh`.
#[derive(Args)]
pub struct Mesh {
    /// An object, a scene file, an example scene, or a picture of this program.
    pub input: String,
    /// Output: .stl, .ply, .obj or .glb.
    #[arg(long, short, default_value = "mesh.stl", value_name = "FILE")]
    pub output: PathBuf,
    /// The density of the surface, above 0, up to 1.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true)]
    pub density: f32,
    /// Samples along the longest side of the mesh, 8 to 512.
    #[arg(long, default_value_t = 128)]
    pub grid: u32,
    /// The frames.
    #[command(flatten)]
    pub times: Times,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// The scene.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

/// Polygonizes the surface and writes it.
pub(super) fn run(command: &Mesh, quiet: bool) -> Result<(), Box<dyn Error>> {
    command.format()?;
    let scene = command.arguments.scene_and_base(&command.input, &command.object)?.0;
    export(command, &scene, super::checked(&scene)?, quiet)
}

impl Mesh {
    fn format(&self) -> Result<MeshFormat, String> {
        let path = &self.output;
        let known = MeshFormat::from_path(path);
        known.ok_or_else(|| format!("--output {}: end the name in {MESH_ENDS}", path.display()))
    }
}

/// Polygonizes the surface of a checked scene and writes it.
pub(super) fn export(
    command: &Mesh,
    scene: &Scene,
    (variant, library): (Variant, Library),
    quiet: bool,
) -> Result<(), Box<dyn Error>> {
    let format = command.format()?;
    let scenes = command.times.scenes(scene, &command.output)?;
    let outputs = || scenes.iter().map(|(_, path)| ("--output", path.clone()));
    output::check_all(outputs(), files_read(&command.input, scene))?;
    super::try_modules(&variant, &library, None)?;
    if scene.camera.clip.is_some() {
        ::log::warn!("camera.clip cuts pictures; the mesh is whole");
    }
    let subject = with_progress(quiet, "distance field", |progress| Subject::load(&variant, &library, progress))?;
    output::check_all(outputs(), subject.all_others().cloned())?;
    let fault = try_custom_modules(&library, &variant, &subject)?;
    let mut object = FrameObject::of(&variant, &subject);
    for (scene, path) in &scenes {
        object.serve(&Variant::of(scene, &library)?, &library)?;
        write(command, (&library, scene, &object.subject), (format, path), quiet)?;
    }
    if !quiet {
        say_fault(fault);
    }
    Ok(())
}

/// Polygonizes a frame and writes it.
fn write(
    command: &Mesh,
    (library, scene, subject): (&Library, &Scene, &Subject),
    (format, path): (MeshFormat, &Path),
    quiet: bool,
) -> Result<(), Box<dyn Error>> {
    let polygons = Polygons { grid: command.grid, density: command.density };
    let made = with_progress(quiet, "mesh", |progress| match format {
        MeshFormat::Stl => Ok((polygonize(library, scene, subject, polygons, progress)?, None)),
        _ => {
            polygonize_with_looks(library, scene, subject, polygons, progress).map(|(mesh, looks)| (mesh, Some(looks)))
        }
    });
    let (mesh, looks) = made.map_err(|error| match error {
        PolygonizeError::Grid(_) | PolygonizeError::Density(_) => format!("--{error}").into(),
        error => Box::<dyn Error>::from(error),
    })?;
    let mut bytes = Vec::new();
    format.write_with(&mesh, looks.as_ref(), &mut bytes)?;
    write_whole(path, &bytes).map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
    if !quiet {
        let (edges, size) = (mesh.edges(), mesh.bounds().max - mesh.bounds().min);
        say(&format!(
            "mesh       {} vertices, {} triangles, {}; {}\n\
             size       {} x {} x {}, volume {} cubic world units\nwrote {}\n",
            edges.vertices,
            mesh.triangles.len(),
            if edges.bodies == 1 { "1 body".into() } else { format!("{} bodies", edges.bodies) },
            if edges.open + edges.crowded + edges.turned == 0 { "watertight" } else { "not watertight" },
            size.x,
            size.y,
            size.z,
            mesh.signed_volume(),
            absolute(path)
        ));
    }
    Ok(())
}
