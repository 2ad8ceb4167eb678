//! The device, the modules and the child processes of a command.

use hypertexture::gpu::{Gpu, GpuError, Options};
use hypertexture::render::RenderError;
use hypertexture::render::variant::{Variant, VariantError};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use hypertexture_measure::guard;
use hypertexture_measure::worker::{PICTURE_TIME, Start};
use std::error::Error;

/// The error of the device behind an error, if any.
pub(crate) fn gpu_error<'a>(error: &'a (dyn Error + 'static)) -> Option<&'a GpuError> {
    match (error.downcast_ref(), error.downcast_ref()) {
        (Some(RenderError::Gpu(error)), _) | (_, Some(error)) => Some(error),
        _ => None,
    }
}

/// Opens the device and calls a function; once more if the device is lost meanwhile. A device that hangs would do so
/// again.
pub(crate) fn with_device<T>(
    options: &Options,
    mut run: impl FnMut(&Gpu) -> Result<T, Box<dyn Error>>,
) -> Result<T, Box<dyn Error>> {
    let done = run(&Gpu::new(options)?);
    let is_lost =
        |error: &(dyn Error + 'static)| gpu_error(error).is_some_and(|own| own.is_lost() && !own.is_timeout());
    match done {
        Err(error) if is_lost(&*error) => {
            ::log::warn!("{error}: the device was lost; it is opened once more");
            run(&Gpu::new(options)?)
        }
        done => done,
    }
}

/// Start of a worker: this executable, on the chosen device.
///
/// # Errors
/// The path of the executable is unknown.
pub fn start(options: &Options) -> Result<Start, Box<dyn Error>> {
    let program = std::env::current_exe()?;
    Ok(Start { program, device: options.device.clone(), patience: PICTURE_TIME })
}

/// The checked scene, and its modules. Those of the user are compiled in a child process.
pub(crate) fn checked(scene: &Scene) -> Result<(Variant, Library), Box<dyn Error>> {
    let library = scene.library()?.compiled_by(&std::env::current_exe()?);
    match Variant::of(scene, &library) {
        Err(VariantError::Scene(error)) => Err(error.into()),
        variant => Ok((variant?, library)),
    }
}

/// Tries custom modules in a child process before any other use; with `options`, on a device as well.
pub(crate) fn try_in_sandbox(
    variant: &Variant,
    library: &Library,
    options: Option<&Options>,
) -> Result<(), Box<dyn Error>> {
    let device = options.map(|options| options.device.as_deref().unwrap_or_default());
    guard::try_modules(&std::env::current_exe()?, device, variant, library, &|| false)?;
    Ok(())
}
