//! History, presets and files.

use super::widgets::{button, named};
use super::{Act, Pass, Request};
use crate::scene;
use egui::{Button, Grid, Key, KeyboardShortcut, Modifiers, RichText, TextEdit, Ui};
use std::path::PathBuf;

const UNDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Z);
const REDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Y);

/// Undo, redo, the command line, and what the window is asked for.
pub(super) fn history(ui: &mut Ui, pass: &mut Pass<'_>, author_is_open: &mut bool) {
    let model = pass.model;
    ui.horizontal_wrapped(|ui| {
        let keys = !ui.ctx().egui_wants_keyboard_input();
        let mut step = |what: Option<&str>, text: &str, name: &str, shortcut: KeyboardShortcut| {
            let tip = what.map_or("nothing".into(), String::from);
            let pressed = keys && ui.input_mut(|input| input.consume_shortcut(&shortcut));
            let response = ui.add_enabled(what.is_some(), Button::new(text)).on_hover_text(format!("{text}: {tip}"));
            named(ui, &response, name).clicked() || (pressed && what.is_some())
        };
        if step(model.undoes(), "undo", "undo", UNDO) {
            pass.acts.push(Act::Undo);
        }
        if step(model.redoes(), "redo", "redo", REDO) {
            pass.acts.push(Act::Redo);
        }
        if button(ui, "copy command", "copy", "Copy the command line that renders this picture.").clicked() {
            ui.ctx().copy_text(model.command_line());
        }
        let editor = ui.toggle_value(author_is_open, "GLSL");
        named(ui, &editor, "author").on_hover_text("Edit the modules of the effect.");
    });
    ui.horizontal_wrapped(|ui| window(ui, pass));
}

fn window(ui: &mut Ui, pass: &mut Pass<'_>) {
    let status = pass.status;
    let mut ask = |ui: &mut Ui, on: bool, text: &str, doc: &str, request: Request| {
        let response = ui.selectable_label(on, text).on_hover_text(doc);
        if named(ui, &response, text).clicked() {
            pass.requests.push(request);
        }
    };
    ask(ui, status.paused, "pause", "Let time stand still.", Request::Pause(!status.paused));
    ask(ui, status.recording, "record", "Write every frame.", Request::Record(!status.recording));
    let other = (!status.split).then(|| Box::new(pass.model.scene().clone()));
    ask(ui, status.split, "compare", "Keep this scene beside the one that is edited.", Request::Split(other));
    ask(ui, false, "quit", "End the program.", Request::Quit);
}

/// Every preset: the whole of it, or its effect on the object that is there.
pub(super) fn presets(ui: &mut Ui, pass: &mut Pass<'_>) {
    Grid::new("presets").num_columns(2).striped(true).spacing([10.0, 4.0]).show(ui, |ui| {
        for name in scene::names() {
            let mut take = |ui: &mut Ui, text: &str, id: String, effect_only: bool| {
                let response = ui.button(text).on_hover_ui(|ui| {
                    ui.label(scene::preset(name).map(|preset| preset.about).unwrap_or_default());
                });
                if named(ui, &response, &id).clicked() {
                    pass.acts.push(Act::Preset { name: name.into(), effect_only });
                }
            };
            take(ui, name, format!("preset {name}"), false);
            take(ui, "effect only", format!("effect {name}"), true);
            ui.end_row();
        }
    });
}

/// Reading and writing.
pub(super) fn files(ui: &mut Ui, pass: &mut Pass<'_>, paths: &mut [String; 2], recent: &[PathBuf]) {
    let state = match (pass.model.file(), pass.model.is_dirty()) {
        (None, false) => "as it began".into(),
        (None, true) => "not saved".into(),
        (Some(file), false) => file.display().to_string(),
        (Some(file), true) => format!("{}, changed since", file.display()),
    };
    ui.label(RichText::new(state).weak());
    let [file, picture] = paths;
    let line = |ui: &mut Ui, path: &mut String, name: &str| {
        let response = ui.add(TextEdit::singleline(path).desired_width(190.0));
        named(ui, &response, name).on_hover_text("Path, from where the program was started.");
    };
    ui.horizontal(|ui| {
        line(ui, file, "file.scene");
        if button(ui, "open", "file.open", "Read a scene file (.toml), or take another file as the object.").clicked() {
            pass.acts.push(Act::Open(PathBuf::from(file.trim())));
        }
        if button(ui, "browse", "file.browse", "Choose a file (Ctrl+O).").clicked() {
            pass.acts.push(Act::Choose);
        }
        if button(ui, "save", "file.save", "Write the scene, complete with defaults.").clicked() {
            pass.acts.push(Act::Save(PathBuf::from(file.trim())));
        }
    });
    ui.horizontal(|ui| {
        line(ui, picture, "file.picture");
        if button(ui, "screenshot", "file.screenshot", "Write the picture that is shown: .png or .exr.").clicked() {
            pass.requests.push(Request::Screenshot(PathBuf::from(picture.trim())));
        }
    });
    for path in recent {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if button(ui, &name, &format!("recent {}", path.display()), &path.display().to_string()).clicked() {
            pass.acts.push(Act::Open(path.clone()));
        }
    }
}
