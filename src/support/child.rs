//! A child process with limits: this very program with a hidden command, a text on its standard input, an answer on its
//! standard output.
//!
//! Invariant: what a child may take is time of the processor, so that a machine with much else to do refuses nothing.

use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// How many times as long as its processor time a child may rest, such as in a deadlock or for another program's sake.
const PATIENT: u32 = 3;
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

/// Watches over the processor time of a child, from now on.
pub(crate) struct Watch {
    id: u32,
    limit: Duration,
    /// Processor time of the child when the watch began, where the system says it.
    before: Option<Duration>,
    /// The processor time last seen, and when it was first seen.
    seen: (Option<Duration>, Instant),
}

impl Watch {
    pub(crate) fn new(child: &Child, limit: Duration) -> Watch {
        let before = processor_time(child.id());
        Watch { id: child.id(), limit, before, seen: (before, Instant::now()) }
    }

    /// Whether the child has taken more than it may, or rests for three times as long. Where the system does not say what
    /// it has taken, all of its time is rest.
    pub(crate) fn is_late(&mut self) -> bool {
        let now = processor_time(self.id);
        if now != self.seen.0 {
            self.seen = (now, Instant::now());
        }
        let taken = now.zip(self.before).map_or(Duration::ZERO, |(now, before)| now.saturating_sub(before));
        taken > self.limit || self.seen.1.elapsed() > self.limit * PATIENT
    }
}

/// Time of the processor that a process has taken, in steps of 10 ms.
pub(crate) fn processor_time(id: u32) -> Option<Duration> {
    // The name of the program comes first, in parentheses, and may hold anything. The times are in 1/100 s on Linux,
    // whatever the clock of the kernel; other systems have no such file.
    let text = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    let mut fields = text.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<u64>().ok();
    Some(Duration::from_millis(10 * (ticks()? + ticks()?)))
}

/// Runs `program` with these arguments. `is_stale` is asked now and then: once it says yes, the child is ended. The error
/// says why it cannot be run.
#[cfg(feature = "viewer")]
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
#[cfg(feature = "viewer")]
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

/// How a process ended.
pub(crate) fn end(status: ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return format!("signal {signal}");
    }
    status.to_string()
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

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::*;

    fn shell(script: &str) -> Child {
        Command::new("sh").args(["-c", script]).stdin(Stdio::null()).spawn().unwrap()
    }

    /// Whether a child is late before it has taken so much processor time, or has rested for the wall time.
    fn late_before(child: &mut Child, watch: &mut Watch, done: impl Fn(Duration) -> bool) -> bool {
        loop {
            if watch.is_late() {
                return true;
            }
            if done(processor_time(child.id()).unwrap()) {
                return false;
            }
            thread::sleep(PATIENCE);
        }
    }

    #[test]
    fn a_child_is_late_by_the_time_of_the_processor_and_not_of_the_wall() {
        let mut busy = shell("while :; do :; done");
        let second = Duration::from_secs(1);
        // However long it waits for the processor: before a second of it is taken, it is not late; soon after, it is.
        let mut watch = Watch::new(&busy, second);
        let nearly = Duration::from_millis(900);
        let early = late_before(&mut busy, &mut watch, |taken| taken >= nearly);
        let late = late_before(&mut busy, &mut watch, |taken| taken > 2 * second);
        busy.kill().unwrap();
        busy.wait().unwrap();
        assert!(!early && late, "early {early}, late {late}");
    }

    #[test]
    fn a_child_that_rests_for_ever_is_late() {
        let mut resting = shell("exec sleep 1000");
        let mut watch = Watch::new(&resting, Duration::from_millis(50));
        let late = late_before(&mut resting, &mut watch, |_| false);
        resting.kill().unwrap();
        resting.wait().unwrap();
        assert!(late);
    }
}
