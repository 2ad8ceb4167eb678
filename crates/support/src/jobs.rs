//! Child processes under limits: this program with one hidden command, which answers requests on standard input.
//!
//! Role: [`Child`] is the side of the parent, [`Parent`] that of the child; the first message names the job and its limits.
//! Messages are lines of JSON; a binary payload may follow an answer. Invariant: a child ends with its parent, and once its
//! [`Child`] is dropped.

use super::watchdog::{Excess, Watchdog, memory};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::{self, BufRead, BufReader, ErrorKind, Lines, Read, StdinLock, StdoutLock, Write};
use std::path::Path;
use std::process::{self, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

/// The hidden command.
const COMMAND: &str = "job";
/// Interval between checks of the limits.
const POLL: Duration = Duration::from_millis(20);

/// Resource limits of a child.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// Processor time until an answer. A child may idle three times as long.
    pub time: Duration,
    /// Memory in MiB, enforced on Linux.
    pub memory_mib: u64,
    /// Length of an answer in bytes, without its payload.
    pub answer_bytes: u64,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { time: Duration::from_secs(10), memory_mib: 1024, answer_bytes: 64 << 20 }
    }
}

/// Why a child gave no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Ended {
    /// A signal or an exit code.
    #[error("crashed ({0})")]
    Crashed(String),
    /// The limit of processor time, seconds.
    #[error("took more than {0:.0} s of the processor")]
    Late(f32),
    /// The limit of memory, MiB.
    #[error("took more than {0} MiB of memory")]
    Large(u64),
    /// The caller cancelled it.
    #[error("cancelled")]
    Cancelled,
    /// It cannot be run, or its answer not be read.
    #[error("{0}")]
    Unfit(String),
}

fn unfit(reason: impl ToString) -> Ended {
    Ended::Unfit(reason.to_string())
}

/// A child process, killed when dropped.
pub struct Child {
    /// Limits of the next answer.
    pub limits: Limits,
    process: process::Child,
    input: ChildStdin,
    answers: Receiver<io::Result<(String, Vec<u8>)>>,
}

impl Child {
    /// Starts a job of `program`, the executable of hypertexture; `device` is the value of `--device`.
    ///
    /// # Errors
    /// The program cannot be started.
    pub fn start(program: &Path, device: Option<&str>, job: &str, limits: &Limits) -> Result<Child, Ended> {
        let mut command = Command::new(program);
        command.arg(COMMAND).args(device.iter().flat_map(|device| ["--device", device]));
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0); // Ctrl-C goes to the parent alone
        let mut process = command.spawn().map_err(unfit)?;
        let (Some(input), Some(output)) = (process.stdin.take(), process.stdout.take()) else {
            return Err(unfit("it has no standard input or output"));
        };
        let (tell, answers) = sync_channel(0);
        let mut child = Child { limits: limits.clone(), process, input, answers };
        let (mut output, limit) = (BufReader::new(output), limits.answer_bytes);
        let listen = move || while tell.send(read_answer(&mut output, limit)).is_ok() {};
        std::thread::Builder::new().spawn(listen).map_err(unfit)?;
        child.send(&(job, limits));
        Ok(child)
    }

    /// Sends a request. The end of the child shows in its answer.
    pub fn send(&mut self, request: &impl Serialize) {
        let text = serde_json::to_string(request).expect("requests are valid JSON") + "\n";
        let _ = self.input.write_all(text.as_bytes());
    }

    /// Waits for the next answer and its payload; [`Ended::Cancelled`] once `is_stale`, which is polled, returns true.
    ///
    /// # Errors
    /// The child ended or exceeds a limit; drop it.
    pub fn receive<T: DeserializeOwned>(&mut self, is_stale: &dyn Fn() -> bool) -> Result<(T, Vec<u8>), Ended> {
        let Limits { time, memory_mib, .. } = self.limits;
        let mut watchdog = Watchdog::new(self.process.id(), time, memory_mib << 20);
        while !is_stale() {
            match self.answers.recv_timeout(POLL) {
                Ok(Ok((text, payload))) => {
                    let answer = serde_json::from_str(&text).map_err(|error| unfit(format!("its answer: {error}")))?;
                    return Ok((answer, payload));
                }
                Ok(Err(error)) if error.kind() != ErrorKind::UnexpectedEof => return Err(unfit(error)),
                Err(RecvTimeoutError::Timeout) => match watchdog.excess() {
                    Some(Excess::Time) => return Err(Ended::Late(time.as_secs_f32())),
                    Some(Excess::Memory) => return Err(Ended::Large(memory_mib)),
                    None => {}
                },
                Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                    return Err(match describe(self.process.wait().map_err(unfit)?) {
                        how if how == OUT_OF_TIME => Ended::Late(time.as_secs_f32()),
                        how => Ended::Crashed(how),
                    });
                }
            }
        }
        Err(Ended::Cancelled)
    }

    /// Sends a request and waits for the answer.
    ///
    /// # Errors
    /// As [`Child::receive`].
    pub fn ask<T: DeserializeOwned>(&mut self, request: &impl Serialize) -> Result<(T, Vec<u8>), Ended> {
        self.send(request);
        self.receive(&|| false)
    }

    /// Resident memory in bytes, if known.
    pub fn memory(&self) -> Option<u64> {
        memory(self.process.id())
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        let _ = self.process.kill(); // it may have ended before
        let _ = self.process.wait();
    }
}

/// Reads an answer, behind the length of its payload, and the payload. An unexpected end is that of the child.
fn read_answer(output: &mut impl BufRead, limit: u64) -> io::Result<(String, Vec<u8>)> {
    let mut line = String::new();
    output.by_ref().take(limit + 1).read_line(&mut line)?;
    if line.len() as u64 > limit {
        return Err(io::Error::other(format!("its answer is longer than {limit} bytes")));
    }
    let Some(line) = line.strip_suffix('\n') else { return Err(ErrorKind::UnexpectedEof.into()) };
    let (length, text) = line.split_once(' ').unwrap_or_default();
    let length: u64 = length.parse().map_err(|_| io::Error::other(format!("its answer: {line}")))?;
    let mut payload = Vec::new();
    output.take(length).read_to_end(&mut payload)?;
    let is_whole = payload.len() as u64 == length;
    if is_whole { Ok((text.into(), payload)) } else { Err(ErrorKind::UnexpectedEof.into()) }
}

/// The end of a process by its limit of processor time: SIGXCPU.
const OUT_OF_TIME: &str = "signal 24";

/// How a process ended, as text.
fn describe(status: ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return format!("signal {signal}");
    }
    status.to_string()
}

/// The parent of this process, which is a child.
pub struct Parent {
    limits: Limits,
    input: Lines<StdinLock<'static>>,
    output: StdoutLock<'static>,
}

impl Parent {
    /// Reads the first message of the parent: the name of the job.
    ///
    /// # Errors
    /// The input is no message of a parent.
    pub fn accept() -> io::Result<(String, Parent)> {
        #[cfg(target_os = "linux")] // ends with its parent
        rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::KILL))?;
        let (input, output) = (io::stdin().lines(), io::stdout().lock());
        let mut parent = Parent { limits: Limits::default(), input, output };
        let (job, limits) = parent.request()?.ok_or(ErrorKind::UnexpectedEof)?;
        parent.limits = limits;
        Ok((job, parent))
    }

    /// Lets the system enforce the limits, over all answers; that of memory unless a driver maps memory it never uses.
    ///
    /// # Errors
    /// The system refuses a limit.
    pub fn enforce(&self, has_driver: bool) -> io::Result<()> {
        #[cfg(unix)]
        {
            use rustix::process::{Resource, Rlimit, setrlimit};
            let limit = |current, maximum| Rlimit { current: Some(current), maximum: Some(maximum) };
            let (seconds, bytes) = (self.limits.time.as_secs().max(1), self.limits.memory_mib << 20);
            setrlimit(Resource::Core, limit(0, 0))?;
            // The soft limit is lower, so that its signal identifies a time-out.
            setrlimit(Resource::Cpu, limit(seconds, seconds + 1))?;
            if !has_driver {
                setrlimit(Resource::As, limit(bytes, bytes))?;
            }
        }
        #[cfg(not(unix))]
        let _ = has_driver; // the watchdog of the parent remains
        Ok(())
    }

    /// Lowers the priority of this process below that of the parent.
    pub fn give_way(&self) {
        #[cfg(unix)]
        if let Err(error) = rustix::process::setpriority_process(None, 10) {
            log::info!("the job has the priority of its parent: {error}");
        }
    }

    /// Reads the next request; `None` at the end.
    ///
    /// # Errors
    /// The input is no such request.
    pub fn request<T: DeserializeOwned>(&mut self) -> io::Result<Option<T>> {
        let line = self.input.next().transpose()?;
        Ok(line.map(|line| serde_json::from_str(&line)).transpose()?)
    }

    /// Writes an answer and its payload, which may be empty.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn tell(&mut self, answer: &impl Serialize, payload: &[u8]) -> io::Result<()> {
        writeln!(self.output, "{} {}", payload.len(), serde_json::to_string(answer)?)?;
        self.output.write_all(payload)?;
        self.output.flush()
    }
}
