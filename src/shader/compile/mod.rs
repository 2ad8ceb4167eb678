//! The GLSL compiler in a child process, and its errors.

mod allowed;
mod child;
mod error;
mod explain;

pub use allowed::refusal;
pub use child::{JOB, Job, check_lengths, compile, link, serve};
pub use error::{CompileError, Fault, names};
pub use hypertexture_support::jobs::Limits;
