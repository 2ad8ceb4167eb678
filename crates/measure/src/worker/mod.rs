//! Pictures rendered in a child process, so that a driver that crashes or hangs loses one picture only.
//!
//! Role: [`Painter`] renders in this process or in a [`Worker`], which restarts its process after a crash. The process is
//! this program with a hidden command ([`serve`]): it loads the object once, holds a renderer for each painter, and answers
//! line by line. Invariant: the limit of a picture is processor time, so that a busy machine does not cause failures; times
//! are measured in the process, where nothing else runs.

mod client;
mod protocol;
mod serve;

pub use client::{PATIENCE, Painter, Remote, Start, Worker};
pub use protocol::{COMMAND, Load};
pub use serve::serve;
