//! Trial of custom modules in a child process, before any command uses them: a crash, a hang or excessive memory of the GLSL
//! compiler, the evaluator or the driver becomes one line of text.
//!
//! Role: [`try_modules`] links the programs of a scene, evaluates some places of its picture, and renders a few rays of a
//! shipped object, all in a child ([`serve`]). Invariant: one budget of processor time and memory; a scene of
//! shipped modules starts no child, and modules that cannot be tried are refused.

use hypertexture::gpu::{Gpu, Options};
use hypertexture::render::variant::{Checkable, Purpose, Variant, VariantError};
use hypertexture::render::{RenderError, Renderer, Subject, find_module_fault, link_cells};
use hypertexture::scene::{self, Object, Scene};
use hypertexture::shader::compile::{self, CompileError};
use hypertexture::shader::{self, Library, Linker};
use hypertexture_support::jobs::{Child, Ended, Limits, Parent};
use hypertexture_support::watchdog::processor_time;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// Name of the job.
pub const JOB: &str = "try";
/// Pixels along a side of the picture.
const SIDE: u32 = 8;
/// Number of rays of the picture.
pub const RAYS: u32 = SIDE * SIDE;
/// Largest number of samples of a ray. Higher: a slow module takes longer, and no further fault is found.
const SAMPLES: u32 = 64;
/// Largest side of the shadow volume, texels.
const SHADOW: u32 = 16;
/// Object in place of meshes and volumes, and its voxels; it loads fast.
const STAND_IN: &str = "pawn";
const RESOLUTION: u32 = 32;
/// Milliseconds on the device from which the processor time of a software driver is measured.
const SLOW_MS: f64 = 1000.0;

/// Limits of a trial, over all of its threads.
fn limits() -> Limits {
    Limits { memory_mib: 2048, ..Limits::default() }
}

/// A scene, and the modules that differ from the shipped ones.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Job {
    scene: String,
    changed: BTreeMap<String, String>,
    draws: bool,
}

/// Verdict on a scene.
#[derive(Debug, Serialize, Deserialize)]
enum Answer {
    /// The modules are good; milliseconds of the rays, if drawn.
    Good(Option<f64>),
    /// They are refused, or cannot be tried, with the reason.
    Bad(String),
}

/// Files of a scene's programs that differ from the shipped ones.
pub fn own_files(scene: &impl Checkable, library: &Library) -> Result<BTreeMap<String, String>, VariantError> {
    let mut changed = shader::changed(library);
    if !changed.is_empty() {
        let variants = programs(scene, library)?;
        changed.retain(|path, _| variants.iter().any(|variant| variant.reaches(library, path)));
    }
    Ok(changed)
}

/// Files of a scene's programs whose text is neither the shipped one nor that of the scene's files.
pub fn edited(scene: &impl Checkable, library: &Library) -> Result<Vec<String>, VariantError> {
    let programs = programs(scene, library)?;
    let filed = programs[0].scene.library().unwrap_or_else(|_| shader::shipped());
    let changed = library.sources().filter(|(path, text)| filed.source(path) != Some(text)).map(|(path, _)| path);
    let used = changed.filter(|path| programs.iter().any(|program| program.reaches(library, path)));
    Ok(used.map(String::from).collect())
}

/// Programs of a scene: of its picture, and of its shadows if it casts any.
pub fn programs(scene: &impl Checkable, library: &Library) -> Result<Vec<Variant>, VariantError> {
    let picture = scene.checked(library)?.into_owned();
    let shadow = picture.scene.light.shadows.then(|| picture.for_purpose(Purpose::Shadow, library)).transpose()?;
    Ok([picture].into_iter().chain(shadow).collect())
}

/// The scene in a few rays of an object that loads fast.
fn small(scene: &Scene) -> Scene {
    let mut small = scene.clone();
    small.image.size = [SIDE; 2];
    // Multiples of rays show no further faults.
    (small.quality.msaa, small.quality.supersampling) = (1, 1);
    small.quality.samples = small.quality.samples.min(SAMPLES);
    small.light.shadow_resolution = small.light.shadow_resolution.min(SHADOW);
    (small.camera.zoom, small.camera.pan, small.camera.shutter) = (1.0, [0.0; 2], 0.0);
    let parts = small.parts.values_mut().map(|part| &mut part.object);
    for object in parts.chain([&mut small.object]).filter(|object| !object.is_formula()) {
        *object = Object {
            input: STAND_IN.into(),
            resolution: RESOLUTION,
            iso: None,
            shell: 0.0,
            distance: false,
            ..object.clone()
        };
    }
    small
}

/// Tries the custom modules of a scene in a child process of `program`, the executable of hypertexture. With a name of a
/// device, empty for the default one, a few rays are rendered on it, and their milliseconds returned. The child is ended once
/// `is_stale` returns true.
///
/// # Errors
/// The fault of the modules.
pub fn try_modules(
    program: &Path,
    device: Option<&str>,
    scene: &impl Checkable,
    library: &Library,
    is_stale: &dyn Fn() -> bool,
) -> Result<Option<f64>, CompileError> {
    let refused = |error: VariantError| CompileError::Refused(error.to_string());
    let changed = own_files(scene, library).map_err(refused)?;
    if changed.is_empty() {
        return Ok(None);
    }
    compile::check_lengths(&changed)?;
    let names = compile::names(&changed);
    let mut bare = scene.checked(library).map_err(refused)?.into_owned().scene;
    bare.modules.clear(); // their texts are in `changed`
    let job = Job { scene: scene::to_text(&bare), changed, draws: device.is_some() };
    let mut stages = 0;
    let answer = Child::start(program, device, JOB, &limits()).and_then(|mut child| {
        child.send(&job);
        loop {
            match child.receive::<Option<Answer>>(is_stale)?.0 {
                None => stages += 1,
                Some(answer) => return Ok(answer),
            }
        }
    });
    let error = match (answer, stages) {
        (Ok(Answer::Good(ms)), _) => return Ok(ms),
        (Ok(Answer::Bad(text)), _) => return Err(CompileError::Refused(text)),
        (Err(ended @ (Ended::Cancelled | Ended::Unfit(_))), _) => return Err(CompileError::of(ended, program)),
        (Err(ended), 0) => CompileError::of(ended, program),
        (Err(ended), 1) => CompileError::Evaluated(ended.to_string()),
        (Err(Ended::Late(seconds)), _) => CompileError::Endless { rays: RAYS, seconds },
        (Err(ended), _) => CompileError::Driver(ended.to_string()),
    };
    Err(CompileError::Refused(format!("{names}: {error}")))
}

/// The child process: reads a scene, tries it, and answers; `None` marks the end of a stage.
///
/// # Errors
/// The scene cannot be read, or the answer not be written.
pub fn serve(mut parent: Parent, options: &Options) -> io::Result<()> {
    parent.enforce(true)?;
    let Some(job) = parent.request()? else { return Ok(()) };
    let answer = tried(job, options, &mut || parent.tell(&None::<Answer>, &[]))?;
    parent.tell(&Some(answer), &[])
}

/// Verdict on a scene; `stage` is called at the end of each stage.
fn tried(job: Job, options: &Options, stage: &mut dyn FnMut() -> io::Result<()>) -> io::Result<Answer> {
    let scene = scene::parse(&job.scene, "scene").map_err(|error| io::Error::other(error.to_string()))?;
    let library = shader::shipped_with(job.changed).compiled_with_limits();
    if let Err(error) = link(&scene, &library) {
        return Ok(Answer::Bad(error.to_string()));
    }
    stage()?;
    let load = || -> Result<(Variant, Subject), RenderError> {
        let small = Variant::of(&small(&scene), &library)?;
        let subject = Subject::load(&small, &library, &|_| ())?;
        Ok((small, subject))
    };
    let (small, subject) = match load() {
        Ok(loaded) => loaded,
        // A scene that cannot be loaded, such as its groom, cannot be drawn either.
        Err(error) => return Ok(Answer::Bad(error.to_string())),
    };
    match find_module_fault(&library, &small, &subject) {
        Err(error) => return Ok(Answer::Bad(error.to_string())),
        Ok(_) if !job.draws => return Ok(Answer::Good(None)),
        Ok(_) => stage()?,
    }
    let gpu = match Gpu::new(&Options { validation: false, cache: None, ..options.clone() }) {
        Ok(gpu) => gpu,
        Err(error) => return Ok(Answer::Bad(error.to_string())),
    };
    Ok(match drawn(&gpu, &library, &small, &subject) {
        Ok(ms) => Answer::Good(Some(ms)),
        // The stand-in may be infinite where the object is not.
        Err(RenderError::NotFinite { .. }) => Answer::Good(None),
        Err(error) => Answer::Bad(error.to_string()),
    })
}

/// Links the programs of a scene, which caches them on disk.
fn link(scene: &Scene, library: &Library) -> Result<(), VariantError> {
    let programs = programs(scene, library)?;
    programs.iter().try_for_each(|variant| variant.program(library, Linker::new).map(drop))?;
    link_cells(&programs[0], library)
}

/// Milliseconds of a picture. A slow one is rendered again on a software driver, whose processor time does not depend on the
/// load of the machine.
fn drawn(gpu: &Gpu, library: &Library, scene: &Variant, subject: &Subject) -> Result<f64, RenderError> {
    let mut renderer = Renderer::new(gpu, library, subject);
    let ms = renderer.render(scene)?.measurements.gpu_ms;
    let taken = || processor_time(std::process::id());
    let Some(before) = taken().filter(|_| ms > SLOW_MS && gpu.info().cpu) else { return Ok(ms) };
    renderer.render(scene)?;
    Ok(taken().map_or(ms, |after| ms.min(1e3 * (after - before).as_secs_f64())))
}
