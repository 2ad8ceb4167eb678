//! Which programs may be drawn: those that ship, and those of a user's text that have survived a compiler, a driver and a
//! few rays in a process of its own.

use hypertexture::scene::Scene;
use hypertexture::shader::compile::{CompileError, Job};
use hypertexture::shader::{Library, shipped};
use measure::guard::{RAYS, own_files, programs, try_modules};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard};

/// Milliseconds that the rays may take. A window has some hundred times as many pixels, on a device that draws some hundred
/// times as many at once, or in a coarser picture.
const MOST_MS: f64 = 1000.0;

/// What is known of programs with text of a user.
pub struct Gate {
    /// What needs no trial.
    shipped: Library,
    /// The executable of hypertexture.
    program: PathBuf,
    /// The device that rays are tried on; none, and a text is only compiled.
    device: Mutex<Option<String>>,
    /// What became of the programs that were tried: the line that refuses them, if one does.
    verdicts: Mutex<HashMap<String, Option<String>>>,
}

fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

impl Gate {
    /// Nothing is known yet. `program` is the executable that compiles: [`std::env::current_exe`].
    pub fn new(program: PathBuf) -> Gate {
        Gate { shipped: shipped(), program, device: Mutex::new(None), verdicts: Mutex::new(HashMap::new()) }
    }

    /// From now on a few rays of each program are tried on the device of this name.
    pub fn try_on(&self, device: &str) {
        *held(&self.device) = Some(device.into());
    }

    /// Whether a scene may be drawn with these modules. Takes seconds the first time, nothing where all of it ships.
    ///
    /// # Errors
    /// Why not; [`CompileError::Abandoned`] once `is_stale` says yes.
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
        let job = Job { changed, programs: wanted.iter().map(|variant| variant.wanted(true)).collect() };
        let key = toml::to_string(&job).map_err(|error| refused(&error))?;
        if let Some(verdict) = held(&self.verdicts).get(&key) {
            return verdict.clone().map_or(Ok(()), |reason| Err(CompileError::Refused(reason)));
        }
        let device = held(&self.device).clone();
        let tried = match try_modules(&self.program, device.as_deref(), (scene, library), is_stale) {
            Ok(Some(ms)) if ms > MOST_MS => Err(CompileError::Slow { rays: RAYS, ms, most: MOST_MS }),
            tried => tried.map(drop),
        };
        let verdict = match &tried {
            Ok(()) => None,
            // These say nothing about the text.
            Err(CompileError::Abandoned | CompileError::Run { .. }) => return tried,
            Err(error) => Some(error.to_string()),
        };
        held(&self.verdicts).insert(key, verdict);
        tried
    }
}
