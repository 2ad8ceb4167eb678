//! The GLSL compiler in a process of its own, with limits: glslang crashes on an expression of 20 000 terms and does not
//! end on a macro that doubles thirty times.
//!
//! The child is this very program with a hidden command: it links a [`Job`] and answers with the programs.

mod allowed;
mod ask;
mod error;

use super::{Library, LinkError, Linker, Slots, Stage};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::path::Path;

pub use allowed::refusal;
pub use ask::{Answer, Failure, Trial, read, reply, stage};
use error::MAX_SOURCE;
pub use error::{CompileError, Fault};

pub use support::child::{Limits, limit};

/// Name of the hidden command.
pub const COMMAND: &str = "compile";

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
    /// Whether what has no effect is taken out of it.
    pub is_optimized: bool,
}

/// SPIR-V of the vertex stage and the fragment stage.
type Stages = [Vec<u32>; 2];

/// Links both stages of the programs of a job in a child process; `program` is the executable of hypertexture. `is_stale` is
/// asked now and then: once it says yes, the child is ended.
///
/// # Errors
/// [`CompileError`]; whatever the text does to the compiler.
pub fn compile(
    program: &Path,
    job: &Job,
    limits: &Limits,
    is_stale: &dyn Fn() -> bool,
) -> Result<Vec<[Vec<u32>; 2]>, CompileError> {
    check_lengths(&job.changed)?;
    let (seconds, memory) = (limits.time.as_secs().max(1).to_string(), limits.memory_mib.to_string());
    let trial = Trial {
        program,
        arguments: &[COMMAND, "--seconds", &seconds, "--memory-mib", &memory],
        device: None,
        limits,
        failed: |_, failure| compiler(failure),
    };
    match trial.ask(job, is_stale)? {
        Answer::Good(programs) => Ok(programs),
        Answer::Bad(text) if text == LinkError::Memory.to_string() => Err(CompileError::Memory(limits.memory_mib)),
        Answer::Bad(text) | Answer::Untried(text) => Err(CompileError::Refused(text)),
    }
}

/// Whether no text is too long to be tried.
pub fn check_lengths(changed: &BTreeMap<String, String>) -> Result<(), CompileError> {
    match changed.iter().find(|(_, text)| text.len() > MAX_SOURCE) {
        Some((path, text)) => Err(CompileError::Long { path: path.clone(), bytes: text.len() }),
        None => Ok(()),
    }
}

/// What it means that the compiler has failed.
pub fn compiler(failure: Failure) -> CompileError {
    match failure {
        Failure::Crashed(how) => CompileError::Crashed(how),
        Failure::Late(seconds) => CompileError::Late(seconds),
        Failure::Large(mib) => CompileError::Memory(mib),
    }
}

/// What the child does: reads a job, links its programs, answers.
///
/// # Errors
/// The job cannot be read or the answer not be written.
pub fn serve(input: impl Read, output: &mut impl Write) -> io::Result<()> {
    let job: Job = read(input)?;
    reply(output, &link(&job).map_or_else(|error| Answer::Bad(error.to_string()), Answer::Good))
}

/// The files that are not as shipped, as a line names them.
pub fn names(changed: &BTreeMap<String, String>) -> String {
    changed.keys().cloned().collect::<Vec<_>>().join(", ")
}

/// Both stages of each program.
fn link(job: &Job) -> Result<Vec<Stages>, LinkError> {
    let library = super::shipped_with(job.changed.clone());
    let program = |wanted: &Wanted| {
        let linker = if wanted.is_optimized { Linker::new()? } else { Linker::new()?.unoptimized() };
        let entries = wanted.entries.each_ref().map(String::as_str);
        link_allowed(&linker, &library, entries, &wanted.slots, || names(&job.changed))
    };
    job.programs.iter().map(program).collect()
}

/// Links both stages of a program that holds nothing which a program with text of a person may not hold; `names` are the
/// files of that text.
pub fn link_allowed(
    linker: &Linker,
    library: &Library,
    entries: [&str; 2],
    slots: &Slots,
    names: impl FnOnce() -> String,
) -> Result<Stages, LinkError> {
    let link = |index: usize, stage| linker.link(library, entries[index], stage, &entries, slots);
    let stages = link(0, Stage::Vertex).and_then(|vertex| Ok([vertex, link(1, Stage::Fragment)?]));
    let stages = stages.map_err(|error| missing(library, slots, error))?;
    match stages.iter().find_map(|module| refusal(module)) {
        Some(refusal) => Err(LinkError::Compile(format!("{}: {refusal}", names()))),
        None => Ok(stages),
    }
}

/// An error of a program in which a function is missing: where that shows is a text of the linker, or one that ships.
fn missing(library: &Library, slots: &Slots, error: LinkError) -> LinkError {
    let LinkError::Compile(message) = &error else { return error };
    let files = slots.iter().filter_map(|(key, names)| library.files(key.rsplit('.').next()?, names).ok());
    let files: Vec<String> = files.flatten().map(|file| file.split('#').next().unwrap_or_default().into()).collect();
    let own = |file: &String| super::shipped().source(file) != library.source(file);
    let is_own = |fault: Fault| fault.at.is_some_and(|(file, _)| own(&file));
    if Fault::all(message).into_iter().any(is_own) {
        return error;
    }
    let lacking = files.iter().filter(|file| own(file)).find_map(|file| Some((file, library.lacking(file)?)));
    match lacking {
        None => error,
        Some((file, (head, found))) => {
            let found = if found.is_empty() { "no function".into() } else { found.join(", ") };
            LinkError::Compile(format!("{file}: it has no `{head}`, by which it is called; it has {found}"))
        }
    }
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
}
