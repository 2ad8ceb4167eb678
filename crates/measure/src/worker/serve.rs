//! The child process: renders scenes on request.

use super::protocol::{Answer, Load, Request, Task, line};
use hypertexture::gpu::{Gpu, GpuError, Options};
use hypertexture::render::{RenderError, Renderer, Subject};
use hypertexture::scene::{self, Scene};
use hypertexture::shader::{self, Library};
use std::collections::HashMap;
use std::io::{self, BufRead, Write};

/// Reads a task and answers requests until the input ends.
///
/// # Errors
/// The input cannot be read, or the output not be written.
pub fn serve(input: impl BufRead, output: &mut impl Write, options: &Options) -> io::Result<()> {
    #[cfg(target_os = "linux")] // ends with its parent
    rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::KILL))?;
    let mut lines = input.lines();
    let Some(task) = lines.next().transpose()? else { return Ok(()) };
    let task: Task = serde_json::from_str(&task)?;
    let library = shader::shipped_with(task.changed).compiled_by(&std::env::current_exe()?);
    let ready = Gpu::new(options).map_err(RenderError::from).and_then(|gpu| Ok((gpu, load(&task.load, &library)?)));
    let (gpu, subject) = match ready {
        Ok(ready) => ready,
        Err(error) => return tell(output, &failed(&error), &[]),
    };
    tell(output, &Answer::Ready, &[])?;
    let messages = gpu.messages();
    let mut renderers: HashMap<u64, Renderer> = HashMap::new();
    for request in lines {
        match serde_json::from_str(&request?)? {
            Request::Forget(number) => drop(renderers.remove(&number)),
            Request::Draw(number, text, anew) => {
                let scene = parse(&text)?;
                let renderer = renderers.entry(number).or_insert_with(|| Renderer::new(&gpu, &library, &subject));
                if anew {
                    renderer.invalidate_shadows();
                }
                let drawn = renderer.render(&scene);
                let said = messages.take(); // of the validation layer
                let answer = match drawn {
                    Ok(_) if !said.is_empty() => Answer::Failed { reason: said.join("; "), is_lost: false },
                    Ok(frame) => {
                        let answer = Answer::Drawn(frame.size, Box::new(frame.measurements));
                        tell(output, &answer, bytemuck::cast_slice(&frame.pixels))?;
                        continue;
                    }
                    Err(error) => failed(&error),
                };
                tell(output, &answer, &[])?;
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

/// The answer for an error; a device that timed out counts as lost.
fn failed(error: &RenderError) -> Answer {
    let is_lost = match error {
        RenderError::Gpu(error) => error.is_lost() || matches!(error, GpuError::Timeout { .. }),
        _ => false,
    };
    Answer::Failed { reason: error.to_string(), is_lost }
}

fn tell(output: &mut impl Write, answer: &Answer, pixels: &[u8]) -> io::Result<()> {
    output.write_all(line(answer).as_bytes())?;
    output.write_all(pixels)?;
    output.flush()
}
