//! The shader library: modules, what they declare, and how they are linked into one program.
//!
//! Role: the only place that knows GLSL text. A *module* is one file of a slot's folder (`dmf/fur.glsl`); a *slot* is
//! filled for each program, so that a program holds the modules it needs and nothing else. Invariant: linking is a
//! pure function of the library, the entry file and the chosen modules.
//! `build.rs` compiles the shipped programs through the very same files.

#[doc(hidden)] // for the tests of this crate
pub mod combine;
pub mod declare;
pub mod drift;
mod error;
pub mod file;
#[cfg_attr(not(feature = "compiler"), path = "no_glslang.rs")]
mod glslang;
mod instance;
mod kind;
mod layers;
pub mod library;
#[doc(hidden)] // for the tests of this crate
pub mod link;
mod names;
#[doc(hidden)] // for the tests of this crate
pub mod reach;
mod rounding;
mod stage;
mod watched;
mod words;

pub use combine::{Formula, FormulaError};
pub use declare::{Declarations, Parameter, ParameterKind};
pub use error::{LibraryError, LinkError};
pub use kind::Kind;
pub use library::{Library, Slots};
pub use link::Linker;
pub use names::{is_reserved, reserved, tokens};
pub use reach::{Reach, Sides};
pub use stage::Stage;
pub use watched::FAULT;
pub use words::instructions;

#[cfg(test)]
fn shipped() -> Library {
    Library::read(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../glsl")).unwrap()
}
