//! The GLSL compiler in a child process, and its errors.

mod allowed;
mod child;
mod error;

pub use allowed::refusal;
pub use child::{JOB, Job, check_lengths, compile, link, names, serve};
pub use error::{CompileError, Fault};
pub use hypertexture_support::jobs::Limits;
