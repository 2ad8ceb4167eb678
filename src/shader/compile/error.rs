//! Errors of user text, with their places.

use hypertexture_support::jobs::Ended;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Longest module text that is compiled, in bytes.
pub(super) const MAX_SOURCE: usize = 256 << 10;

/// Why user text does not become a program.
#[derive(Debug, thiserror::Error)]
pub enum CompileError {
    /// The compiler's message.
    #[error("{0}")]
    Refused(String),
    /// A text is too long.
    #[error("{path}: {bytes} bytes, and a module has at most {MAX_SOURCE}")]
    Long {
        /// The module.
        path: String,
        /// Length in bytes.
        bytes: usize,
    },
    /// The compiler crashed.
    #[error("the GLSL compiler crashed on this text ({0}); make its longest expression or its arrays shorter")]
    Crashed(String),
    /// The compiler exceeded its time limit, seconds.
    #[error(
        "the GLSL compiler was stopped after {0:.1} s of the processor; a macro, a constant or functions that call each other \
         grow without end"
    )]
    Late(f32),
    /// The compiler exceeded its memory limit, MiB.
    #[error(
        "the GLSL compiler needs more than {0} MiB for this text; a macro, a constant or functions that call each other grow \
         without end"
    )]
    Memory(u64),
    /// Evaluation in f64 failed within its limits.
    #[error(
        "the program of this text {0} when it was evaluated in f64; make its arrays, its functions or its loops shorter"
    )]
    Evaluated(String),
    /// The driver crashed.
    #[error("the driver {0} on this text; make its arrays, its functions or its loops shorter")]
    Driver(String),
    /// Test rays exceeded their time limit.
    #[error(
        "the driver did not compile and draw {rays} rays within {seconds:.0} s of the processor: an array, a function or a loop \
         of this text is too long"
    )]
    Endless {
        /// Number of rays.
        rays: u32,
        /// Limit of processor time in seconds.
        seconds: f32,
    },
    /// Test rays are too slow.
    #[error(
        "{rays} rays took {ms:.0} ms on the device, and {most:.0} ms are the most: make the loops of this text shorter"
    )]
    Slow {
        /// Number of rays.
        rays: u32,
        /// Milliseconds on the device.
        ms: f64,
        /// Limit in milliseconds.
        most: f64,
    },
    /// Cancelled in favor of a newer text.
    #[error("cancelled for a newer text")]
    Abandoned,
    /// The child process cannot be run, or its answer not be read.
    #[error("the GLSL compiler cannot be run as `{}`: {reason}", path.display())]
    Run {
        /// The executable.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
}

impl CompileError {
    /// The error of a compiler in a child process of `program`.
    pub fn of(ended: Ended, program: &Path) -> CompileError {
        match ended {
            Ended::Crashed(how) => CompileError::Crashed(how),
            Ended::Late(seconds) => CompileError::Late(seconds),
            Ended::Large(mib) => CompileError::Memory(mib),
            Ended::Cancelled => CompileError::Abandoned,
            Ended::Unfit(reason) => CompileError::Run { path: program.into(), reason },
        }
    }
}

/// The changed files as a list for messages.
pub fn names(changed: &BTreeMap<String, String>) -> String {
    changed.keys().cloned().collect::<Vec<_>>().join(", ")
}

/// One error in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// File and line, from 1, if the message names them.
    pub at: Option<(String, usize)>,
    /// The message.
    pub text: String,
}

impl Fault {
    /// Parses a message of several lines `path:line: text`.
    pub fn all(message: &str) -> Vec<Fault> {
        let lines = message.lines().map(str::trim).filter(|line| !line.is_empty());
        let found = lines.map(|line| {
            // `dmf/fur.glsl#2` is the second copy of a module, `stone:dmf/fur.glsl` the module of an additional object.
            let placed = || {
                let (path, rest) = line.split_at(line.find(".glsl")? + ".glsl".len());
                let (_, rest) = rest.split_once(':').filter(|(copy, _)| copy.is_empty() || copy.starts_with('#'))?;
                let (number, text) = rest.split_once(':')?;
                let path = path.rsplit(':').next().unwrap_or(path).trim();
                Some(Fault { at: Some((path.into(), number.trim().parse().ok()?)), text: text.trim().into() })
            };
            placed().unwrap_or(Fault { at: None, text: line.into() })
        });
        let mut all: Vec<Fault> = Vec::new();
        for fault in found.filter(|fault| !fault.text.ends_with("generated.")) {
            if !all.contains(&fault) {
                all.push(fault);
            }
        }
        all
    }
}
