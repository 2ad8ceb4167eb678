//! The text field of the editor.

use egui::{FontId, Id, Ui};

pub(super) const FONT: FontId = FontId::monospace(13.0);

/// Id of the text field.
pub(super) fn field() -> Id {
    Id::new("author.text")
}

/// Gives the text field the keyboard focus.
pub(in crate::panels) fn focus(ui: &Ui) {
    ui.memory_mut(|memory| memory.request_focus(field()));
}
