//! The GLSL compiler in a child process, and its errors.

mod allowed;
mod ask;
mod child;
mod error;

pub use allowed::refusal;
pub use ask::{Answer, Failure, Trial, read, reply, stage};
pub use child::{COMMAND, Job, Wanted, check_lengths, compile, compiler, link_allowed, names, serve};
pub use error::{CompileError, Fault};
pub use support::child::{Limits, limit};
