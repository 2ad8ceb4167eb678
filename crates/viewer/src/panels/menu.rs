//! The menu bar.

use super::request::Request;
use super::widgets::named;
use crate::keys::{Action, KEYS};
use egui::{Button, MenuBar, Ui};
use std::path::PathBuf;

/// The menus with the actions of each. The list of keys has the same groups.
pub(crate) const MENUS: [(&str, &[Action]); 5] = [
    ("File", &[Action::Open, Action::Save]),
    (
        "Edit",
        &[Action::Undo, Action::Redo, Action::Paint, Action::Weaker, Action::Place, Action::Previous, Action::Next],
    ),
    (
        "View",
        &[
            Action::Reset,
            Action::Side(0),
            Action::Level,
            Action::Inertia,
            Action::Play,
            Action::Panels,
            Action::Controls,
            Action::FullScreen,
        ],
    ),
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

/// Items without a key.
pub(super) enum Item {
    SaveAs,
    Final,
    CopyCommand,
}

/// Shows the menus; returns the chosen item without a key.
pub(super) fn show(ui: &mut Ui, recent: &[PathBuf], requests: &mut Vec<Request>) -> Option<Item> {
    let mut chosen = None;
    MenuBar::new().ui(ui, |ui| {
        for (menu, actions) in MENUS {
            let shown = ui.menu_button(menu, |ui| {
                let mut add = |ui: &mut Ui, text: &str, item: Item| {
                    if entry(ui, text, "") {
                        chosen = Some(item);
                    }
                };
                for action in actions {
                    let Some(binding) = KEYS.iter().find(|binding| binding.action == *action) else { continue };
                    if entry(ui, binding.what, binding.name) {
                        requests.push(Request::Act(*action));
                    }
                }
                match menu {
                    "File" => {
                        add(ui, "save the scene as another file", Item::SaveAs);
                        for path in recent {
                            if entry(ui, &path.display().to_string(), "") {
                                requests.push(Request::Open(path.clone()));
                            }
                        }
                        if entry(ui, "quit", "") {
                            requests.push(Request::Quit);
                        }
                    }
                    "Edit" => add(ui, "copy the command that renders this picture", Item::CopyCommand),
                    "Render" => add(ui, "final picture, sequence, video, mesh, volume or page", Item::Final),
                    _ => {}
                }
            });
            named(ui, &shown.response, &format!("menu {menu}"));
        }
    });
    chosen
}

/// An item with its key; whether it was chosen.
fn entry(ui: &mut Ui, what: &str, key: &str) -> bool {
    let what = what.split([';', ':']).next().unwrap_or_default();
    let text: String = what.chars().take(1).flat_map(char::to_uppercase).chain(what.chars().skip(1)).collect();
    let response = ui.add(Button::new(&text).shortcut_text(key));
    let is_chosen = named(ui, &response, &format!("menu {what}")).clicked();
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
        for binding in KEYS.iter().filter(|binding| !binding.what.is_empty()) {
            let menus = MENUS.iter().filter(|(_, actions)| actions.contains(&binding.action)).count();
            assert_eq!(menus, 1, "{}", binding.name);
        }
    }
}
