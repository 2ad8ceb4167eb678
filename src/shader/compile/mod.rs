//! The GLSL compiler in a process of its own, with limits: glslang crashes on an expression of 20 000 terms and does not
//! end on a macro that doubles thirty times.
//!
//! The child is this very program with a hidden command: it links a [`Job`] and answers (a `Trial`).

use super::arrays;
use super::ask::{Answer, Trial, read, reply};
use super::error::MAX_SOURCE;
use crate::render::variant::Variant;
use crate::shader::{self, Library, Linker, Slots, Stage};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::path::Path;

pub use super::error::{CompileError, Fault};
pub use crate::support::child::{Limits, limit};

/// Name of the hidden command.
pub const COMMAND: &str = "compile";
/// The largest array of a program, in bytes: larger ones keep a driver busy for minutes when it makes the pipeline.
const MAX_ARRAY: u64 = 64 << 10;
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
}

impl Job {
    /// The programs of `variants`, out of `library`.
    pub fn new<'a>(library: &Library, variants: impl IntoIterator<Item = &'a Variant>) -> Job {
        let wanted =
            |variant: &Variant| Wanted { entries: variant.entries.map(String::from), slots: variant.slots.clone() };
        Job { changed: shader::changed(library), programs: variants.into_iter().map(wanted).collect() }
    }
}

/// Links the programs of a job in a child process; `program` is the executable of hypertexture. `is_stale` is asked now
/// and then: once it says yes, the child is ended.
///
/// # Errors
/// [`CompileError`]; whatever the text does to the compiler.
pub fn compile(program: &Path, job: &Job, limits: &Limits, is_stale: &dyn Fn() -> bool) -> Result<(), CompileError> {
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
        Answer::Bad(text) if text == NO_MEMORY => Err(CompileError::Memory(limits.memory_mib)),
        Answer::Bad(text) => Err(CompileError::Refused(text)),
        Answer::Good(_) | Answer::Untried(_) => Ok(()),
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
        Ok(programs) => match programs.iter().flatten().map(|module| arrays::largest(module)).max() {
            Some(largest) if largest > MAX_ARRAY => Answer::Bad(format!(
                "an array of {largest} bytes; one may have at most {MAX_ARRAY}, since a driver makes a pipeline of more for \
                 minutes"
            )),
            _ => Answer::Good(0.0),
        },
    };
    reply(output, &answer)
}

/// Vertex stage and fragment stage of each program.
fn link(job: &Job) -> Result<Vec<[Vec<u32>; 2]>, shader::LinkError> {
    let library = shader::shipped_with(job.changed.clone());
    let linker = Linker::new()?;
    let program = |wanted: &Wanted| {
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

    #[test]
    fn a_child_links_the_same_program_as_the_window() {
        let text =
            "float ripples(float density, Sample s) {\n    return density * (0.5 + 0.5 * cos(9.0 * density));\n}\n";
        let library = shader::shipped().with_module("dmf", "ripples", text);
        let mut scene = crate::scene::preset("fur").unwrap();
        scene.parameters.clear();
        (scene.effect.dmf, scene.effect.medium) = (vec!["ripples".into()], "lit".into());
        let variant = Variant::of(&scene, &library).unwrap();
        let here = variant.program(&library, Linker::new).unwrap();
        assert_eq!(link(&Job::new(&library, &[variant])).unwrap(), [[here.vertex, here.fragment]]);
    }
}
