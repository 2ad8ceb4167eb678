//! The GLSL compiler in a process of its own, with limits: glslang crashes on an expression of 20 000 terms and does not
//! end on a macro that doubles thirty times.
//!
//! The child is this very program with a hidden command: it links a [`Job`] and answers with the programs.

mod allowed;
mod ask;
mod error;

use super::{LinkError, Linker, Slots, Stage};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::path::Path;

#[cfg(test)]
pub(crate) use allowed::refusal;
pub(crate) use ask::{Answer, Trial, read, reply};
use error::MAX_SOURCE;
pub use error::{CompileError, Fault};

pub use crate::support::child::{Limits, limit};

/// Name of the hidden command.
pub const COMMAND: &str = "compile";
/// What shaderc says of an exception in glslang, for which none is left to say: its memory has come to an end.
const NO_MEMORY: &str = "internal error";

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
    if let Some((path, text)) = job.changed.iter().find(|(_, text)| text.len() > MAX_SOURCE) {
        return Err(CompileError::Long { path: path.clone(), bytes: text.len() });
    }
    let (seconds, memory) = (limits.time.as_secs().max(1).to_string(), limits.memory_mib.to_string());
    let trial = Trial {
        program,
        arguments: &[COMMAND, "--seconds", &seconds, "--memory-mib", &memory],
        device: None,
        limits,
        crashed: CompileError::Crashed,
        late: CompileError::Late,
    };
    match trial.ask(job, is_stale)? {
        Answer::Good(programs) => Ok(programs),
        Answer::Bad(text) if text == NO_MEMORY => Err(CompileError::Memory(limits.memory_mib)),
        Answer::Bad(text) | Answer::Untried(text) => Err(CompileError::Refused(text)),
    }
}

/// What the child does: reads a job, links its programs, answers.
///
/// # Errors
/// The job cannot be read or the answer not be written.
pub fn serve(input: impl Read, output: &mut impl Write) -> io::Result<()> {
    let job: Job = read(input)?;
    let answer = match link(&job) {
        Err(error) => Answer::Bad(error.to_string()),
        Ok(programs) => match programs.iter().flatten().find_map(|module| allowed::refusal(module)) {
            Some(refusal) => Answer::Bad(format!("{}: {refusal}", names(&job.changed))),
            None => Answer::Good(programs),
        },
    };
    reply(output, &answer)
}

/// The files that are not as shipped, as a line names them.
pub(crate) fn names(changed: &BTreeMap<String, String>) -> String {
    changed.keys().cloned().collect::<Vec<_>>().join(", ")
}

/// Both stages of each program.
fn link(job: &Job) -> Result<Vec<Stages>, LinkError> {
    let library = super::shipped_with(job.changed.clone());
    let program = |wanted: &Wanted| {
        let linker = if wanted.is_optimized { Linker::new()? } else { Linker::new()?.unoptimized() };
        let entries = wanted.entries.each_ref().map(String::as_str);
        let link = |index: usize, stage| linker.link(&library, entries[index], stage, &entries, &wanted.slots);
        Ok([link(0, Stage::Vertex)?, link(1, Stage::Fragment)?])
    };
    job.programs.iter().map(program).collect()
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
