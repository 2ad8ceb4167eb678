//! The job of the window that renders final pictures and exports meshes, volumes and pages.

use super::command_line::{Arguments, Command};
use crate::arguments::SceneInput;
use crate::commands::render::render;
use crate::commands::{export, mesh, volume};
use crate::session::CheckedScene;
use crate::terminal::listen;
use clap::Parser;
use hypertexture::gpu::Options;
use hypertexture::{scene, shader};
use hypertexture_support::jobs::Parent;
use hypertexture_viewer::{RenderAnswer, RenderJob};
use std::error::Error;
use std::io;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// Interval between messages of progress.
const PERIOD: Duration = Duration::from_millis(100);
/// Stack of the thread that renders, in bytes: that of a main thread.
const STACK: usize = 8 << 20;

/// Writes the files of a request, with modules whose text may be in no file, and tells how far it is.
pub fn serve(mut parent: Parent, options: &Options) -> io::Result<()> {
    parent.give_way();
    let Some(job) = parent.request()? else { return Ok(()) };
    let at: Arc<Mutex<Option<(&'static str, f32)>>> = Arc::default();
    let latest = at.clone();
    listen(Box::new(move |what, part| *latest.lock().unwrap_or_else(|error| error.into_inner()) = Some((what, part))));
    thread::scope(|scope| {
        let (tell, done) = channel();
        let work = move || drop(tell.send(render_job(job, options).map_err(|error| error.to_string())));
        thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work)?;
        loop {
            match done.recv_timeout(PERIOD) {
                Ok(result) => return parent.tell(&RenderAnswer::Done(result), &[]),
                Err(RecvTimeoutError::Disconnected) => return Err(io::Error::other("the rendering panicked")),
                Err(RecvTimeoutError::Timeout) => {
                    let latest = at.lock().unwrap_or_else(|error| error.into_inner()).take();
                    if let Some((what, part)) = latest {
                        parent.tell(&RenderAnswer::At(what.into(), part), &[])?;
                    }
                }
            }
        }
    })
}

/// Writes the files of a request; returns lines about them, if there are any.
fn render_job(job: RenderJob, options: &Options) -> Result<String, Box<dyn Error>> {
    let scene = scene::parse(&job.scene, "scene")?;
    let library = shader::shipped_with(job.changed).compiled_by(&std::env::current_exe()?);
    let scene = SceneInput { base: scene::nearest_preset(&scene), scene, sets_rays_of_a_pixel: false };
    let checked = |scene| CheckedScene::with_library(scene, library.clone());
    let written = match Arguments::try_parse_from(job.command)?.command {
        Command::Render(command) => render(&command, options, true, checked(scene)?),
        Command::Mesh(command) => return mesh::export(&command, checked(scene)?, true),
        Command::Volume(command) => volume::export(&command, options, checked(scene)?, true),
        Command::Web(command) => export::web_of(&command, scene, library, options, true),
        _ => Err("the window asks for no such file".into()),
    };
    written.map(|()| String::new())
}
