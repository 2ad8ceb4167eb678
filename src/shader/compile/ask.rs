//! Requests to a child process: a job on its standard input, an [`Answer`] on its standard output, both JSON.

use super::error::CompileError;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::io::{self, Read, Write};
use std::path::Path;
use support::child::{self, Limits, Outcome};

/// Longest job that a child reads, in bytes. A library with every module at its longest would not fit and need not.
const MAX_JOB: u64 = 16 << 20;

/// Verdict of a child on a text.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub enum Answer<T> {
    /// The text is good, with the result.
    Good(T),
    /// The text is refused, with the reason.
    Bad(String),
    /// The text could not be tried, with the reason.
    Untried(String),
}

/// How a child ended without an answer.
pub enum Failure {
    /// A signal or an exit code.
    Crashed(String),
    /// The limit of processor time, seconds.
    Late(f32),
    /// The limit of memory, MiB.
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

/// A child process: this program with a hidden command.
pub struct Trial<'a> {
    /// The executable of hypertexture.
    pub program: &'a Path,
    /// The hidden command and its arguments.
    pub arguments: &'a [&'a str],
    /// The device to draw on, if any.
    pub device: Option<&'a str>,
    /// Limits of time and memory.
    pub limits: &'a Limits,
    /// The error for a failure after a number of finished stages.
    pub failed: fn(usize, Failure) -> CompileError,
}

impl Trial<'_> {
    /// Starts the child and waits for its answer. It is killed once `is_stale`, which is polled, returns true.
    pub fn ask<T: DeserializeOwned>(
        &self,
        job: &impl Serialize,
        is_stale: &dyn Fn() -> bool,
    ) -> Result<Answer<T>, CompileError> {
        let run = |reason: String| CompileError::Run { path: self.program.into(), reason };
        let text = serde_json::to_string(job).map_err(|error| run(error.to_string()))?;
        let device = self.device.map(|device| [("HYPERTEXTURE_DEVICE", device), ("HYPERTEXTURE_VALIDATION", "")]);
        let variables = device.as_ref().map_or(&[][..], |variables| variables);
        let (outcome, output) =
            child::run(self.program, self.arguments, variables, text, self.limits, is_stale).map_err(run)?;
        let stages = output.iter().take_while(|byte| **byte == STAGE).count();
        let failure = match outcome {
            Outcome::Success => {
                let answer = serde_json::from_slice(&output[stages..]);
                return answer.map_err(|error| run(format!("its answer: {error}")));
            }
            Outcome::Cancelled => return Err(CompileError::Abandoned),
            Outcome::Failed(how) => Failure::Crashed(how),
            Outcome::OutOfTime => Failure::Late(self.limits.time.as_secs_f32()),
            Outcome::OutOfMemory => Failure::Large(self.limits.memory_mib),
        };
        Err((self.failed)(stages, failure))
    }
}

/// Byte that a child writes at the end of each stage, before its answer.
const STAGE: u8 = b'\n';

/// Child's side: marks the end of a stage.
pub fn stage(output: &mut impl Write) -> io::Result<()> {
    output.write_all(&[STAGE])?;
    output.flush()
}

/// Child's side: reads the job.
pub fn read<T: DeserializeOwned>(input: impl Read) -> io::Result<T> {
    Ok(serde_json::from_reader(io::BufReader::new(input.take(MAX_JOB)))?)
}

/// Child's side: writes the answer.
pub fn reply(output: &mut impl Write, answer: &Answer<impl Serialize>) -> io::Result<()> {
    serde_json::to_writer(&mut *output, answer)?;
    output.flush()
}
