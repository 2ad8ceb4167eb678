//! The editor of a GLSL module.

use super::field::focus;
use super::state::Editor;
use super::text;
use crate::document::author::{Author, State};
use crate::document::model::Model;
use crate::panels::widgets::{button, named};
use egui::{Key, Label, Modifiers, Panel, Popup, Rect, RichText, ScrollArea, Sense, TextEdit, Ui};
use std::path::Path;

/// Height of the area for errors, points; constant, so that the text does not move.
const VERDICT: f32 = 84.0;
/// Slots whose modules cannot be edited.
const NO_SLOTS: [&str; 2] = ["doctor", "combine"];

/// Returns the focus to the text field after a click in the editor that has taken it.
pub(in crate::panels) fn keep_focus(ui: &Ui, place: Rect) {
    let is_clicked = ui.input(|input| {
        let pointer = &input.pointer;
        pointer.any_released() && pointer.interact_pos().is_some_and(|at| place.contains(at))
    });
    if is_clicked && !ui.ctx().egui_wants_keyboard_input() && !Popup::is_any_open(ui.ctx()) {
        focus(ui);
    }
}

/// Shows the editor. Called once per frame: it polls.
pub(in crate::panels) fn show(ui: &mut Ui, author: &mut Author, model: &mut Model, editor: &mut Editor) {
    author.poll(model);
    ui.horizontal_wrapped(|ui| {
        chooser(ui, author, model);
        let (slot, name) = author.module();
        let used = model
            .scene()
            .slots(model.library())
            .get(slot)
            .is_some_and(|names| names.iter().any(|filled| filled.split('@').any(|part| part == name)));
        let is_there = model.library().source(&author.path()).is_some() || *author.state() == State::Compiling;
        ui.add_enabled_ui(!used && is_there, |ui| {
            if button(ui, "use", "author.use", "Put this module into its slot of the scene.").clicked() {
                author.use_in(model);
            }
        });
        if button(ui, "shipped text", "author.reset", "Revert this module to its shipped text.").clicked() {
            author.reset();
            author.touch();
        }
    });
    ui.horizontal_wrapped(|ui| files(ui, author, model));
    ui.horizontal_wrapped(|ui| {
        let wraps = ui.toggle_value(&mut editor.wraps, "wrap");
        named(ui, &wraps, "author.wrap").on_hover_text("Wrap long lines.");
        let asked = ui.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::F));
        if let Some(found) = editor.find.show(ui, &author.text, asked) {
            editor.go_to = Some(found);
        }
    });
    ui.separator();
    Panel::bottom("author.verdict").exact_size(VERDICT).show(ui, |ui| {
        ScrollArea::vertical().id_salt("author.verdict").auto_shrink(false).show(ui, |ui| {
            contest(ui, author);
            verdict(ui, author, editor);
        });
    });
    text::show(ui, author, model, editor);
}

/// The list of modules.
fn chooser(ui: &mut Ui, author: &mut Author, model: &Model) {
    let library = model.library();
    let mut paths: Vec<(&str, &str)> = library
        .sources()
        .map(|(path, _)| path)
        .chain(author.drafts().map(|(path, _)| path))
        .filter_map(|path| path.strip_suffix(".glsl")?.split_once('/'))
        .filter(|(slot, _)| !NO_SLOTS.contains(slot))
        .collect();
    let (slot, name) = author.module();
    paths.push((slot, name));
    paths.sort_unstable();
    paths.dedup();
    let mut chosen = None;
    let combo = egui::ComboBox::from_id_salt("author.module").width(190.0).height(420.0);
    let shown = combo.selected_text(format!("{slot}/{name}")).show_ui(ui, |ui| {
        for (other_slot, other) in &paths {
            let is_it = (*other_slot, *other) == (slot, name);
            if ui.selectable_label(is_it, format!("{other_slot}/{other}")).clicked() && !is_it {
                chosen = Some((other_slot.to_string(), other.to_string()));
            }
        }
    });
    named(ui, &shown.response, "author.module").on_hover_text("The edited module.");
    if let Some((slot, name)) = chosen {
        author.open(library, &slot, &name);
    }
}

/// The field for a module name or a file, and its buttons.
fn files(ui: &mut Ui, author: &mut Author, model: &mut Model) {
    let id = ui.id().with("author.field");
    let mut field: String = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    let edit = TextEdit::singleline(&mut field).hint_text("new_name or path/NAME.glsl").desired_width(180.0);
    let response = ui.add(edit);
    named(ui, &response, "author.name");
    let fork = button(ui, "new module", "author.fork", "Create a module with this name from the text.").clicked();
    let save = button(ui, "save as", "author.save", "Write the text to this file and follow it.").clicked();
    let follow = button(
        ui,
        "follow file",
        "author.follow",
        "Edit the module in an external editor: the picture follows the file. The folder names the slot, else the slot is dmf.",
    )
    .clicked();
    let done = if fork {
        author.fork(model.library(), field.trim())
    } else if save {
        author.save(Path::new(field.trim()))
    } else if follow {
        author.watch(model.library(), Path::new(field.trim()))
    } else {
        Ok(())
    };
    if let Err(error) = done {
        model.say(error);
    }
    ui.data_mut(|data| data.insert_temp(id, field));
    if let Some(file) = author.file() {
        ui.label(RichText::new(format!("follows {}", file.display())).weak());
    }
}

/// A deleted file, or a conflict between the file and the text.
fn contest(ui: &mut Ui, author: &mut Author) {
    if let Some(line) = author.complaint().filter(|_| author.is_gone()) {
        ui.label(RichText::new(line).color(ui.visuals().error_fg_color));
    } else if author.is_contested() {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new("the file and the text here have both changed").color(ui.visuals().error_fg_color));
            if button(ui, "take the file", "author.theirs", "Discard the changes here.").clicked() {
                author.settle(true);
            }
            if button(ui, "keep this text", "author.ours", "Keep the changes here; `save as` overwrites the file.")
                .clicked()
            {
                author.settle(false);
            }
        });
    }
}

/// The result of the check, with all errors; a click on one goes to its line.
fn verdict(ui: &mut Ui, author: &Author, editor: &mut Editor) {
    match author.state() {
        State::Good => drop(ui.label(RichText::new("good: the picture uses this text").weak())),
        State::Compiling => drop(ui.label(RichText::new("compiling ...").weak())),
        State::Bad(faults) => {
            ui.label(RichText::new("the picture shows the last good text").weak());
            for fault in faults {
                let text = match &fault.at {
                    Some((path, line)) => format!("{path}:{line}: {}", fault.text),
                    None => fault.text.clone(),
                };
                let label = Label::new(RichText::new(text).color(ui.visuals().error_fg_color).monospace())
                    .wrap()
                    .sense(Sense::click());
                let clicked = ui.add(label).clicked();
                if clicked {
                    focus(ui);
                }
                if let Some((_, line)) = fault.at.as_ref().filter(|(path, _)| clicked && *path == author.path()) {
                    editor.go_to = Some(line_at(&author.text, *line));
                }
            }
        }
    }
}

/// Bytes of a line, counted from 1, without its end.
fn line_at(text: &str, line: usize) -> std::ops::Range<usize> {
    let mut start = 0;
    for (index, row) in text.split_inclusive('\n').enumerate() {
        if index + 1 == line {
            return start..start + row.trim_end_matches('\n').len();
        }
        start += row.len();
    }
    text.len()..text.len()
}
