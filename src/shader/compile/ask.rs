//! Asking a child process about a text: a job on its standard input, an [`Answer`] on its standard output, both JSON.

use super::error::CompileError;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::io::{self, Read, Write};
use std::path::Path;
use support::child::{self, End, Limits};

/// The longest job that a child reads, in bytes: every module of a library at its longest would not fit, none needs to.
const MAX_JOB: u64 = 16 << 20;

/// What a child says of a text.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub enum Answer<T> {
    /// It is good, and what came of it.
    Good(T),
    /// Why it is not.
    Bad(String),
    /// Why nothing can be said of it.
    Untried(String),
}

/// How a child has ended without an answer.
pub enum Failure {
    /// By a signal or a code.
    Crashed(String),
    /// It took so many seconds of the processor.
    Late(f32),
    /// It took more memory than so many MiB.
    Large(u64),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Crashed(how) => write!(f, "crashed ({how})"),
            Failure::Late(seconds) => write!(f, "took more than {seconds:.0} s of the processor"),
            Failure::Large(mib) => write!(f, "took more than {mib} MiB of memory"),
        }
    }
}

/// A child: this very program with a hidden command.
pub struct Trial<'a> {
    /// The executable of hypertexture.
    pub program: &'a Path,
    /// Its hidden command and the arguments of that.
    pub arguments: &'a [&'a str],
    /// The device that it draws on, where it draws.
    pub device: Option<&'a str>,
    /// Its limits of time and memory.
    pub limits: &'a Limits,
    /// What it means that the child has failed so, after it has finished so many stages.
    pub failed: fn(usize, Failure) -> CompileError,
}

impl Trial<'_> {
    /// Starts the child and waits for its answer. `is_stale` is asked now and then: once it says yes, the child is ended.
    pub fn ask<T: DeserializeOwned>(
        &self,
        job: &impl Serialize,
        is_stale: &dyn Fn() -> bool,
    ) -> Result<Answer<T>, CompileError> {
        let run = |reason: String| CompileError::Run { path: self.program.into(), reason };
        let text = serde_json::to_string(job).map_err(|error| run(error.to_string()))?;
        let device = self.device.map(|device| [("HYPERTEXTURE_DEVICE", device), ("HYPERTEXTURE_VALIDATION", "")]);
        let variables = device.as_ref().map_or(&[][..], |variables| variables);
        let (end, said) =
            child::run(self.program, self.arguments, variables, text, self.limits, is_stale).map_err(run)?;
        let stages = said.iter().take_while(|byte| **byte == STAGE).count();
        let failure = match end {
            End::Well => {
                let answer = serde_json::from_slice(&said[stages..]);
                return answer.map_err(|error| run(format!("its answer: {error}")));
            }
            End::Abandoned => return Err(CompileError::Abandoned),
            End::Badly(how) => Failure::Crashed(how),
            End::Late => Failure::Late(self.limits.time.as_secs_f32()),
            End::Large => Failure::Large(self.limits.memory_mib),
        };
        Err((self.failed)(stages, failure))
    }
}

/// What a child writes at the end of each stage, before its answer.
const STAGE: u8 = b'\n';

/// The child's side: a stage is finished.
pub fn stage(output: &mut impl Write) -> io::Result<()> {
    output.write_all(&[STAGE])?;
    output.flush()
}

/// The child's side: the job.
pub fn read<T: DeserializeOwned>(input: impl Read) -> io::Result<T> {
    Ok(serde_json::from_reader(io::BufReader::new(input.take(MAX_JOB)))?)
}

/// The child's side: its answer.
pub fn reply(output: &mut impl Write, answer: &Answer<impl Serialize>) -> io::Result<()> {
    serde_json::to_writer(&mut *output, answer)?;
    output.flush()
}
