//! Asking a child process about a text: a job on its standard input, an [`Answer`] on its standard output, both JSON.

use super::error::CompileError;
use crate::support::child::{self, End, Limits};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::{self, Read, Write};
use std::path::Path;

/// The longest job that a child reads, in bytes: every module of a library at its longest would not fit, none needs to.
const MAX_JOB: u64 = 16 << 20;

/// What a child says of a text.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Answer<T> {
    /// It is good, and what came of it.
    Good(T),
    /// Why it is not.
    Bad(String),
    /// Why nothing can be said of it.
    Untried(String),
}

/// A child: this very program with a hidden command.
pub(crate) struct Trial<'a> {
    pub(crate) program: &'a Path,
    pub(crate) arguments: &'a [&'a str],
    /// The device that it draws on, where it draws.
    pub(crate) device: Option<&'a str>,
    pub(crate) limits: &'a Limits,
    /// What it means that the child has ended so, or that it did not end in so many seconds.
    pub(crate) crashed: fn(String) -> CompileError,
    pub(crate) late: fn(f32) -> CompileError,
}

impl Trial<'_> {
    /// Starts the child and waits for its answer. `is_stale` is asked now and then: once it says yes, the child is ended.
    pub(crate) fn ask<T: DeserializeOwned>(
        &self,
        job: &impl Serialize,
        is_stale: &dyn Fn() -> bool,
    ) -> Result<Answer<T>, CompileError> {
        let run = |reason: String| CompileError::Run { path: self.program.into(), reason };
        let text = serde_json::to_string(job).map_err(|error| run(error.to_string()))?;
        let device = self.device.map(|device| [("HYPERTEXTURE_DEVICE", device), ("HYPERTEXTURE_VALIDATION", "")]);
        let variables = device.as_ref().map_or(&[][..], |variables| variables);
        match child::run(self.program, self.arguments, variables, text, self.limits, is_stale).map_err(run)? {
            End::Well(answer) => serde_json::from_slice(&answer).map_err(|error| run(format!("its answer: {error}"))),
            End::Badly(how) => Err((self.crashed)(how)),
            End::Late(time) => Err((self.late)(time.as_secs_f32())),
            End::Abandoned => Err(CompileError::Abandoned),
        }
    }
}

/// The child's side: the job.
pub(crate) fn read<T: DeserializeOwned>(input: impl Read) -> io::Result<T> {
    Ok(serde_json::from_reader(io::BufReader::new(input.take(MAX_JOB)))?)
}

/// The child's side: its answer.
pub(crate) fn reply(output: &mut impl Write, answer: &Answer<impl Serialize>) -> io::Result<()> {
    serde_json::to_writer(&mut *output, answer)?;
    output.flush()
}
