//! What is wrong with a text, and where.

use std::path::PathBuf;

/// The longest text of a module that is compiled, in bytes.
pub(super) const MAX_SOURCE: usize = 256 << 10;

/// Why there is no program.
#[derive(Debug, thiserror::Error)]
pub enum CompileError {
    /// The compiler says what is wrong.
    #[error("{0}")]
    Refused(String),
    /// A text is too long to be tried.
    #[error("{path}: {bytes} bytes, and a module has at most {MAX_SOURCE}")]
    Long {
        /// The module.
        path: String,
        /// Its length.
        bytes: usize,
    },
    /// The compiler did not survive the text.
    #[error("the GLSL compiler crashed on this text ({0}); make its longest expression or its arrays shorter")]
    Crashed(String),
    /// The compiler did not end.
    #[error(
        "the GLSL compiler was stopped after {0:.1} s of the processor; a macro, a constant or functions that call each other \
         grow without end"
    )]
    Late(f32),
    /// The compiler took all the memory that it may.
    #[error(
        "the GLSL compiler needs more than {0} MiB for this text; a macro, a constant or functions that call each other grow \
         without end"
    )]
    Memory(u64),
    /// The program of the text cannot be evaluated within limits.
    #[error(
        "the program of this text {0} when it was evaluated in f64; make its arrays, its functions or its loops shorter"
    )]
    Evaluated(String),
    /// The driver did not survive the program.
    #[error("the driver {0} on this text; make its arrays, its functions or its loops shorter")]
    Driver(String),
    /// A few rays do not end.
    #[error(
        "the driver did not compile and draw {rays} rays within {seconds:.0} s of the processor: an array, a function or a loop \
         of this text is too long"
    )]
    Endless {
        /// How many rays.
        rays: u32,
        /// Seconds of the processor that they had.
        seconds: f32,
    },
    /// A few rays take too long.
    #[error(
        "{rays} rays took {ms:.0} ms on the device, and {most:.0} ms are the most: make the loops of this text shorter"
    )]
    Slow {
        /// How many rays.
        rays: u32,
        /// Milliseconds on the device.
        ms: f64,
        /// Milliseconds that they may take.
        most: f64,
    },
    /// A newer text has come.
    #[error("given up for a newer text")]
    Abandoned,
    /// The child cannot be run or understood.
    #[error("the GLSL compiler cannot be run as `{}`: {reason}", path.display())]
    Run {
        /// The program.
        path: PathBuf,
        /// What went wrong.
        reason: String,
    },
}

/// One thing that is wrong, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// File and line, from 1, where the message names them.
    pub at: Option<(String, usize)>,
    /// What is wrong.
    pub text: String,
}

impl Fault {
    /// The faults in a message of several lines, `path:line: text` each.
    pub fn all(message: &str) -> Vec<Fault> {
        let lines = message.lines().map(str::trim).filter(|line| !line.is_empty());
        let found = lines.map(|line| {
            // A second copy of a module is `dmf/fur.glsl#2`, one of an additional object `stone:dmf/fur.glsl`.
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
