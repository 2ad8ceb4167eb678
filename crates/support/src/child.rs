//! A child process under limits: this program with a hidden command, which reads a request from standard input and writes an
//! answer to standard output.

use super::watchdog::{Excess, Watchdog, describe};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::Duration;

/// Interval of polls.
const POLL: Duration = Duration::from_millis(4);

/// Resource limits of a child.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Processor time. A child may idle three times as long.
    pub time: Duration,
    /// Memory in MiB, enforced on Linux.
    pub memory_mib: u64,
    /// Length of the answer in bytes.
    pub answer_bytes: u64,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { time: Duration::from_secs(10), memory_mib: 1024, answer_bytes: 64 << 20 }
    }
}

/// How a child has ended.
pub enum Outcome {
    /// Exit code 0.
    Success,
    /// Another exit code, or a signal.
    Failed(String),
    /// It exceeded the time limit.
    OutOfTime,
    /// It exceeded the memory limit.
    OutOfMemory,
    /// The caller cancelled it.
    Cancelled,
}

/// Runs `program` and returns its outcome and the answer so far. It is killed once `is_stale`, which is polled, returns true.
/// The error says why it cannot be run.
pub fn run(
    program: &Path,
    arguments: &[&str],
    variables: &[(&str, &str)],
    request: String,
    limits: &Limits,
    is_stale: &dyn Fn() -> bool,
) -> Result<(Outcome, Vec<u8>), String> {
    let mut command = Command::new(program);
    command.args(arguments).envs(variables.iter().copied());
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().map_err(|error| error.to_string())?;
    let (Some(mut input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
        return Err("it has no standard input or output".into());
    };
    // The outcome of a dead child says more than its broken pipe.
    let no_thread = |error: std::io::Error| format!("cannot start a thread for its pipes: {error}");
    let write = move || drop(input.write_all(request.as_bytes()));
    let writer = thread::Builder::new().spawn(write).map_err(no_thread)?;
    let limit = limits.answer_bytes;
    let read = move || {
        let mut answer = Vec::new();
        output.take(limit + 1).read_to_end(&mut answer).map(|_| answer)
    };
    let reader = thread::Builder::new().spawn(read).map_err(no_thread)?;
    let ended = wait(&mut child, limits, is_stale);
    let answer = match (writer.join(), reader.join()) {
        (Ok(()), Ok(Ok(answer))) => answer,
        (_, Ok(Err(error))) => return Err(error.to_string()),
        _ => return Err("a thread of its pipes panicked".into()),
    };
    let outcome = match ended? {
        // A child whose answer is cut off may fail for that reason.
        Ok(_) if answer.len() as u64 > limit => return Err(format!("its answer is longer than {limit} bytes")),
        Ok(status) if status.success() => Outcome::Success,
        Ok(status) if is_out_of_time(status) => Outcome::OutOfTime,
        Ok(status) => Outcome::Failed(describe(status)),
        Err(outcome) => outcome,
    };
    Ok((outcome, answer))
}

/// Waits for a child, and kills it when it exceeds a limit or is cancelled.
fn wait(
    child: &mut Child,
    limits: &Limits,
    is_stale: &dyn Fn() -> bool,
) -> Result<Result<ExitStatus, Outcome>, String> {
    let mut watchdog = Watchdog::new(child.id(), limits.time, limits.memory_mib << 20);
    let ended = loop {
        match child.try_wait() {
            Ok(Some(status)) => return Ok(Ok(status)),
            Ok(None) if is_stale() => break Ok(Err(Outcome::Cancelled)),
            Ok(None) => match watchdog.excess() {
                Some(Excess::Time) => break Ok(Err(Outcome::OutOfTime)),
                Some(Excess::Memory) => break Ok(Err(Outcome::OutOfMemory)),
                None => thread::sleep(POLL),
            },
            Err(error) => break Err(error.to_string()),
        }
    };
    let _ = child.kill(); // fails if it has just ended
    let _ = child.wait();
    ended
}

/// Whether a process was stopped by its limit of processor time.
fn is_out_of_time(status: ExitStatus) -> bool {
    #[cfg(unix)]
    {
        const SIGXCPU: i32 = 24;
        std::os::unix::process::ExitStatusExt::signal(&status) == Some(SIGXCPU)
    }
    #[cfg(not(unix))]
    {
        let _ = status; // no such limit exists
        false
    }
}

/// Sets the limits of this process, to be called by the child before it reads anything. `memory_mib` is `None` for children
/// with a driver, which maps memory that it never uses.
///
/// # Errors
/// The system refuses a limit.
pub fn limit(seconds: u64, memory_mib: Option<u64>) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, Rlimit, setrlimit};
        let both = |value: u64| Rlimit { current: Some(value), maximum: Some(value) };
        setrlimit(Resource::Core, both(0))?;
        // The soft limit is lower, so that its signal identifies a time-out.
        setrlimit(Resource::Cpu, Rlimit { current: Some(seconds), maximum: Some(seconds + 1) })?;
        if let Some(memory_mib) = memory_mib {
            setrlimit(Resource::As, both(memory_mib << 20))?;
        }
    }
    #[cfg(not(unix))]
    let _ = (seconds, memory_mib); // the parent's watchdog remains
    Ok(())
}
