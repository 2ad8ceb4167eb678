//! Calls that fail when a test says so: of files here, of Vulkan in `gpu::faults`.

use std::cell::{Cell, RefCell};
use std::io;

thread_local! {
    /// Calls of this thread that still succeed before one fails.
    static LEFT: Cell<Option<usize>> = const { Cell::new(None) };
    /// Calls since then, by name.
    static CALLS: RefCell<Vec<&'static str>> = const { RefCell::new(Vec::new()) };
    /// The call of this thread that loses its device; empty once it is lost.
    static LOSES: Cell<Option<&'static str>> = const { Cell::new(None) };
    /// What the validation layer has said to this thread.
    static SAID: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
    /// Whether devices that this thread opens have calls that may fail.
    static ARE_ON: Cell<bool> = const { Cell::new(false) };
}

/// Lets calls of devices that this thread opens from now on fail as well, and notes messages of the validation layer.
pub fn turn_on() {
    ARE_ON.set(true);
}

/// Whether [`turn_on`] was called in this thread.
pub fn are_on() -> bool {
    ARE_ON.get()
}

/// Lets the call of this thread that comes after `left` others fail.
pub fn fail_after(left: usize) {
    LEFT.set(Some(left));
    CALLS.take();
}

/// Lets nothing fail any more. Result: the calls since [`fail_after`], by name, and whether one of them failed.
pub fn stop() -> (Vec<&'static str>, bool) {
    let reached = LEFT.take().is_none();
    let calls = CALLS.take();
    let failed = reached && !calls.is_empty();
    (calls, failed)
}

/// Lets the next call of this thread with that name lose the device, for good; with none, there is another device.
pub fn lose(call: Option<&'static str>) {
    LOSES.set(call);
}

/// Whether this call finds no device any more.
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

/// A call of the file system, which may fail.
///
/// # Errors
/// A test says so.
pub fn file(name: &'static str) -> io::Result<()> {
    match fails(name) {
        true => Err(io::Error::other(format!("{name}: no space left on device"))),
        false => Ok(()),
    }
}

/// Notes what the validation layer says.
pub fn note(message: &str) {
    if are_on() {
        SAID.with_borrow_mut(|said| said.push(message.into()));
    }
}

/// Takes what the validation layer has said to this thread.
pub fn said() -> Vec<String> {
    SAID.take()
}
