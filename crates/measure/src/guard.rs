//! The trial of a person's modules before any command draws, evaluates or measures with them: a crash, a hang or a hunger for
//! memory of the GLSL compiler, of the evaluator or of the driver is one line of text.
//!
//! Role: [`try_modules`] has a child process link the programs of a scene, evaluate some places of a picture, and draw a few
//! rays at an object that ships. The child is this very program with a hidden command ([`serve`]). Invariant: all of that has one
//! budget of processor time and one of memory ([`limits`]); a scene whose modules all ship costs nothing.

use hypertexture::gpu::{Gpu, Options};
use hypertexture::render::variant::{Variant, VariantError};
use hypertexture::render::{RenderError, Renderer, Subject, link_cells, watch};
use hypertexture::scene::{self, Object, Scene};
use hypertexture::shader::compile::{self, Answer, CompileError, Failure, Limits, Trial, read, reply, stage};
use hypertexture::shader::{self, Library, Linker};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::path::Path;
use std::time::Duration;
use support::watchdog::processor_time;

/// Name of the hidden command.
pub const COMMAND: &str = "try";
/// Pixels along a side of the picture, and all of them.
const SIDE: u32 = 8;
/// Rays of the picture.
pub const RAYS: u32 = SIDE * SIDE;
/// Samples of a ray, at most. More say nothing else about a module, and take the time of a slow one.
const SAMPLES: u32 = 64;
/// Texels along a side of the volume of shadows, at most.
const SHADOW: u32 = 16;
/// The object in place of one that is no formula, and its voxels: whatever a person's object takes, this takes little.
const STANDS_IN: &str = "pawn";
const RESOLUTION: u32 = 32;
/// Milliseconds on the device from which a software driver's own time is asked for.
const SLOW_MS: f64 = 1000.0;

/// What all of a trial may take, in all of its threads.
pub fn limits() -> Limits {
    Limits { time: Duration::from_secs(10), memory_mib: 2048, answer_bytes: 1 << 16 }
}

/// A scene, and the modules that are not as shipped.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Job {
    scene: String,
    changed: BTreeMap<String, String>,
    draws: bool,
}

/// The files of a scene's programs that do not ship.
pub fn own_files(scene: &Scene, library: &Library) -> Result<BTreeMap<String, String>, VariantError> {
    let mut changed = shader::changed(library);
    if !changed.is_empty() {
        let variants = programs(scene, library)?;
        changed.retain(|path, _| variants.iter().any(|variant| variant.reaches(library, path)));
    }
    Ok(changed)
}

/// The programs of a scene: of its picture, and of its shadows where it casts some.
pub fn programs(scene: &Scene, library: &Library) -> Result<Vec<Variant>, VariantError> {
    let picture = Variant::of(scene, library)?;
    let shadow = scene.light.shadows.then(|| picture.shadow(scene, library)).transpose()?;
    Ok([picture].into_iter().chain(shadow).collect())
}

/// The scene in a few rays at an object that takes no time.
fn small(scene: &Scene) -> Scene {
    let mut small = scene.clone();
    small.image.size = [SIDE; 2];
    // What multiplies rays says nothing about one.
    (small.quality.msaa, small.quality.supersampling) = (1, 1);
    small.quality.samples = small.quality.samples.min(SAMPLES);
    small.light.shadow_resolution = small.light.shadow_resolution.min(SHADOW);
    (small.camera.zoom, small.camera.pan, small.camera.shutter) = (1.0, [0.0; 2], 0.0);
    let parts = small.parts.values_mut().map(|part| &mut part.object);
    for object in parts.chain([&mut small.object]).filter(|object| !object.is_formula()) {
        *object = Object {
            input: STANDS_IN.into(),
            resolution: RESOLUTION,
            iso: None,
            shell: 0.0,
            distance: false,
            ..object.clone()
        };
    }
    small
}

/// Tries the modules of a scene that do not ship in a child process: `program` is the executable of hypertexture. With a name
/// of a device, or an empty one for the device at hand, a few rays are drawn on it: their milliseconds. `is_stale` is asked now
/// and then: once it says yes, the child is ended.
///
/// # Errors
/// Why nothing may be done with them.
pub fn try_modules(
    program: &Path,
    device: Option<&str>,
    (scene, library): (&Scene, &Library),
    is_stale: &dyn Fn() -> bool,
) -> Result<Option<f64>, CompileError> {
    let changed = own_files(scene, library).map_err(|error| CompileError::Refused(error.to_string()))?;
    if changed.is_empty() {
        return Ok(None);
    }
    compile::check_lengths(&changed)?;
    let names = compile::names(&changed);
    let mut bare = scene.clone();
    bare.modules.clear(); // their texts come beside it
    let job = Job { scene: scene::to_text(&bare), changed, draws: device.is_some() };
    let limits = limits();
    let trial = Trial {
        program,
        arguments: &[COMMAND, "--seconds", &limits.time.as_secs().to_string()],
        device,
        limits: &limits,
        failed,
    };
    match trial.ask::<Option<f64>>(&job, is_stale) {
        Ok(Answer::Good(ms)) => Ok(ms),
        Ok(Answer::Bad(text)) => Err(CompileError::Refused(text)),
        Ok(Answer::Untried(reason)) => {
            log::debug!("{names}: no rays are tried: {reason}");
            Ok(None)
        }
        Err(error @ (CompileError::Abandoned | CompileError::Run { .. })) => Err(error),
        Err(error) => Err(CompileError::Refused(format!("{names}: {error}"))),
    }
}

/// What it means that the child has failed after so many stages.
fn failed(stages: usize, failure: Failure) -> CompileError {
    match stages {
        0 => compile::compiler(failure),
        1 => CompileError::Evaluated(failure.to_string()),
        _ => match failure {
            Failure::Late(seconds) => CompileError::Endless { rays: RAYS, seconds },
            failure => CompileError::Driver(failure.to_string()),
        },
    }
}

/// What the child does: reads a scene, tries it, answers.
///
/// # Errors
/// The scene cannot be read or the answer not be written.
pub fn serve(input: impl Read, output: &mut impl Write, options: &Options) -> io::Result<()> {
    let job: Job = read(input)?;
    let scene = scene::parse(&job.scene, "scene").map_err(|error| io::Error::other(error.to_string()))?;
    let library = shader::shipped_with(job.changed).compiled_with_limits();
    let refused = |error: &dyn ToString| Answer::<Option<f64>>::Bad(error.to_string());
    if let Err(error) = link(&scene, &library) {
        return reply(output, &refused(&error));
    }
    stage(output)?;
    let small = small(&scene);
    let answer = match Subject::load(&small, &library, &|_| ()) {
        // An object that a second process does not get says nothing about the text.
        Err(error) => Answer::Untried(error.to_string()),
        Ok(subject) => match watch(&library, &small, &subject) {
            Err(error) => refused(&error),
            Ok(_) if !job.draws => Answer::Good(None),
            Ok(_) => {
                stage(output)?;
                match Gpu::new(&Options { validation: false, cache: None, ..options.clone() }) {
                    Err(error) => Answer::Untried(error.to_string()), // nor does a device
                    Ok(gpu) => match drawn(&gpu, &library, &small, &subject) {
                        Ok(ms) => Answer::Good(Some(ms)),
                        // Of the object that stands in, which the picture does not show.
                        Err(RenderError::NotFinite { .. }) => Answer::Good(None),
                        Err(error) => refused(&error),
                    },
                }
            }
        },
    };
    reply(output, &answer)
}

/// Links the programs of a scene; they are on the disk where they are asked for.
fn link(scene: &Scene, library: &Library) -> Result<(), VariantError> {
    for variant in programs(scene, library)? {
        variant.program(library, Linker::new)?;
    }
    link_cells(&Variant::of(scene, library)?, scene, library)
}

/// How long a picture takes, milliseconds. One that seems to take too long is drawn again: on a device that is the processor,
/// what it takes of that counts, as other programs may use it too.
fn drawn(gpu: &Gpu, library: &Library, scene: &Scene, subject: &Subject) -> Result<f64, RenderError> {
    let mut renderer = Renderer::new(gpu, library, subject);
    let ms = renderer.render(scene)?.measurements.gpu_ms;
    let taken = || processor_time(std::process::id());
    let Some(before) = taken().filter(|_| ms > SLOW_MS && gpu.info().cpu) else { return Ok(ms) };
    renderer.render(scene)?;
    Ok(taken().map_or(ms, |after| ms.min(1e3 * (after - before).as_secs_f64())))
}
