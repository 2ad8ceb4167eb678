//! The shader library: modules, what they declare, and how they are linked into one program. Beside what the crate `glsl`
//! has, the modules that ship and the compiler in a process of its own.

pub mod compile;
mod shipped;

pub use glsl::*;
pub use shipped::{changed, shipped, shipped_with};
