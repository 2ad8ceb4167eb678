//! The scene that is being edited.
//!
//! Role: edits, their history, files. Invariant: [`Model::scene`] passes every check with [`Model::library`]; an edit
//! that does not is refused with one line and changes nothing.

mod animated;
mod files;
mod objects;
mod presets;
mod state;

pub use state::Model;
