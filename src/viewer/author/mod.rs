//! Live authoring: a module of the effect is edited while the picture follows.
//!
//! Role: text -> a library that the scene links with, or lines that say what is wrong. Invariant: text of a user meets
//! the GLSL compiler in a child process first ([`crate::shader::compile`]), and the device in another one ([`rays`]), so that a crash or
//! a hang of either is one such line ([`Gate`]); until a text is good, the model keeps its library and the picture its
//! program.

mod gate;
pub mod rays;
mod source;
mod trial;

pub use gate::Gate;
pub(super) use source::MAX_FILE;
pub use source::{Author, State, WATCH};
