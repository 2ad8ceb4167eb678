//! The end of the process while a driver works.

use std::ffi::c_int;

// SAFETY: the function of POSIX and of Windows has this type, and takes any number.
unsafe extern "C" {
    safe fn _exit(code: c_int) -> !;
}

/// Ends the process without the exit handlers of its libraries, which free objects that threads of a driver still use.
pub fn exit_at_once(code: u8) -> ! {
    _exit(code.into())
}
