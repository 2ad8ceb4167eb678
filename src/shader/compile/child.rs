//! Linking user modules in a child process under limits.
//!
//! Role: glslang crashes on an expression of 20 000 terms and never ends on a macro that doubles thirty times, so user text is
//! compiled in a child, which links a [`Job`] and answers with the programs.

use super::allowed::refusal;
use super::error::{CompileError, Fault, MAX_SOURCE};
use crate::shader::{self, Library, LinkError, Linker, Slots, Stage};
use hypertexture_support::jobs::{Child, Limits, Parent};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// Name of the job.
pub const JOB: &str = "compile";

/// A program to link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Job {
    /// Files that differ from the shipped ones: path relative to the `glsl` folder, and text.
    pub changed: BTreeMap<String, String>,
    /// Entry files: vertex stage, fragment stage.
    pub entries: [String; 2],
    /// The modules by slot.
    pub slots: Slots,
    /// Whether the optimizer runs.
    pub is_optimized: bool,
}

/// SPIR-V of vertex and fragment stage.
type Stages = [Vec<u32>; 2];

/// Links the program of a job in a child process that runs `program`, the hypertexture executable. The child is killed once
/// `is_stale`, which is polled, returns true.
///
/// # Errors
/// [`CompileError`], whatever the text does to the compiler.
pub fn compile(
    program: &Path,
    job: &Job,
    limits: &Limits,
    is_stale: &dyn Fn() -> bool,
) -> Result<Stages, CompileError> {
    check_lengths(&job.changed)?;
    let answer = Child::start(program, None, JOB, limits).and_then(|mut child| {
        child.send(job);
        child.receive::<Result<_, String>>(is_stale)
    });
    match answer.map_err(|ended| CompileError::of(ended, program))?.0 {
        Ok(stages) => Ok(stages),
        Err(text) if text == LinkError::Memory.to_string() => Err(CompileError::Memory(limits.memory_mib)),
        Err(text) => Err(CompileError::Refused(text)),
    }
}

/// Checks that no text is too long.
pub fn check_lengths(changed: &BTreeMap<String, String>) -> Result<(), CompileError> {
    match changed.iter().find(|(_, text)| text.len() > MAX_SOURCE) {
        Some((path, text)) => Err(CompileError::Long { path: path.clone(), bytes: text.len() }),
        None => Ok(()),
    }
}

/// Child's side: reads a job, links its program and answers.
///
/// # Errors
/// The job cannot be read, or the answer not be written.
pub fn serve(mut parent: Parent) -> io::Result<()> {
    parent.enforce(false)?;
    let Some(job) = parent.request()? else { return Ok(()) };
    parent.tell(&link(&job).map_err(|error| error.to_string()), &[])
}

/// The changed files as a list for messages.
pub fn names(changed: &BTreeMap<String, String>) -> String {
    changed.keys().cloned().collect::<Vec<_>>().join(", ")
}

/// Links both stages in this process, and applies the restrictions on user text.
pub fn link(job: &Job) -> Result<Stages, LinkError> {
    let library = shader::shipped_with(job.changed.clone());
    let linker = if job.is_optimized { Linker::new()? } else { Linker::new()?.unoptimized() };
    let entries = job.entries.each_ref().map(String::as_str);
    let link = |entry| linker.link(&library, entry, Stage::of(entry), &entries, &job.slots);
    let stages = link(entries[0]).and_then(|vertex| Ok([vertex, link(entries[1])?]));
    let stages = stages.map_err(|error| missing(&library, &job.slots, error))?;
    match stages.iter().find_map(|module| refusal(module)) {
        Some(refusal) => Err(LinkError::Compile(format!("{}: {refusal}", names(&job.changed)))),
        None => Ok(stages),
    }
}

/// Explains a missing function. The compiler reports it in generated text or in a shipped file.
fn missing(library: &Library, slots: &Slots, error: LinkError) -> LinkError {
    let LinkError::Compile(message) = &error else { return error };
    let files = slots.iter().filter_map(|(key, names)| library.files(key.rsplit('.').next()?, names).ok());
    let files: Vec<String> = files.flatten().map(|file| file.split('#').next().unwrap_or_default().into()).collect();
    let is_changed = |file: &String| shader::shipped().source(file) != library.source(file);
    if Fault::all(message).into_iter().any(|fault| fault.at.is_some_and(|(file, _)| is_changed(&file))) {
        return error;
    }
    let lacking = files.iter().filter(|file| is_changed(file)).find_map(|file| Some((file, library.lacking(file)?)));
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
