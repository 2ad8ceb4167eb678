//! The menu bar.

use super::request::Request;
use super::widgets::named;
use crate::keys::{Action, KEYS};
use crate::model::Model;
use egui::{Button, MenuBar, Ui};
use std::path::PathBuf;

/// The menus with the actions of each. The list of keys has the same groups.
pub(crate) const MENUS: [(&str, &[Action]); 6] = [
    ("File", &[Action::New, Action::Open, Action::Save, Action::SaveAs, Action::Export, Action::Quit]),
    (
        "Edit",
        &[Action::Undo, Action::Redo, Action::Duplicate, Action::Delete, Action::Place, Action::Paint, Action::Weaker],
    ),
    (
        "View",
        &[
            Action::Frame,
            Action::Reset,
            Action::Side(0),
            Action::Level,
            Action::Inertia,
            Action::Panels,
            Action::Controls,
            Action::FullScreen,
        ],
    ),
    ("Scene", &[Action::Play, Action::Previous, Action::Next]),
    (
        "Render",
        &[
            Action::Screenshot,
            Action::Record,
            Action::Compare,
            Action::Look,
            Action::Inspect,
            Action::Worst,
            Action::Validity,
        ],
    ),
    ("Help", &[Action::Help, Action::Lesson, Action::Leave]),
];

/// Shows the menus, with marks at what is switched on.
pub(super) fn show(
    ui: &mut Ui,
    recent: &[PathBuf],
    states: &[(Action, bool)],
    model: &Model,
    requests: &mut Vec<Request>,
) {
    MenuBar::new().ui(ui, |ui| {
        ui.set_max_width(ui.available_width());
        for (menu, actions) in MENUS {
            let shown = ui.menu_button(menu, |ui| {
                for action in actions {
                    let Some(binding) = KEYS.iter().find(|binding| binding.action == *action) else { continue };
                    let is_on = states.iter().any(|(own, on)| own == action && *on);
                    if entry(ui, binding.label, binding.name, is_on, binding.what) {
                        requests.push(Request::Act(*action));
                    }
                    match action {
                        Action::Open if !recent.is_empty() => {
                            let recent = ui.menu_button("Recent", |ui| {
                                for path in recent {
                                    if entry(ui, &path.display().to_string(), "", false, "Open this file.") {
                                        requests.push(Request::Open(path.clone()));
                                    }
                                }
                            });
                            named(ui, &recent.response, "menu Recent");
                        }
                        Action::Delete
                            if entry(
                                ui,
                                "Copy command",
                                "",
                                false,
                                "copy the command line that renders this picture",
                            ) =>
                        {
                            ui.ctx().copy_text(model.command_line());
                        }
                        _ => {}
                    }
                }
            });
            named(ui, &shown.response, &format!("menu {menu}"));
        }
    });
}

/// An item with its key and its mark; whether it was chosen.
fn entry(ui: &mut Ui, label: &str, key: &str, is_on: bool, what: &str) -> bool {
    let text = if is_on { format!("\u{2713} {label}") } else { label.to_string() };
    let response = ui.add(Button::new(text).shortcut_text(key)).on_hover_text(what);
    let is_chosen = named(ui, &response, &format!("menu {label}")).clicked();
    if is_chosen {
        ui.close();
    }
    is_chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_action_of_a_key_is_in_one_menu() {
        for binding in KEYS.iter().filter(|binding| !binding.label.is_empty()) {
            let menus = MENUS.iter().filter(|(_, actions)| actions.contains(&binding.action)).count();
            assert_eq!(menus, 1, "{}", binding.name);
        }
    }
}
