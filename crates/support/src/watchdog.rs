//! What a process takes.
//!
//! Invariant: what it may take is time of the processor, so that a machine with much else to do refuses nothing.

use std::process::ExitStatus;
use std::time::{Duration, Instant};

/// How many times as long as its processor time a process may rest, such as in a deadlock or for another program's sake.
const PATIENT: u32 = 3;

/// Watches over the processor time and the memory of a process, from now on.
pub struct Watch {
    id: u32,
    limit: Duration,
    /// Bytes of memory that it may hold.
    memory: u64,
    /// Its processor time when the watch began, where the system says it.
    before: Option<Duration>,
    /// The processor time last seen, and when it was first seen.
    seen: (Option<Duration>, Instant),
}

/// What a process has taken more of than it may.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Excess {
    /// Time of the processor; or it rests for three times as long.
    Time,
    /// Memory.
    Memory,
}

impl Watch {
    /// Watches over the process of that number.
    pub fn new(id: u32, limit: Duration, memory: u64) -> Watch {
        let before = processor_time(id);
        Watch { id, limit, memory, before, seen: (before, Instant::now()) }
    }

    /// What the process has taken more of than it may. Where the system does not say what it has taken, all of its time is
    /// rest.
    pub fn excess(&mut self) -> Option<Excess> {
        let now = processor_time(self.id);
        if now != self.seen.0 {
            self.seen = (now, Instant::now());
        }
        let taken = now.zip(self.before).map_or(Duration::ZERO, |(now, before)| now.saturating_sub(before));
        if memory(self.id).is_some_and(|bytes| bytes > self.memory) {
            Some(Excess::Memory)
        } else {
            (taken > self.limit || self.seen.1.elapsed() > self.limit * PATIENT).then_some(Excess::Time)
        }
    }
}

/// Time of the processor that a process has taken, in steps of 10 ms.
pub fn processor_time(id: u32) -> Option<Duration> {
    // The name of the program comes first, in parentheses, and may hold anything. The times are in 1/100 s on Linux,
    // whatever the clock of the kernel; other systems have no such file.
    let text = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    let mut fields = text.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<u64>().ok();
    Some(Duration::from_millis(10 * (ticks()? + ticks()?)))
}

/// Time of the processors that this process has taken so far, all threads, user and system; where the system says.
pub fn own_processor_time() -> Option<Duration> {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        let [seconds, nanoseconds] = [time.tv_sec, time.tv_nsec].map(u64::try_from);
        Some(Duration::from_secs(seconds.ok()?) + Duration::from_nanos(nanoseconds.ok()?))
    }
    #[cfg(not(unix))]
    None
}

/// Bytes of memory that a process holds, where the system says.
pub fn memory(id: u32) -> Option<u64> {
    const PAGE: u64 = 4096; // or more
    let text = std::fs::read_to_string(format!("/proc/{id}/statm")).ok()?;
    text.split(' ').nth(1)?.parse::<u64>().ok().map(|pages| pages * PAGE)
}

/// How a process ended.
pub fn end(status: ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return format!("signal {signal}");
    }
    status.to_string()
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::*;
    use std::io::{BufRead, BufReader};
    use std::process::{Child, Command, Stdio};
    use std::thread;

    fn shell(script: &str) -> Child {
        Command::new("sh").args(["-c", script]).stdin(Stdio::null()).spawn().unwrap()
    }

    /// Whether a child is late before it has taken so much processor time, or has rested for the wall time.
    fn late_before(child: &mut Child, watch: &mut Watch, done: impl Fn(Duration) -> bool) -> bool {
        loop {
            if watch.excess() == Some(Excess::Time) {
                return true;
            }
            if done(processor_time(child.id()).unwrap()) {
                return false;
            }
            thread::sleep(Duration::from_millis(4));
        }
    }

    #[test]
    fn a_child_is_late_by_the_time_of_the_processor_and_not_of_the_wall() {
        let mut busy = shell("while :; do :; done");
        let second = Duration::from_secs(1);
        // However long it waits for the processor: before a second of it is taken, it is not late; soon after, it is.
        let mut watch = Watch::new(busy.id(), second, u64::MAX);
        let nearly = Duration::from_millis(900);
        let early = late_before(&mut busy, &mut watch, |taken| taken >= nearly);
        let late = late_before(&mut busy, &mut watch, |taken| taken > 2 * second);
        busy.kill().unwrap();
        busy.wait().unwrap();
        assert!(!early && late, "early {early}, late {late}");
    }

    #[test]
    fn own_time_of_the_processor_is_that_of_the_system_in_finer_steps() {
        let coarse = || processor_time(std::process::id()).unwrap();
        let before = coarse();
        while coarse() < before + Duration::from_millis(50) {
            std::hint::black_box((0..1000).sum::<u64>());
        }
        let (system, own, later) = (coarse(), own_processor_time().unwrap(), coarse());
        let step = Duration::from_millis(20); // one, and what is rounded
        assert!(own + step > system && own < later + step, "{system:?} {own:?} {later:?}");
        assert_ne!(own.subsec_nanos() % 1_000_000, 0, "finer than a millisecond");
    }

    #[test]
    fn the_memory_of_a_process_is_what_it_holds() {
        // Of a child: this process frees what other tests held.
        let held = |script: &str| {
            let mut child = Command::new("sh");
            let mut child = child.args(["-c", script]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
            let mut line = String::new();
            BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
            let held = memory(child.id()).unwrap();
            let excess = |memory| Watch::new(child.id(), Duration::from_secs(1), memory).excess();
            assert_eq!((excess(held / 2), excess(2 * held)), (Some(Excess::Memory), None));
            child.kill().unwrap();
            child.wait().unwrap();
            held
        };
        let (little, much) = (held("echo; read x"), held("x=$(head -c 64000000 /dev/zero | tr '\\0' x); echo; read y"));
        assert!(little < 16_000_000 && much > 64_000_000, "{little} {much}");
    }

    #[test]
    fn a_child_that_rests_for_ever_is_late() {
        let mut resting = shell("exec sleep 1000");
        let mut watch = Watch::new(resting.id(), Duration::from_millis(50), u64::MAX);
        let late = late_before(&mut resting, &mut watch, |_| false);
        resting.kill().unwrap();
        resting.wait().unwrap();
        assert!(late);
    }
}
