//! The panel with the GLSL editor.
//!
//! Role: the text of a module with completion, search, colors and compiler errors. Invariant: the text field keeps its
//! identity and its position when other controls appear or disappear.

mod complete;
mod field;
mod find;
mod highlight;
mod panel;
mod state;
mod text;

pub(super) use field::focus;
pub(super) use panel::{keep_focus, show};
pub(super) use state::Editor;
