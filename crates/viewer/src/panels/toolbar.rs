//! Toolbar and file section.

use super::context::Pass;
use super::widgets::{button, named, toggle};
use crate::input::Command;
use egui::{Button, RichText, TextEdit, Ui};
use std::path::PathBuf;

/// Undo, redo, copy of the command line, editor, time, turntable, comparison and lesson.
pub(super) fn history(ui: &mut Ui, pass: &mut Pass<'_>, author_is_open: &mut bool) {
    let model = pass.model;
    ui.horizontal_wrapped(|ui| {
        let mut step = |what: Option<&str>, text: &str, name: &str, key: &str| {
            let tip = what.map_or("nothing".into(), String::from);
            let response = ui.add_enabled(what.is_some(), Button::new(text));
            named(ui, &response.on_hover_text(format!("{text}: {tip} ({key})")), name).clicked()
        };
        if step(model.undoes(), "Undo", "undo", "Ctrl+Z") {
            pass.commands.push(Command::Undo);
        }
        if step(model.redoes(), "Redo", "redo", "Ctrl+Shift+Z") {
            pass.commands.push(Command::Redo);
        }
        if button(ui, "Copy command", "copy", "Copy the command line that renders this picture.").clicked() {
            ui.ctx().copy_text(model.command_line());
        }
        *author_is_open ^= toggle(ui, *author_is_open, "GLSL", "author", "Edit the modules of the effect.").clicked();
    });
    ui.horizontal_wrapped(|ui| window(ui, pass));
}

fn window(ui: &mut Ui, pass: &mut Pass<'_>) {
    let status = pass.status;
    let mut ask = |ui: &mut Ui, on: bool, text: &str, name: &str, doc: &str, command: Command| {
        if toggle(ui, on, text, name, doc).clicked() {
            pass.commands.push(command);
        }
    };
    let (text, doc) =
        if status.paused { ("\u{25b6} Play", "Play (Space).") } else { ("\u{23f8} Pause", "Pause (Space).") };
    ask(ui, !status.paused, text, "pause", doc, Command::Play);
    let doc = "Write the pictures of a turntable, or stop (T).";
    ask(ui, status.recording, "Turntable", "record", doc, Command::Turntable);
    let doc = "Pin this scene and compare with it (C).";
    ask(ui, status.split, "Compare", "compare", doc, Command::Compare);
    let doc = "Slices, soft regions and turbulence of this scene, explained (L).";
    ask(ui, status.lesson, "How it works", "lesson", doc, Command::Lesson);
}

/// Fields and buttons for files.
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
        let edit = TextEdit::singleline(path).hint_text("scene.toml");
        let response = ui.add(edit.desired_width((ui.available_width() - 190.0).clamp(80.0, 190.0)));
        named(ui, &response, name).on_hover_text("Path, relative to the working directory.");
    };
    ui.horizontal_wrapped(|ui| {
        line(ui, file, "file.scene");
        if button(ui, "open", "file.open", "Open a scene file (.toml), or another file as the object.").clicked() {
            let file = file.trim();
            let command = if file.is_empty() { Command::ChooseFile } else { Command::Open(file.into()) };
            pass.commands.push(command);
        }
        if button(ui, "browse", "file.browse", "Choose a file (Ctrl+O).").clicked() {
            pass.commands.push(Command::ChooseFile);
        }
        if button(ui, "save", "file.save", "Write the scene, complete with defaults.").clicked() {
            let file = file.trim();
            pass.commands.push(if file.is_empty() { Command::Save } else { Command::SaveTo(file.into()) });
        }
    });
    ui.horizontal_wrapped(|ui| {
        line(ui, picture, "file.picture");
        if button(ui, "screenshot", "file.screenshot", "Write the current picture: .png or .exr.").clicked() {
            pass.commands.push(Command::Screenshot(PathBuf::from(picture.trim())));
        }
    });
    for path in recent {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if button(ui, &name, &format!("recent {}", path.display()), &path.display().to_string()).clicked() {
            pass.commands.push(Command::Open(path.clone()));
        }
    }
}
