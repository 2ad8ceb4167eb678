//! The end of the program by a signal, also while a device does not answer.
//!
//! Role: the handler of a signal calls [`begin`], a wait for a device asks [`gives_up`], and the program calls [`finish`]
//! once it has written what it keeps. Invariant: such a wait ends within a second of the signal, or of its own start if
//! that is later, and the program no later than the grace of [`begin`] after that.

use std::process;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Longest wait for a device after a signal. Lower: a frame of a loaded machine is lost. Higher: the program ends late.
const PATIENCE: Duration = Duration::from_millis(500);
/// Time for the end of the process, after which it is killed: drivers wait for their threads.
const EXIT: Duration = Duration::from_millis(100);
const POLL: Duration = Duration::from_millis(20);

static BEGAN: OnceLock<Instant> = OnceLock::new();
static LEFT: AtomicBool = AtomicBool::new(false);

/// Notes that a signal asks the program to end; a second call ends it at once with the exit code.
///
/// If a wait for a device is given up, the process ends by [`finish`], or else `grace` after it: `keep` stores what would
/// be lost then.
pub fn begin(code: i32, grace: Duration, keep: impl FnOnce() + Send + 'static) {
    if BEGAN.set(Instant::now()).is_err() {
        process::exit(code);
    }
    thread::spawn(move || {
        while !LEFT.load(Ordering::Relaxed) {
            thread::sleep(POLL);
        }
        thread::sleep(grace);
        keep();
        exit(code);
    });
}

/// Ends the process with this code if a device was left at work, whose driver may never let it end; else does nothing.
pub fn finish(code: i32) {
    if LEFT.load(Ordering::Relaxed) {
        exit(code);
    }
}

/// Whether a wait that began at `start` is to be given up, since a signal asks the program to end.
pub fn gives_up(start: Instant) -> bool {
    BEGAN.get().is_some_and(|began| began.elapsed() > PATIENCE) && start.elapsed() > PATIENCE
}

/// Notes that a device was left at work: the process ends soon.
pub fn leave_device() {
    LEFT.store(true, Ordering::Relaxed);
}

fn exit(code: i32) -> ! {
    thread::spawn(|| {
        thread::sleep(EXIT);
        kill_this_process();
    });
    process::exit(code)
}

fn kill_this_process() {
    #[cfg(unix)]
    let _ = rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::KILL);
    #[cfg(not(unix))]
    process::abort();
}
