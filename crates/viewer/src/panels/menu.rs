//! The menu bar.

use super::widgets::named;
use crate::document::model::Model;
use crate::input::Command;
use crate::input::keys::KEYS;
use egui::{Button, MenuBar, Ui};
use std::path::PathBuf;

/// The menus with the commands of each. The list of keys has the same groups.
pub(crate) const MENUS: [(&str, &[Command]); 6] = [
    ("File", &[Command::New, Command::ChooseFile, Command::Save, Command::SaveAs, Command::Export, Command::AskToQuit]),
    (
        "Edit",
        &[
            Command::Undo,
            Command::Redo,
            Command::Duplicate,
            Command::Delete,
            Command::Place,
            Command::Paint,
            Command::WeakerBrush,
        ],
    ),
    (
        "View",
        &[
            Command::Frame,
            Command::ResetCamera,
            Command::Side(0),
            Command::LevelOrbit,
            Command::Inertia,
            Command::Panels,
            Command::FocusControls,
            Command::FullScreen,
        ],
    ),
    ("Scene", &[Command::Play, Command::PreviousPreset, Command::NextPreset]),
    (
        "Render",
        &[
            Command::WritePicture,
            Command::Turntable,
            Command::Compare,
            Command::NextComparison,
            Command::InspectPixel,
            Command::WorstPixel,
            Command::Validity,
        ],
    ),
    ("Help", &[Command::Help, Command::Lesson, Command::Leave]),
];

/// Shows the menus, with marks at switches that are on. `line` is the command line of the picture.
pub(super) fn show(
    ui: &mut Ui,
    recent: &[PathBuf],
    states: &[(Command, bool)],
    model: &Model,
    commands: &mut Vec<Command>,
) {
    MenuBar::new().ui(ui, |ui| {
        ui.set_max_width(ui.available_width());
        for (menu, entries) in MENUS {
            let shown = ui.menu_button(menu, |ui| {
                for command in entries {
                    let Some(binding) = KEYS.iter().find(|binding| binding.command == *command) else { continue };
                    let is_on = states.iter().any(|(own, on)| own == command && *on);
                    if entry(ui, binding.label, binding.name, is_on, binding.doc) {
                        commands.push(command.clone());
                    }
                    match command {
                        Command::ChooseFile if !recent.is_empty() => {
                            let recent = ui.menu_button("Recent", |ui| {
                                for path in recent {
                                    if entry(ui, &path.display().to_string(), "", false, "Open this file.") {
                                        commands.push(Command::Open(path.clone()));
                                    }
                                }
                            });
                            named(ui, &recent.response, "menu Recent");
                        }
                        Command::Delete
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
fn entry(ui: &mut Ui, label: &str, key: &str, is_on: bool, doc: &str) -> bool {
    let text = if is_on { format!("\u{2713} {label}") } else { label.to_string() };
    let response = ui.add(Button::new(text).shortcut_text(key)).on_hover_text(doc);
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
            let menus = MENUS.iter().filter(|(_, commands)| commands.contains(&binding.command)).count();
            assert_eq!(menus, 1, "{}", binding.name);
        }
    }
}
