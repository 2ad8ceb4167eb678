//! Linking user modules in a child process under limits.
//!
//! Role: glslang crashes on an expression of 20 000 terms and never ends on a macro that doubles thirty times, so user text is
//! compiled in a child, which links a [`Job`] and answers with the programs.

use super::allowed::refusal;
use super::error::{CompileError, MAX_SOURCE, names};
use super::explain::{check, explained};
use crate::shader::{self, LinkError, Linker, Slots, Stage, find_word, undefined};
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

/// Links both stages in this process, and applies the restrictions on user text.
///
/// # Errors
/// Errors of the compiler, text that a driver must not see, and undefined values: see [`undefined`].
pub fn link(job: &Job) -> Result<Stages, LinkError> {
    let library = shader::shipped_with(job.changed.clone());
    let entries = job.entries.each_ref().map(String::as_str);
    check(&library, entries, &job.slots, &job.changed)?;
    let link = |is_optimized: bool| {
        let linker = if is_optimized { Linker::new()? } else { Linker::new()?.unoptimized() };
        let link = |entry| linker.link(&library, entry, Stage::of(entry), &entries, &job.slots);
        let stages = link(entries[0]).and_then(|vertex| Ok([vertex, link(entries[1])?]));
        stages.map_err(|error| explained(&library, &job.slots, &job.changed, error))
    };
    let stages = link(job.is_optimized)?;
    if let Some(refusal) = stages.iter().find_map(|module| refusal(module, &job.changed)) {
        return Err(LinkError::Compile(refusal));
    }
    let whole = if job.is_optimized { link(false)? } else { stages.clone() };
    let text_of = |file: &str| job.changed.get(path_of(file)).map(String::as_str);
    for module in &whole {
        let found = undefined(module, &text_of);
        let found = found.map_err(|reason| LinkError::Compile(format!("{}: {reason}", names(&job.changed))))?;
        if let Some(first) = found.found.first() {
            return Err(LinkError::Compile(at_its_name(first, &job.changed)));
        }
    }
    Ok(stages)
}

/// Path of a file that may belong to an additional object, `stone:dmf/fur.glsl`, or be a copy, `dmf/fur.glsl#2`.
fn path_of(file: &str) -> &str {
    file.split('#').next().unwrap_or_default().rsplit(':').next().unwrap_or_default()
}

/// A message `file:line: text` with the line, from there on, that has the name of the text: the compiler gives some
/// expressions the line of the one before.
fn at_its_name(message: &str, changed: &BTreeMap<String, String>) -> String {
    let moved = || {
        let (file, rest) = message.split_at(message.find(".glsl")? + ".glsl".len());
        let (copy, rest) = rest.split_once(':')?;
        let (line, text) = rest.split_once(": ")?;
        let (line, name) = (line.parse::<usize>().ok()?, text.split('`').nth(1)?);
        let source = changed.get(path_of(file))?;
        let has_name = |line: &str| find_word(line, |word| word == name).is_some();
        let later = source.lines().skip(line - 1).position(has_name).filter(|later| *later <= 1)?;
        Some(format!("{file}{copy}:{}: {text}", line + later))
    };
    moved().unwrap_or_else(|| message.into())
}

#[cfg(test)]
mod tests {
    use super::super::error::Fault;
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
    fn a_message_has_the_line_of_its_name() {
        let changed =
            BTreeMap::from([("dmf/a.glsl".to_string(), "float a() {\nbool b;\nreturn b ? 1.0 : 0.0;\n}".into())]);
        let moved = |message: &str| at_its_name(message, &changed);
        assert_eq!(moved("stone:dmf/a.glsl#2:1: `b` is read"), "stone:dmf/a.glsl#2:2: `b` is read");
        assert_eq!(moved("dmf/a.glsl:3: `b` is read"), "dmf/a.glsl:3: `b` is read");
        assert_eq!(moved("dmf/a.glsl:3: `q` is read"), "dmf/a.glsl:3: `q` is read");
    }
}
