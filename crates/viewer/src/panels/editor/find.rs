//! Search in the text.

use crate::panels::widgets::{button, named};
use egui::{Id, Key, TextEdit, Ui};
use std::ops::Range;

/// State of the search.
#[derive(Default)]
pub(super) struct Find {
    pub(super) text: String,
    /// Index of the current match.
    at: usize,
}

impl Find {
    /// Index of the current match.
    pub(super) fn current(&self) -> usize {
        self.at
    }

    /// Shows the field and its buttons; returns a match to go to. `asked` moves the focus to the field.
    pub(super) fn show(&mut self, ui: &mut Ui, text: &str, asked: bool) -> Option<Range<usize>> {
        let edit = TextEdit::singleline(&mut self.text).id(Id::new("author.find")).hint_text("find (Ctrl+F)");
        let response = ui.add(edit.desired_width(120.0));
        named(ui, &response, "author.find");
        if asked {
            response.request_focus();
        }
        let all = matches(text, &self.text);
        let entered = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        let back = entered && ui.input(|input| input.modifiers.shift);
        let previous = button(ui, "⏶", "author.find.previous", "The match before (Shift+Enter).").clicked() || back;
        let next = button(ui, "⏷", "author.find.next", "The next match (Enter).").clicked() || (entered && !back);
        if entered {
            response.request_focus(); // for the one after it
        }
        let count = all.len();
        let changed = response.changed();
        self.at = if count == 0 || changed {
            0
        } else if next {
            (self.at + 1) % count
        } else if previous {
            (self.at + count - 1) % count
        } else {
            self.at.min(count - 1)
        };
        if !self.text.is_empty() {
            ui.label(if count == 0 { "none".into() } else { format!("{} of {count}", self.at + 1) });
        }
        (changed || next || previous).then(|| all.get(self.at).cloned()).flatten()
    }
}

/// Matches in any case, as byte ranges without overlap.
pub(super) fn matches(text: &str, word: &str) -> Vec<Range<usize>> {
    if word.is_empty() {
        return Vec::new();
    }
    let (text, word) = (text.to_ascii_lowercase(), word.to_ascii_lowercase());
    text.match_indices(&word).map(|(at, found)| at..at + found.len()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn find_ignores_case_and_handles_multibyte_letters() {
        assert_eq!(matches("Noise, noise\nÄnoise", "noise"), [0..5, 7..12, 15..20]);
        assert_eq!(matches("aaaa", "aa"), [0..2, 2..4]);
        assert!(matches("noise", "").is_empty() && matches("noise", "fur").is_empty());
    }
}
