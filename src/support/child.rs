//! A child process with limits: this very program with a hidden command, a text on its standard input, an answer on its
//! standard output.

use super::watch::{Watch, end};
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
    /// Address space, MiB; on Unix.
    pub memory_mib: u64,
    /// Length of the answer, bytes.
    pub answer_bytes: u64,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { time: Duration::from_secs(10), memory_mib: 1024, answer_bytes: 64 << 20 }
    }
}

/// How a child has ended, and what it has answered.
pub(crate) enum End {
    /// It says that it went well.
    Well(Vec<u8>),
    /// It was stopped, by a signal or a code.
    Badly(String),
    /// It did not end in time.
    Late(Duration),
    /// Its answer is no longer wanted.
    Abandoned,
}

/// Runs `program` with these arguments. `is_stale` is asked now and then: once it says yes, the child is ended. The error
/// says why it cannot be run.
pub(crate) fn run(
    program: &Path,
    arguments: &[&str],
    variables: &[(&str, &str)],
    text: String,
    limits: &Limits,
    is_stale: &dyn Fn() -> bool,
) -> Result<End, String> {
    let mut command = Command::new(program);
    command.args(arguments).envs(variables.iter().copied());
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().map_err(|error| error.to_string())?;
    let (Some(mut input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
        return Err("it has no standard input or output".into());
    };
    // A child that has died does not read: its end says more than the broken pipe.
    let writer = thread::spawn(move || drop(input.write_all(text.as_bytes())));
    let most = limits.answer_bytes;
    let reader = thread::spawn(move || {
        let mut answer = Vec::new();
        output.take(most + 1).read_to_end(&mut answer).map(|_| answer)
    });
    let ended = wait(&mut child, limits.time, is_stale);
    let joined = (writer.join(), reader.join());
    let status = match ended? {
        Ok(status) => status,
        Err(end) => return Ok(end),
    };
    let answer = match joined {
        (Ok(()), Ok(Ok(answer))) => answer,
        (_, Ok(Err(error))) => return Err(error.to_string()),
        _ => return Err("a thread that talks to it ended".into()),
    };
    // Whoever is no longer listened to may end badly.
    if answer.len() as u64 > most {
        return Err(format!("its answer is longer than {most} bytes"));
    }
    Ok(match status.success() {
        true => End::Well(answer),
        false if is_out_of_time(status) => End::Late(limits.time),
        false => End::Badly(end(status)),
    })
}

/// Waits for the child, and ends it when it is late or no longer wanted.
fn wait(child: &mut Child, limit: Duration, is_stale: &dyn Fn() -> bool) -> Result<Result<ExitStatus, End>, String> {
    let mut watch = Watch::new(child, limit);
    let ended = loop {
        match child.try_wait() {
            Ok(Some(status)) => return Ok(Ok(status)),
            Ok(None) if watch.is_late() => break Ok(Err(End::Late(limit))),
            Ok(None) if is_stale() => break Ok(Err(End::Abandoned)),
            Ok(None) => thread::sleep(PATIENCE),
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
