//! The child process: renders scenes on request.

use super::{Drawn, Failed, Load, Request, Task};
use hypertexture::gpu::{Gpu, Options};
use hypertexture::render::{Frame, RenderError, Renderer, Subject};
use hypertexture::scene::{self, Scene};
use hypertexture::shader::{self, Library};
use hypertexture_support::jobs::Parent;
use std::collections::HashMap;
use std::io;

/// Reads a task and answers requests until the input ends.
///
/// # Errors
/// The input cannot be read, or the output not be written.
pub fn serve(mut parent: Parent, options: &Options) -> io::Result<()> {
    let Some(task) = parent.request::<Task>()? else { return Ok(()) };
    let library = shader::shipped_with(task.changed).compiled_by(&std::env::current_exe()?);
    let ready = Gpu::new(options).map_err(RenderError::from).and_then(|gpu| Ok((gpu, load(&task.load, &library)?)));
    let (gpu, subject) = match ready {
        Ok(ready) => ready,
        Err(error) => return parent.tell(&Err::<(), _>(failed(&error)), &[]),
    };
    parent.tell(&Ok::<_, Failed>(()), &[])?;
    let messages = gpu.messages();
    let mut renderers: HashMap<u64, Renderer> = HashMap::new();
    while let Some(request) = parent.request()? {
        match request {
            Request::Forget(number) => drop(renderers.remove(&number)),
            Request::Draw(number, text, anew) => {
                let scene = parse(&text)?;
                let renderer = renderers.entry(number).or_insert_with(|| Renderer::new(&gpu, &library, &subject));
                if anew {
                    renderer.invalidate_shadows();
                }
                let drawn = renderer.render(&scene);
                let said = messages.take(); // of the validation layer
                let (answer, pixels) = match drawn {
                    Ok(_) if !said.is_empty() => (Err(Failed { reason: said.join("; "), is_lost: false }), Vec::new()),
                    Ok(Frame { size, pixels, measurements }) => (Ok(Drawn { size, measurements }), pixels),
                    Err(error) => (Err(failed(&error)), Vec::new()),
                };
                parent.tell(&answer, bytemuck::cast_slice(&pixels))?;
            }
        }
    }
    Ok(())
}

fn load(load: &Load, library: &Library) -> Result<Subject, RenderError> {
    match load {
        Load::Scene(text) => {
            let scene = parse(text).map_err(|error| RenderError::Worker(error.to_string()))?;
            Subject::load(&scene, library, &|_| ())
        }
        Load::Object { object, margin, closest } => Subject::load_with_margin(object, *margin, *closest, &|_| ()),
    }
}

fn parse(text: &str) -> io::Result<Scene> {
    scene::parse(text, "scene").map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error.to_string()))
}

/// The answer for an error.
fn failed(error: &RenderError) -> Failed {
    let is_lost = matches!(error, RenderError::Gpu(error) if error.is_lost());
    Failed { reason: error.to_string(), is_lost }
}
