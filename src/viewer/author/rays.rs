//! A few rays of a new program, in a process of its own: a loop that is too long, or what a driver does not survive, is a
//! line of text before the window's own device meets it.
//!
//! The child is this very program with a hidden command: it renders a picture of 8 x 8 pixels of a scene with the texts, on
//! a device of its own, and answers (a `Trial`).

use crate::gpu::{Gpu, Options};
use crate::render::{RenderError, Renderer, Subject, watch};
use crate::scene::{self, Scene};
use crate::shader;
use crate::shader::compile::{Answer, CompileError, Job, Trial, read, reply};
use crate::support::child::Limits;
use crate::support::watch::processor_time;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::path::Path;
use std::time::Duration;

/// Name of the hidden command.
pub const COMMAND: &str = "rays";
/// Pixels along a side of the picture, and all of them.
const SIDE: u32 = 8;
const RAYS: u32 = SIDE * SIDE;
/// Milliseconds that it may take. A window has some hundred times as many pixels, on a device that draws some hundred
/// times as many at once, or in a coarser picture.
const MOST_MS: f64 = 1000.0;
/// Processor time for all of it: a device, a small field, a pipeline, and the rays.
const TIME: Duration = Duration::from_secs(20);
/// Voxels along the longest side of the field: it is computed beside the one of the window, and must not take as long.
const RESOLUTION: u32 = 48;

/// A scene, and the modules that are not as shipped.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TrialJob {
    scene: String,
    changed: BTreeMap<String, String>,
}

/// The scene in a few rays at its object.
fn small(scene: &Scene) -> Scene {
    let mut small = scene.clone();
    small.modules.clear(); // their texts come beside it
    small.image.size = [SIDE; 2];
    // What multiplies rays says nothing about one, and shadows are as large for a small picture.
    (small.quality.msaa, small.quality.supersampling, small.light.shadows) = (1, 1, false);
    (small.camera.zoom, small.camera.pan, small.camera.shutter) = (1.0, [0.0; 2], 0.0);
    let parts = small.parts.values_mut().map(|part| &mut part.object);
    for object in parts.chain([&mut small.object]) {
        object.resolution = object.resolution.min(RESOLUTION);
    }
    small
}

/// Renders a few rays of the scene in a child process, on the device of that name. `job` holds the modules that are not as
/// shipped.
///
/// # Errors
/// The rays take too long, or the driver does not survive them.
pub(super) fn trial_render(
    program: &Path,
    device: &str,
    scene: &Scene,
    job: &Job,
    is_stale: &dyn Fn() -> bool,
) -> Result<(), CompileError> {
    let job = TrialJob { scene: scene::to_text(&small(scene)), changed: job.changed.clone() };
    let limits = Limits { time: TIME, answer_bytes: 1 << 16, ..Limits::default() };
    let trial = Trial {
        program,
        arguments: &[COMMAND, "--seconds", &TIME.as_secs().to_string()],
        device: Some(device),
        limits: &limits,
        crashed: CompileError::Driver,
        late: |seconds| CompileError::Endless { rays: RAYS, seconds },
    };
    match trial.ask::<f64>(&job, is_stale)? {
        Answer::Good(ms) if ms > MOST_MS => Err(CompileError::Slow { rays: RAYS, ms, most: MOST_MS }),
        Answer::Good(_) => Ok(()),
        Answer::Bad(text) => Err(CompileError::Refused(text)),
        Answer::Untried(reason) => {
            log::warn!("new programs are not tried before the window draws them: {reason}");
            Ok(())
        }
    }
}

/// What the child does: reads a scene, renders it, answers.
///
/// # Errors
/// The scene cannot be read or the answer not be written.
pub fn serve(input: impl Read, output: &mut impl Write, options: &Options) -> io::Result<()> {
    let job: TrialJob = read(input)?;
    let scene = scene::parse(&job.scene, "scene").map_err(|error| io::Error::other(error.to_string()))?;
    let library = shader::shipped_with(job.changed);
    let gpu = Gpu::new(&Options { validation: false, cache: None, ..options.clone() });
    let ready = gpu.map_err(|error| error.to_string()).and_then(|gpu| {
        let subject = Subject::load(&scene, &library, &|_| ()).map_err(|error| error.to_string())?;
        Ok((gpu, subject))
    });
    let answer = match ready {
        // A device or an object that a second process does not get says nothing about the text.
        Err(reason) => Answer::Untried(reason),
        Ok((gpu, subject)) => {
            let mut renderer = Renderer::new(&gpu, &library, &subject);
            renderer
                .render(&scene)
                .and_then(|frame| again(&gpu, &mut renderer, &scene, frame.measurements.gpu_ms))
                .and_then(|ms| if ms > MOST_MS { Ok(ms) } else { watch(&library, &scene, &subject).map(|_| ms) })
                .map_or_else(|error| Answer::Bad(error.to_string()), Answer::Good)
        }
    };
    reply(output, &answer)
}

/// How long a picture takes that seems to take too long: on a device that is the processor, what it takes of that, as
/// other programs may use it too.
fn again(gpu: &Gpu, renderer: &mut Renderer, scene: &Scene, ms: f64) -> Result<f64, RenderError> {
    let taken = || processor_time(std::process::id());
    let Some(before) = taken().filter(|_| ms > MOST_MS && gpu.info().cpu) else { return Ok(ms) };
    renderer.render(scene)?;
    Ok(taken().map_or(ms, |after| ms.min(1e3 * (after - before).as_secs_f64())))
}
