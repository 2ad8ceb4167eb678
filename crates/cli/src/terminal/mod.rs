//! Standard output and standard error: lines, progress and log messages.

mod lines;
mod log;
mod progress;

pub(crate) use lines::{UNSAID, absolute, aside, complain, say, say_json, silent};
pub(crate) use log::start as start_log;
#[cfg(feature = "viewer")]
pub(crate) use progress::listen;
pub(crate) use progress::{announced, with_progress};
