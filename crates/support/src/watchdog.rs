//! Resource use of processes, and limits on it.
//!
//! Invariant: time limits are of processor time, so that a busy machine refuses nothing.

use std::time::{Duration, Instant};

/// Idle time that a process may spend, over its limit of processor time: in a deadlock, or waiting for others.
const IDLE_FACTOR: u32 = 3;

/// Monitors the processor time and the memory of a process.
pub struct Watchdog {
    id: u32,
    limit: Duration,
    /// Limit of memory in bytes.
    memory: u64,
    /// Processor time at the start, if known.
    before: Option<Duration>,
    /// The last processor time read, and when it was first read.
    seen: (Option<Duration>, Instant),
}

/// The limit that a process exceeds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Excess {
    /// Processor time, or idle time.
    Time,
    /// Memory.
    Memory,
}

impl Watchdog {
    /// Monitors the process `id` from here on.
    pub fn new(id: u32, limit: Duration, memory: u64) -> Watchdog {
        let before = processor_time(id);
        Watchdog { id, limit, memory, before, seen: (before, Instant::now()) }
    }

    /// The limit that the process exceeds. All its time counts as idle where the system does not report processor time.
    pub fn excess(&mut self) -> Option<Excess> {
        let now = processor_time(self.id);
        if now != self.seen.0 {
            self.seen = (now, Instant::now());
        }
        let taken = now.zip(self.before).map_or(Duration::ZERO, |(now, before)| now.saturating_sub(before));
        if memory(self.id).is_some_and(|bytes| bytes > self.memory) {
            Some(Excess::Memory)
        } else {
            (taken > self.limit || self.seen.1.elapsed() > self.limit * IDLE_FACTOR).then_some(Excess::Time)
        }
    }
}

/// Processor time of a process, in steps of 10 ms.
pub fn processor_time(id: u32) -> Option<Duration> {
    // The program's name, in parentheses, may contain anything. Linux gives times in 1/100 s whatever the kernel's clock;
    // other systems have no such file.
    let text = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    let mut fields = text.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<u64>().ok();
    Some(Duration::from_millis(10 * (ticks()? + ticks()?)))
}

/// Processor time of this process, of all threads, user and system, if known.
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

/// Resident memory of a process in bytes, if known.
pub fn memory(id: u32) -> Option<u64> {
    const PAGE: u64 = 4096; // or more
    let text = std::fs::read_to_string(format!("/proc/{id}/statm")).ok()?;
    text.split(' ').nth(1)?.parse::<u64>().ok().map(|pages| pages * PAGE)
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

    /// Whether a child exceeds its time before `done` holds of its processor time.
    fn late_before(child: &mut Child, watch: &mut Watchdog, done: impl Fn(Duration) -> bool) -> bool {
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
    fn a_child_is_late_by_processor_time_not_wall_time() {
        let mut busy = shell("while :; do :; done");
        let second = Duration::from_secs(1);
        // Late soon after a second of processor time and not before, however long it waits for the processor.
        let mut watch = Watchdog::new(busy.id(), second, u64::MAX);
        let nearly = Duration::from_millis(900);
        let early = late_before(&mut busy, &mut watch, |taken| taken >= nearly);
        let late = late_before(&mut busy, &mut watch, |taken| taken > 2 * second);
        busy.kill().unwrap();
        busy.wait().unwrap();
        assert!(!early && late, "early {early}, late {late}");
    }

    #[test]
    fn own_processor_time_refines_that_of_the_system() {
        let coarse = || processor_time(std::process::id()).unwrap();
        let before = coarse();
        while coarse() < before + Duration::from_millis(50) {
            std::hint::black_box((0..1000).sum::<u64>());
        }
        let (system, own, later) = (coarse(), own_processor_time().unwrap(), coarse());
        let step = Duration::from_millis(20); // with a rounding
        assert!(own + step > system && own < later + step, "{system:?} {own:?} {later:?}");
        assert_ne!(own.subsec_nanos() % 1_000_000, 0, "finer than a millisecond");
    }

    #[test]
    fn resident_memory_is_measured() {
        // A child, since other tests free memory of this process.
        let held = |script: &str| {
            let mut child = Command::new("sh");
            let mut child = child.args(["-c", script]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
            let mut line = String::new();
            BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
            let held = memory(child.id()).unwrap();
            let excess = |memory| Watchdog::new(child.id(), Duration::from_secs(1), memory).excess();
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
        let mut watch = Watchdog::new(resting.id(), Duration::from_millis(50), u64::MAX);
        let late = late_before(&mut resting, &mut watch, |_| false);
        resting.kill().unwrap();
        resting.wait().unwrap();
        assert!(late);
    }
}
