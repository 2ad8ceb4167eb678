//! `mesh`: the surface of a hypertextured object, as a file.

use super::convert::MESH_ENDS;
use super::picture::say_fault;
use super::scene_arguments::{ObjectFlags, SceneArguments, files_read};
use super::{absolute, say, with_progress};
use clap::Args;
use hypertexture::output;
use hypertexture::render::{PolygonizeError, Polygons, Subject, polygonize, try_custom_modules};
use hypertexture::shape::MeshFormat;
use std::error::Error;
use std::path::PathBuf;
use support::write_whole;

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
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// The scene.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

/// Polygonizes the surface and writes it.
pub(super) fn run(command: &Mesh, quiet: bool) -> Result<(), Box<dyn Error>> {
    let path = &command.output;
    let known = MeshFormat::from_path(path);
    let format = known.ok_or_else(|| format!("--output {}: end the name in {MESH_ENDS}", path.display()))?;
    let scene = command.arguments.scene(&command.input, &command.object)?;
    output::check_all([("--output", path.clone())], files_read(&command.input, &scene))?;
    let (variant, library) = super::checked(&scene)?;
    super::try_modules(&variant, &library, None)?;
    if scene.camera.clip.is_some() {
        ::log::warn!("camera.clip cuts pictures; the mesh is whole");
    }
    let subject = with_progress(quiet, "distance field", |progress| Subject::load(&variant, &library, progress))?;
    output::check_all([("--output", path.clone())], subject.all_others().cloned())?;
    let fault = try_custom_modules(&library, &variant, &subject)?;
    let polygons = Polygons { grid: command.grid, density: command.density };
    let mesh = with_progress(quiet, "mesh", |progress| polygonize(&library, &variant, &subject, polygons, progress))
        .map_err(|error| match error {
            PolygonizeError::Grid(_) | PolygonizeError::Density(_) => format!("--{error}").into(),
            error => Box::<dyn Error>::from(error),
        })?;
    let mut bytes = Vec::new();
    format.write(&mesh, &mut bytes)?;
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
        say_fault(fault);
    }
    Ok(())
}
