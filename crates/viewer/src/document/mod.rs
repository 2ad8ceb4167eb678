//! The document: the scene with its modules, its groom and its final pictures.
//!
//! Role: edits, their history and their files. Invariant: no control and no device.

pub mod author;
pub(crate) mod exports;
pub mod model;
pub(crate) mod painting;
mod selection;
mod state;
pub mod unsaved;

pub(crate) use selection::Selection;
pub use state::Document;
