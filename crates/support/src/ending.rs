//! The end of the program by a signal, also while a device does not answer.
//!
//! Role: the handler of a signal calls [`begin`], and a wait for a device asks [`gives_up`]. Invariant: such a wait ends
//! [`PATIENCE`] after the signal, and the program [`GRACE`] after that.

use std::process;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Longest wait for a device after a signal. Lower: a frame of a loaded machine is lost. Higher: the program ends late.
const PATIENCE: Duration = Duration::from_millis(500);
/// Time for what is written at the end, once a wait was given up.
const GRACE: Duration = Duration::from_millis(300);
/// Time for the end of the process, after which it is killed: drivers wait for their threads.
const EXIT: Duration = Duration::from_millis(100);
const POLL: Duration = Duration::from_millis(20);

static BEGAN: OnceLock<Instant> = OnceLock::new();
static LEFT: AtomicBool = AtomicBool::new(false);

/// Notes that a signal asks the program to end; a second call ends it at once with the exit code.
///
/// If a wait for a device is given up, the process ends soon after it: `keep` stores what would be lost.
pub fn begin(code: i32, keep: impl FnOnce() + Send + 'static) {
    if BEGAN.set(Instant::now()).is_err() {
        process::exit(code);
    }
    thread::spawn(move || {
        while !LEFT.load(Ordering::Relaxed) {
            thread::sleep(POLL);
        }
        thread::sleep(GRACE);
        keep();
        thread::spawn(|| {
            thread::sleep(EXIT);
            kill_this_process();
        });
        process::exit(code);
    });
}

/// Whether a wait that began at `start` is to be given up, since a signal asks the program to end.
pub fn gives_up(start: Instant) -> bool {
    BEGAN.get().is_some_and(|began| began.elapsed() > PATIENCE) && start.elapsed() > PATIENCE
}

/// Notes that a device was left at work: the process ends soon.
pub fn leave_device() {
    LEFT.store(true, Ordering::Relaxed);
}

fn kill_this_process() {
    #[cfg(unix)]
    let _ = rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::KILL);
    #[cfg(not(unix))]
    process::abort();
}
