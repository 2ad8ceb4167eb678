//! The module editor's model: a module is edited while the picture follows.
//!
//! Role: text -> a library that the scene links with, or compiler errors. Invariant: custom text meets the GLSL
//! compiler, the evaluator and the device first in a child process ([`hypertexture_measure::guard`]), whose crash or hang is one
//! error line ([`Gate`]); until a text passes, the model keeps its library and the picture its program.

mod files;
mod gate;
mod source;
mod trial;

pub(crate) use files::MAX_FILE;
pub use gate::Gate;
pub use source::{Author, State, WATCH};
