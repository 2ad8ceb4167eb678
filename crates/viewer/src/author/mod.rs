//! Live authoring: a module of the effect is edited while the picture follows.
//!
//! Role: text -> a library that the scene links with, or lines that say what is wrong. Invariant: text of a user meets
//! the GLSL compiler, the evaluator and the device in a child process first ([`measure::guard`]), so that a crash or
//! a hang of any is one such line ([`Gate`]); until a text is good, the model keeps its library and the picture its
//! program.

mod gate;
mod source;
mod trial;

pub use gate::Gate;
pub(super) use source::MAX_FILE;
pub use source::{Author, State, WATCH};
