//! The job of the window that renders final pictures and exports meshes and volumes.

use super::args::{Arguments, Command};
use super::render::render;
use super::{mesh, volume};
use clap::Parser;
use hypertexture::gpu::Options;
use hypertexture::render::variant::Variant;
use hypertexture::{scene, shader};
use std::error::Error;
use std::io;
use support::jobs::Parent;
use viewer::RenderJob;

/// Writes the files of a request, with modules whose text may be in no file.
pub fn serve(mut parent: Parent, options: &Options) -> io::Result<()> {
    parent.give_way();
    let Some(job) = parent.request()? else { return Ok(()) };
    parent.tell(&render_job(job, options).map_err(|error| error.to_string()), &[])
}

fn render_job(job: RenderJob, options: &Options) -> Result<(), Box<dyn Error>> {
    let scene = scene::parse(&job.scene, "scene")?;
    let library = shader::shipped_with(job.changed).compiled_by(&std::env::current_exe()?);
    let variant = Variant::of(&scene, &library)?;
    match Arguments::try_parse_from(job.command)?.command {
        Command::Render(command) => {
            let base = scene::nearest_preset(&scene);
            render(&command, options, true, (scene, variant, base, library))
        }
        Command::Mesh(command) => mesh::export(&command, &scene, (variant, library), true),
        Command::Volume(command) => volume::export(&command, options, &scene, (variant, library), true),
        _ => Err("the window asks for no such file".into()),
    }
}
