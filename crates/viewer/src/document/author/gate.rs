//! Admission of programs: shipped ones, and custom ones that survived a compiler, a driver and a few rays in a child
//! process.

use hypertexture::scene::Scene;
use hypertexture::shader::compile::{CompileError, Job};
use hypertexture::shader::{Library, shipped};
use hypertexture_measure::guard::{RAYS, own_files, programs, try_modules};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

/// Limit for the test rays, milliseconds. A window has about a hundred times as many pixels, on a device that is
/// about a hundred times as parallel, or a coarser picture.
const MOST_MS: f64 = 1000.0;

/// Verdicts on programs with custom modules.
pub struct Gate {
    /// Modules that need no test.
    shipped: Library,
    program: PathBuf,
    /// Device of the test rays; without one, modules are only compiled.
    device: Mutex<Option<String>>,
    /// Refusals by program; `None` for a program that passed.
    verdicts: Mutex<HashMap<String, Option<String>>>,
}

fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

impl Gate {
    /// A gate without verdicts. `program` is the executable of the child process: [`std::env::current_exe`].
    pub fn new(program: PathBuf) -> Gate {
        Gate { shipped: shipped(), program, device: Mutex::new(None), verdicts: Mutex::new(HashMap::new()) }
    }

    /// The executable of child processes.
    pub(crate) fn program(&self) -> &Path {
        &self.program
    }

    /// Device of the test rays.
    pub(crate) fn device(&self) -> Option<String> {
        held(&self.device).clone()
    }

    /// Tests programs on the device of this name from now on.
    pub fn try_on(&self, device: &str) {
        *held(&self.device) = Some(device.into());
    }

    /// Whether the programs of a scene may run. Takes seconds the first time, nothing if all modules are shipped
    /// ones.
    ///
    /// # Errors
    /// The reason for a refusal; [`CompileError::Abandoned`] if `is_stale` returns true.
    pub fn validate(&self, scene: &Scene, library: &Library, is_stale: &dyn Fn() -> bool) -> Result<(), CompileError> {
        if *library == self.shipped {
            return Ok(());
        }
        let refused = |error: &dyn ToString| CompileError::Refused(error.to_string());
        let changed = own_files(scene, library).map_err(|error| refused(&error))?;
        if changed.is_empty() {
            return Ok(());
        }
        let wanted = programs(scene, library).map_err(|error| refused(&error))?;
        let jobs: Vec<Job> = wanted.iter().map(|variant| variant.job(changed.clone(), true)).collect();
        let key = format!("{jobs:?}");
        if let Some(verdict) = held(&self.verdicts).get(&key) {
            return verdict.clone().map_or(Ok(()), |reason| Err(CompileError::Refused(reason)));
        }
        let tried = match try_modules(&self.program, self.device().as_deref(), scene, library, is_stale) {
            Ok(Some(ms)) if ms > MOST_MS => Err(CompileError::Slow { rays: RAYS, ms, most: MOST_MS }),
            tried => tried.map(drop),
        };
        let verdict = match &tried {
            Ok(()) => None,
            // These errors are not about the text.
            Err(CompileError::Abandoned | CompileError::Run { .. }) => return tried,
            Err(error) => Some(error.to_string()),
        };
        held(&self.verdicts).insert(key, verdict);
        tried
    }
}
