//! Live authoring: a module of the effect is edited while the picture follows.
//!
//! Role: text -> a library that the scene links with, or lines that say what is wrong. Invariant: text of a user meets
//! the GLSL compiler in a child process first ([`compile`]), so that a crash or a hang of it is one such line; until a
//! text is good, the model keeps its library and the picture its program.

mod arrays;
pub mod compile;
mod editor;
mod source;
mod trial;

pub use compile::Fault;
pub(crate) use editor::WRONG;
pub use editor::show;
pub use source::{Author, State};
pub(super) use trial::{programs, reaches};
