//! A child process with limits: this very program with a hidden command, a text on its standard input, an answer on its
//! standard output.

use super::watch::{Excess, Watch, end};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::Duration;

/// How often a child is asked whether it has ended.
const PATIENCE: Duration = Duration::from_millis(4);

/// What a child may take.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Time of the processor; it may rest for three times as long.
    pub time: Duration,
    /// Memory, MiB; on Linux.
    pub memory_mib: u64,
    /// Length of the answer, bytes.
    pub answer_bytes: u64,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { time: Duration::from_secs(10), memory_mib: 1024, answer_bytes: 64 << 20 }
    }
}

/// How a child has ended.
pub enum End {
    /// It says that it went well.
    Well,
    /// It was stopped, by a signal or a code.
    Badly(String),
    /// It took more time than it may.
    Late,
    /// It took more memory than it may.
    Large,
    /// Its answer is no longer wanted.
    Abandoned,
}

/// Runs `program` with these arguments: how it has ended, and what it has answered until then. `is_stale` is asked now and
/// then: once it says yes, the child is ended. The error says why it cannot be run.
pub fn run(
    program: &Path,
    arguments: &[&str],
    variables: &[(&str, &str)],
    text: String,
    limits: &Limits,
    is_stale: &dyn Fn() -> bool,
) -> Result<(End, Vec<u8>), String> {
    let mut command = Command::new(program);
    command.args(arguments).envs(variables.iter().copied());
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().map_err(|error| error.to_string())?;
    let (Some(mut input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
        return Err("it has no standard input or output".into());
    };
    // A child that has died does not read: its end says more than the broken pipe.
    let no_thread = |error: std::io::Error| format!("no thread talks to it: {error}");
    let write = move || drop(input.write_all(text.as_bytes()));
    let writer = thread::Builder::new().spawn(write).map_err(no_thread)?;
    let most = limits.answer_bytes;
    let read = move || {
        let mut answer = Vec::new();
        output.take(most + 1).read_to_end(&mut answer).map(|_| answer)
    };
    let reader = thread::Builder::new().spawn(read).map_err(no_thread)?;
    let ended = wait(&mut child, limits, is_stale);
    let answer = match (writer.join(), reader.join()) {
        (Ok(()), Ok(Ok(answer))) => answer,
        (_, Ok(Err(error))) => return Err(error.to_string()),
        _ => return Err("a thread that talks to it ended".into()),
    };
    let end = match ended? {
        // Whoever is no longer listened to may end badly.
        Ok(_) if answer.len() as u64 > most => return Err(format!("its answer is longer than {most} bytes")),
        Ok(status) if status.success() => End::Well,
        Ok(status) if is_out_of_time(status) => End::Late,
        Ok(status) => End::Badly(end(status)),
        Err(end) => end,
    };
    Ok((end, answer))
}

/// Waits for the child, and ends it when it takes too much or is no longer wanted.
fn wait(child: &mut Child, limits: &Limits, is_stale: &dyn Fn() -> bool) -> Result<Result<ExitStatus, End>, String> {
    let mut watch = Watch::new(child.id(), limits.time, limits.memory_mib << 20);
    let ended = loop {
        match child.try_wait() {
            Ok(Some(status)) => return Ok(Ok(status)),
            Ok(None) if is_stale() => break Ok(Err(End::Abandoned)),
            Ok(None) => match watch.excess() {
                Some(Excess::Time) => break Ok(Err(End::Late)),
                Some(Excess::Memory) => break Ok(Err(End::Large)),
                None => thread::sleep(PATIENCE),
            },
            Err(error) => break Err(error.to_string()),
        }
    };
    let _ = child.kill(); // it may have ended just now
    let _ = child.wait();
    ended
}

/// Whether a process has used up its time of the processor.
fn is_out_of_time(status: ExitStatus) -> bool {
    #[cfg(unix)]
    {
        const SIGXCPU: i32 = 24;
        std::os::unix::process::ExitStatusExt::signal(&status) == Some(SIGXCPU)
    }
    #[cfg(not(unix))]
    {
        let _ = status; // there is no such limit
        false
    }
}

/// Sets the limits of this process: for the child, before it reads anything. Without `memory_mib`, its memory has none: a
/// driver maps what it will never use.
///
/// # Errors
/// The system refuses.
pub fn limit(seconds: u64, memory_mib: Option<u64>) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, Rlimit, setrlimit};
        let most = |value: u64| Rlimit { current: Some(value), maximum: Some(value) };
        setrlimit(Resource::Core, most(0))?;
        // The soft limit comes first, so that its signal tells a late child from one that was killed.
        setrlimit(Resource::Cpu, Rlimit { current: Some(seconds), maximum: Some(seconds + 1) })?;
        if let Some(memory_mib) = memory_mib {
            setrlimit(Resource::As, most(memory_mib << 20))?;
        }
    }
    #[cfg(not(unix))]
    let _ = (seconds, memory_mib); // the parent's watch on the wall remains
    Ok(())
}
