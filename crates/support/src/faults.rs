//! Fault injection for tests: file system calls here, Vulkan calls in `gpu::faults`. All state is per thread.

use std::cell::{Cell, RefCell};
use std::io;

thread_local! {
    /// Calls that still succeed before one fails.
    static LEFT: Cell<Option<usize>> = const { Cell::new(None) };
    /// Names of the calls since [`fail_after`].
    static CALLS: RefCell<Vec<&'static str>> = const { RefCell::new(Vec::new()) };
    /// The call that loses the device; empty once it is lost.
    static LOSES: Cell<Option<&'static str>> = const { Cell::new(None) };
    /// Messages of the validation layer.
    static SAID: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
    /// Whether new devices take part.
    static ARE_ON: Cell<bool> = const { Cell::new(false) };
}

/// Includes the Vulkan calls of devices opened from here on, and records validation messages.
pub fn turn_on() {
    ARE_ON.set(true);
}

/// Whether [`turn_on`] was called.
pub fn are_on() -> bool {
    ARE_ON.get()
}

/// Makes the call after `left` others fail.
pub fn fail_after(left: usize) {
    LEFT.set(Some(left));
    CALLS.take();
}

/// Stops injecting faults. Returns the names of the calls since [`fail_after`], and whether one failed.
pub fn stop() -> (Vec<&'static str>, bool) {
    let reached = LEFT.take().is_none();
    let calls = CALLS.take();
    let failed = reached && !calls.is_empty();
    (calls, failed)
}

/// Makes the next call of that name lose the device for good; `None` ends the loss.
pub fn lose(call: Option<&'static str>) {
    LOSES.set(call);
}

/// Whether this call finds the device lost.
pub fn is_lost(name: &'static str) -> bool {
    let is_lost = LOSES.get().is_some_and(|call| call.is_empty() || call == name);
    if is_lost {
        LOSES.set(Some(""));
    }
    is_lost
}

/// Whether this call fails.
pub fn fails(name: &'static str) -> bool {
    let Some(left) = LEFT.get() else { return false };
    CALLS.with_borrow_mut(|calls| calls.push(name));
    LEFT.set(left.checked_sub(1));
    left == 0
}

/// Marks a file system call that tests can make fail.
///
/// # Errors
/// The injected fault.
pub fn file(name: &'static str) -> io::Result<()> {
    if fails(name) { Err(io::Error::other(format!("{name}: no space left on device"))) } else { Ok(()) }
}

/// Records a message of the validation layer.
pub fn note(message: &str) {
    if are_on() {
        SAID.with_borrow_mut(|said| said.push(message.into()));
    }
}

/// Takes the recorded messages of the validation layer.
pub fn said() -> Vec<String> {
    SAID.take()
}
