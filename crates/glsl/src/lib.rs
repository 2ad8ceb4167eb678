//! The shader library: GLSL modules, their declarations, and linking them into programs.
//!
//! Role: the only place that knows GLSL text. A *module* is a file of a slot's folder (`dmf/fur.glsl`). *Slots* are filled per
//! program, which contains only the modules it needs. Invariant: linking is a pure function of the library, the entry file
//! and the chosen modules. Shipped programs are compiled by this crate too, in `build.rs`.

mod copies;
mod count;
pub mod declare;
pub mod drift;
mod error;
pub mod file;
mod formula;
#[cfg_attr(not(feature = "compiler"), path = "no_glslang.rs")]
mod glslang;
mod instance;
mod instrument;
mod kind;
mod layers;
pub mod library;
mod link;
mod names;
pub mod reach;
mod rounding;
pub mod slots;
pub mod spirv;
mod stage;
mod undefined;

pub use count::counting;
pub use declare::{Declarations, Parameter, ParameterKind};
pub use error::{LibraryError, LinkError};
pub use formula::{Formula, FormulaError};
pub use kind::DmfKind;
pub use library::Library;
pub use link::{Linker, linked_text};
pub use names::{find_word, is_reserved, members, reserved, suffixed, tokens};
pub use reach::{Reach, Sides};
pub use slots::Slots;
pub use stage::Stage;
pub use undefined::{Undefined, undefined};

#[cfg(test)]
fn shipped() -> Library {
    Library::read(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../glsl")).unwrap()
}
