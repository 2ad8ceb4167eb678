//! The beginning of every command that draws or exports a scene: checks, modules and object, in one order.
//!
//! Role: [`CheckedScene::prepare`] checks the outputs, tries custom modules in a sandbox, loads the object, and searches the
//! values of custom modules for NaN and infinities. Invariant: a refusal comes before any output is touched.

use super::device::{checked, try_in_sandbox};
use super::files::check_folder;
use crate::arguments::{SceneInput, files_read};
use crate::terminal::with_progress;
use hypertexture::gpu::Options;
use hypertexture::output;
use hypertexture::render::variant::Variant;
use hypertexture::render::{ModuleFault, Subject, find_module_fault, widest};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The scene of a command after its checks.
pub(crate) struct CheckedScene {
    /// The scene with its motion.
    pub(crate) moving: Scene,
    /// The scene before the arguments.
    pub(crate) base: Scene,
    /// The scene at its time.
    pub(crate) variant: Variant,
    /// Shipped modules and those of the scene.
    pub(crate) library: Library,
}

/// Outputs of a command.
pub(crate) enum Outputs {
    /// Files, with the options that name them.
    Files(Vec<(&'static str, PathBuf)>),
    /// A folder.
    Folder(PathBuf),
}

impl Outputs {
    /// No outputs.
    pub(crate) const NONE: Outputs = Outputs::Files(Vec::new());

    /// The files.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        let files = match self {
            Outputs::Files(files) => files.as_slice(),
            Outputs::Folder(_) => &[],
        };
        files.iter().map(|(_, file)| file.as_path())
    }

    /// Checks that the outputs can be written, and that no file of them is in `read`.
    fn check(&self, read: impl IntoIterator<Item = PathBuf>) -> Result<(), Box<dyn Error>> {
        match self {
            Outputs::Files(files) => output::check_all(files.iter().cloned(), read)?,
            Outputs::Folder(folder) => check_folder(folder)?,
        }
        Ok(())
    }
}

/// Parameters of the preparation of a scene.
#[derive(Clone, Copy)]
pub(crate) struct Preparation<'a> {
    /// Input of the command.
    pub(crate) input: &'a str,
    /// Outputs of the command.
    pub(crate) outputs: &'a Outputs,
    /// Device on which the sandbox draws; `None` for commands without a device.
    pub(crate) device: Option<&'a Options>,
    /// Whether the field of the object serves every moment of the scene.
    pub(crate) serves_all_moments: bool,
    /// Whether to hide the progress.
    pub(crate) quiet: bool,
}

/// Scene, modules and object of a command, ready for a device.
pub(crate) struct Prepared {
    /// The scene with its motion.
    pub(crate) moving: Scene,
    /// The scene before the arguments.
    pub(crate) base: Scene,
    /// The scene at its time.
    pub(crate) variant: Variant,
    /// Shipped modules and those of the scene.
    pub(crate) library: Library,
    /// The object.
    pub(crate) subject: Subject,
    /// First NaN or infinity of a custom module.
    pub(crate) fault: Option<ModuleFault>,
    /// Start of the loading.
    pub(crate) began: Instant,
    /// Milliseconds of the loading.
    pub(crate) loading_ms: f64,
}

impl CheckedScene {
    /// Checks the scene of a command line. Custom modules are compiled in a child process.
    ///
    /// # Errors
    /// A fault of the scene.
    pub(crate) fn of(SceneInput { scene: moving, base, .. }: SceneInput) -> Result<CheckedScene, Box<dyn Error>> {
        let (variant, library) = checked(&moving)?;
        Ok(CheckedScene { moving, base, variant, library })
    }

    /// Checks a scene with modules of `library`.
    ///
    /// # Errors
    /// A fault of the scene.
    #[cfg(feature = "viewer")]
    pub(crate) fn with_library(scene: SceneInput, library: Library) -> Result<CheckedScene, Box<dyn Error>> {
        let SceneInput { scene: moving, base, .. } = scene;
        let variant = Variant::of(&moving, &library)?;
        Ok(CheckedScene { moving, base, variant, library })
    }

    /// Checks the outputs, tries the modules, and loads the object.
    ///
    /// # Errors
    /// An output that cannot be written or is read too, a module that is refused, or an object that cannot be loaded.
    pub(crate) fn prepare(self, preparation: &Preparation<'_>) -> Result<Prepared, Box<dyn Error>> {
        let CheckedScene { moving, base, variant, library } = self;
        let Preparation { input, outputs, device, serves_all_moments, quiet } = *preparation;
        outputs.check(files_read(input, &moving))?;
        try_in_sandbox(&variant, &library, device)?;
        let began = Instant::now();
        let widest = serves_all_moments.then(|| widest(&moving, &library)).transpose()?;
        let loaded = widest.as_ref().unwrap_or(&variant);
        let subject = with_progress(quiet, "distance field", |progress| Subject::load(loaded, &library, progress))?;
        let loading_ms = began.elapsed().as_secs_f64() * 1e3;
        // Other files of the object are known once it is read.
        outputs.check(subject.all_others().cloned())?;
        let fault = find_module_fault(&library, &variant, &subject)?;
        Ok(Prepared { moving, base, variant, library, subject, fault, began, loading_ms })
    }
}
