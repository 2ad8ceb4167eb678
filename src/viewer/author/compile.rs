//! The GLSL compiler in a process of its own, with limits: glslang crashes on an expression of 20 000 terms and does not
//! end on a macro that doubles thirty times.
//!
//! The child is this very program with a hidden command. It reads a [`Job`] as TOML from standard input and answers on
//! standard output: a line that says what follows, then SPIR-V or the text of the error.

use super::arrays;
use crate::render::variant::Variant;
use crate::shader::{self, Library, Linker, Slots, Stage};
use crate::support::child::{self, End};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

pub use crate::support::child::{Limits, limit};

/// Name of the hidden command.
pub const COMMAND: &str = "compile";
/// The longest text of a module that is compiled, in bytes.
const MAX_SOURCE: usize = 256 << 10;
/// The longest job that a child reads, in bytes: every module of a library at its longest would not fit, none needs to.
const MAX_JOB: u64 = 16 << 20;
/// The largest array of a program, in bytes: larger ones keep a driver busy for minutes when it makes the pipeline.
const MAX_ARRAY: u64 = 64 << 10;
/// First lines of an answer.
const GOOD: &[u8] = b"spirv\n";
const BAD: &[u8] = b"error\n";
/// What shaderc says of an exception in glslang, for which none is left to say: its memory has come to an end.
const NO_MEMORY: &[u8] = b"internal error";

/// Programs to be linked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Job {
    /// Files that are not as shipped: path relative to the `glsl` folder, and text.
    pub changed: BTreeMap<String, String>,
    /// What to link.
    pub programs: Vec<Wanted>,
}

/// One program to be linked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wanted {
    /// Entry files: vertex stage, fragment stage.
    pub entries: [String; 2],
    /// The modules of its slots.
    pub slots: Slots,
}

impl Job {
    /// The programs of `variants`, out of `library`.
    pub fn new<'a>(library: &Library, variants: impl IntoIterator<Item = &'a Variant>) -> Job {
        let wanted =
            |variant: &Variant| Wanted { entries: variant.entries.map(String::from), slots: variant.slots.clone() };
        Job { changed: shader::changed(library), programs: variants.into_iter().map(wanted).collect() }
    }

    /// The modules that ship, with those that are not as shipped.
    pub(super) fn library(&self) -> Library {
        shader::shipped_with(self.changed.clone())
    }
}

/// SPIR-V of a linked program: vertex stage, fragment stage.
pub type Spirv = [Vec<u32>; 2];

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
    #[error(
        "the GLSL compiler crashed on this text ({0}); make its longest expression or its arrays shorter; what ran before \
         goes on"
    )]
    Crashed(String),
    /// The compiler did not end.
    #[error("the GLSL compiler was stopped after {0:.1} s; a macro or a constant of this text grows without end")]
    Late(f32),
    /// The compiler took all the memory that it may.
    #[error("the GLSL compiler needs more than {0} MiB for this text; a macro or a constant of it grows without end")]
    Memory(u64),
    /// The driver did not survive the program.
    #[error("the driver crashed on this text ({0}); make its arrays or its loops shorter; what ran before goes on")]
    Driver(String),
    /// A few rays do not end.
    #[error("{rays} rays did not end in {seconds:.0} s: a loop of this text is too long; what ran before goes on")]
    Endless {
        /// How many rays.
        rays: u32,
        /// How long they were waited for.
        seconds: f32,
    },
    /// A few rays take too long.
    #[error(
        "{rays} rays took {ms:.0} ms on the device, and {most:.0} ms are the most: make the loops of this text shorter; \
         what ran before goes on"
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

/// Links the programs of a job in a child process; `program` is the executable of hypertexture. `is_stale` is asked now
/// and then: once it says yes, the child is ended.
///
/// # Errors
/// [`CompileError`]; whatever the text does to the compiler.
pub fn compile(
    program: &Path,
    job: &Job,
    limits: &Limits,
    is_stale: &dyn Fn() -> bool,
) -> Result<Vec<Spirv>, CompileError> {
    if let Some((path, text)) = job.changed.iter().find(|(_, text)| text.len() > MAX_SOURCE) {
        return Err(CompileError::Long { path: path.clone(), bytes: text.len() });
    }
    let run = |reason: String| CompileError::Run { path: program.into(), reason };
    let text = toml::to_string(job).map_err(|error| run(error.to_string()))?;
    let (seconds, memory) = (limits.time.as_secs().max(1).to_string(), limits.memory_mib.to_string());
    let arguments = [COMMAND, "--seconds", &seconds, "--memory-mib", &memory];
    let answer = match child::run(program, &arguments, &[], text, limits, is_stale).map_err(run)? {
        End::Well(answer) => answer,
        End::Badly(how) => return Err(CompileError::Crashed(how)),
        End::Late(time) => return Err(CompileError::Late(time.as_secs_f32())),
        End::Abandoned => return Err(CompileError::Abandoned),
    };
    match (answer.strip_prefix(BAD), answer.strip_prefix(GOOD)) {
        (Some(text), _) if text == NO_MEMORY => Err(CompileError::Memory(limits.memory_mib)),
        (Some(text), _) => Err(CompileError::Refused(String::from_utf8_lossy(text).into_owned())),
        (_, Some(bytes)) => decode(bytes).ok_or_else(|| run("its answer is cut off".into())),
        _ => Err(run("its answer is none".into())),
    }
}

/// What the child does: reads a job, links its programs, answers.
///
/// # Errors
/// The job cannot be read or the answer not be written.
pub fn serve(input: impl Read, output: &mut impl Write) -> io::Result<()> {
    let mut text = String::new();
    input.take(MAX_JOB).read_to_string(&mut text)?;
    let job: Job =
        toml::from_str(&text).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error.to_string()))?;
    let linked = link(&job).map_err(|error| error.to_string()).and_then(|programs| {
        let largest = programs.iter().flatten().map(|module| arrays::largest(module)).max().unwrap_or_default();
        if largest <= MAX_ARRAY {
            return Ok(programs);
        }
        Err(format!(
            "an array of {largest} bytes; one may have at most {MAX_ARRAY}, since a driver makes a pipeline of more for minutes"
        ))
    });
    match linked {
        Ok(programs) => {
            output.write_all(GOOD)?;
            for module in programs.iter().flatten() {
                output.write_all(&(module.len() as u32).to_le_bytes())?;
                output.write_all(bytemuck::cast_slice(module))?;
            }
        }
        Err(error) => {
            output.write_all(BAD)?;
            output.write_all(error.as_bytes())?;
        }
    }
    output.flush()
}

fn link(job: &Job) -> Result<Vec<Spirv>, shader::LinkError> {
    let library = job.library();
    let linker = Linker::new()?;
    let program = |wanted: &Wanted| {
        let entries = wanted.entries.each_ref().map(String::as_str);
        let link = |index: usize, stage| linker.link(&library, (entries[index], stage), &entries, &wanted.slots);
        Ok([link(0, Stage::Vertex)?, link(1, Stage::Fragment)?])
    };
    job.programs.iter().map(program).collect()
}

fn decode(mut bytes: &[u8]) -> Option<Vec<Spirv>> {
    let mut modules = Vec::new();
    while !bytes.is_empty() {
        let (count, rest) = bytes.split_first_chunk::<4>()?;
        let (words, rest) = rest.split_at_checked(u32::from_le_bytes(*count) as usize * 4)?;
        let words = words.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
        modules.push(words.collect());
        bytes = rest;
    }
    let mut modules = modules.into_iter();
    let mut programs = Vec::new();
    while let Some(vertex) = modules.next() {
        programs.push([vertex, modules.next()?]);
    }
    Some(programs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_have_file_and_line_where_the_message_names_them() {
        let message = "dmf/fur.glsl:12: error: 'qq' : undeclared identifier\nstone:dmf/fire.glsl#2:3: error: '' : \
                       compilation terminated \n2 errors generated.";
        let faults = Fault::all(message);
        assert_eq!(faults.len(), 2);
        assert_eq!(faults[0].at, Some(("dmf/fur.glsl".into(), 12)));
        assert_eq!(faults[0].text, "error: 'qq' : undeclared identifier");
        assert_eq!(faults[1].at, Some(("dmf/fire.glsl".into(), 3)));
        assert_eq!(Fault::all("no module `x`"), [Fault { at: None, text: "no module `x`".into() }]);
    }

    #[test]
    fn an_answer_that_is_cut_off_is_no_program() {
        let whole = [2, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0];
        assert_eq!(decode(&whole), Some(vec![[vec![1, 2], vec![3]]]));
        assert!((1..whole.len()).all(|length| decode(&whole[..length]).is_none()));
    }
}
