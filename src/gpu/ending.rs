//! The end of the process by a signal or with the display, also while a device does not answer.
//!
//! Role: the handler of a signal calls [`begin`], a wait for a device asks [`gives_up`], and the program calls [`finish`]
//! once it has written what it keeps. Invariant: such a wait ends within a second of the signal, or of its own start if
//! that is later, and the program no later than the grace of [`begin`] after that.

use std::ffi::c_int;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Longest wait for a device after a signal. Lower: a frame of a loaded machine is lost. Higher: the program ends late.
const MAX_WAIT: Duration = Duration::from_millis(500);
const POLL: Duration = Duration::from_millis(20);

static BEGAN: OnceLock<Instant> = OnceLock::new();
static LEFT: AtomicBool = AtomicBool::new(false);

/// Notes that a signal asks the program to end; a second call ends it at once with the exit code.
///
/// If a wait for a device is given up, the process ends by [`finish`], or else `grace` after it: `keep` stores what would
/// be lost then.
pub fn begin(code: u8, grace: Duration, keep: impl FnOnce() + Send + 'static) {
    if BEGAN.set(Instant::now()).is_err() {
        exit_at_once(code);
    }
    thread::spawn(move || {
        while !LEFT.load(Ordering::Relaxed) {
            thread::sleep(POLL);
        }
        thread::sleep(grace);
        keep();
        exit_at_once(code);
    });
}

/// Ends the process with this code if a device was left at work, whose driver may never let it end; else does nothing.
pub fn finish(code: u8) {
    if LEFT.load(Ordering::Relaxed) {
        exit_at_once(code);
    }
}

/// Whether a wait that began at `start` is to be given up, since a signal asks the program to end.
pub fn gives_up(start: Instant) -> bool {
    BEGAN.get().is_some_and(|began| began.elapsed() > MAX_WAIT) && start.elapsed() > MAX_WAIT
}

/// Notes that a device was left at work: the process ends soon.
pub(super) fn leave_device() {
    LEFT.store(true, Ordering::Relaxed);
}

// SAFETY: the function of POSIX and of Windows has this type, and takes any number.
unsafe extern "C" {
    safe fn _exit(code: c_int) -> !;
}

/// Ends the process without the exit handlers of its libraries: they free objects that threads of a driver still use, or
/// wait for those threads.
pub fn exit_at_once(code: u8) -> ! {
    _exit(code.into())
}
