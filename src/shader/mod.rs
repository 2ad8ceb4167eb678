//! The shader library: modules, what they declare, and how they are linked into one program.
//!
//! Role: the only place that knows GLSL text. A *module* is one file of a slot's folder (`dmf/fur.glsl`); a *slot* is
//! filled for each program, so that a program holds the modules it needs and nothing else. Invariant: linking is a
//! pure function of the library, the entry file and the chosen modules.
//! `build.rs` compiles the shipped programs through the very same files.

#[doc(hidden)] // for the tests of this crate
pub mod combine;
#[cfg(feature = "measure")]
pub mod compile;
pub mod declare;
pub mod drift;
mod error;
pub mod file;
#[cfg_attr(not(feature = "glsl"), path = "no_glslang.rs")]
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
#[cfg(feature = "viewer")]
pub(crate) use names::{is_reserved, reserved, tokens};
pub use reach::{Reach, Sides};
pub use stage::Stage;
pub use watched::FAULT;
pub(crate) use words::instructions;

use std::collections::BTreeMap;
use std::sync::LazyLock;

include!(concat!(env!("OUT_DIR"), "/library.rs"));

/// The modules that ship with the program.
pub fn shipped() -> Library {
    static SHIPPED: LazyLock<Library> =
        LazyLock::new(|| Library::new(SHIPPED_SOURCES.iter().map(|(path, text)| (path.to_string(), text.to_string()))));
    SHIPPED.clone()
}

/// The modules that ship, with other files over them: path relative to the `glsl` folder, and text.
pub fn shipped_with(changed: BTreeMap<String, String>) -> Library {
    let shipped = SHIPPED_SOURCES.iter().map(|(path, text)| (path.to_string(), text.to_string()));
    Library::new(shipped.chain(changed))
}

/// The files of a library that are not as shipped.
pub fn changed(library: &Library) -> BTreeMap<String, String> {
    let shipped = shipped();
    let changed = library.sources().filter(|(path, text)| shipped.source(path) != Some(text));
    changed.map(|(path, text)| (path.into(), text.into())).collect()
}
