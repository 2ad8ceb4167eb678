//! The crate `glsl`, with the shipped modules and a compiler in a child process.

pub mod compile;
mod shipped;

pub use hypertexture_glsl::*;
pub use shipped::{changed, shipped, shipped_with};
