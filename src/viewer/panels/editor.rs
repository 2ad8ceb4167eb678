//! The panel in which a module is edited.

use super::widgets::{button, named};
use crate::shader::compile::Fault;
use crate::viewer::author::{Author, State, WATCH};
use crate::viewer::model::Model;
use egui::text::{LayoutJob, TextFormat};
use egui::{Align2, Color32, FontId, Id, RichText, ScrollArea, TextEdit, Ui};
use std::path::PathBuf;

/// Background of a line that is wrong.
const WRONG_LINE: Color32 = Color32::from_rgb(72, 24, 28);
/// Text about it.
const WRONG: Color32 = Color32::from_rgb(255, 130, 120);
const COMMENT: Color32 = Color32::from_rgb(122, 142, 122);
const DECLARATION: Color32 = Color32::from_rgb(226, 178, 96);
const FONT: FontId = FontId::monospace(13.0);
/// The list of modules leaves out what is no slot of an effect.
const NO_SLOTS: [&str; 2] = ["doctor", "combine"];

/// Shows the editor; what the text fields hold lives in the memory of `ui`. To be called once for each frame: it polls.
pub(super) fn show(ui: &mut Ui, author: &mut Author, model: &mut Model) {
    author.poll(model);
    ui.horizontal_wrapped(|ui| {
        chooser(ui, author, model);
        let (slot, name) = author.module();
        let used = model
            .scene()
            .slots(model.library())
            .get(slot)
            .is_some_and(|names| names.iter().any(|filled| filled.split('@').any(|part| part == name)));
        let is_there = model.library().source(&author.path()).is_some();
        ui.add_enabled_ui(!used && is_there, |ui| {
            if button(ui, "use", "author.use", "Put this module into its slot of the scene.").clicked() {
                author.use_in(model);
            }
        });
        if button(ui, "shipped text", "author.reset", "Take back every change of this module.").clicked() {
            author.reset();
            author.touch();
        }
    });
    ui.horizontal_wrapped(|ui| files(ui, author, model));
    contest(ui, author);
    verdict(ui, author);
    ui.separator();
    text(ui, author);
    // A compiler that answers and a file that changes are seen without a move of the mouse.
    let wait = if *author.state() == State::Compiling { 30 } else { WATCH.as_millis() as u64 };
    ui.ctx().request_repaint_after(std::time::Duration::from_millis(wait));
}

/// The module that is edited, out of all.
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
    named(ui, &shown.response, "author.module").on_hover_text("The module that is edited.");
    if let Some((slot, name)) = chosen {
        author.open(library, &slot, &name);
    }
}

/// A name for a copy, and a file to write or to follow.
fn files(ui: &mut Ui, author: &mut Author, model: &mut Model) {
    let id = ui.id().with("author.field");
    let mut field: String = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    let edit = TextEdit::singleline(&mut field).hint_text("new_name or path/NAME.glsl").desired_width(180.0);
    let response = ui.add(edit);
    named(ui, &response, "author.name");
    let fork = button(ui, "new module", "author.fork", "Make a new module of this text, with this name.").clicked();
    let save = button(ui, "save as", "author.save", "Write the text to this file, and follow the file.").clicked();
    let follow = button(
        ui,
        "follow file",
        "author.follow",
        "Edit the module in an editor of your own: the picture follows the file. The folder is the slot, dmf if it is none.",
    )
    .clicked();
    let done = match (fork, save, follow) {
        (true, ..) => author.fork(model.library(), field.trim()),
        (_, true, _) => author.save(&PathBuf::from(field.trim())),
        (.., true) => author.watch(model.library(), &PathBuf::from(field.trim())),
        _ => Ok(()),
    };
    if let Err(error) = done {
        model.say(error);
    }
    ui.data_mut(|data| data.insert_temp(id, field));
    if let Some(file) = author.file() {
        ui.label(RichText::new(format!("follows {}", file.display())).weak());
    }
}

/// The text here and that of the file, where both have changed.
fn contest(ui: &mut Ui, author: &mut Author) {
    if author.is_contested() {
        ui.horizontal_wrapped(|ui| {
            ui.label(
                RichText::new("another program has written to the file, and the text here is another").color(WRONG),
            );
            if button(ui, "take the file", "author.theirs", "What was typed here since is gone.").clicked() {
                author.settle(true);
            }
            if button(ui, "keep this text", "author.ours", "`save as` replaces what the other program wrote.").clicked()
            {
                author.settle(false);
            }
        });
    }
}

/// What became of the text, with every fault.
fn verdict(ui: &mut Ui, author: &Author) {
    match author.state() {
        State::Good => drop(ui.label(RichText::new("good: this is what the picture is made of").weak())),
        State::Compiling => drop(ui.label(RichText::new("compiling ...").weak())),
        State::Bad(faults) => {
            for fault in faults {
                let text = match &fault.at {
                    Some((path, line)) => format!("{path}:{line}: {}", fault.text),
                    None => fault.text.clone(),
                };
                ui.label(RichText::new(text).color(WRONG).monospace());
            }
            ui.label(RichText::new("the picture shows the last good text").weak());
        }
    }
}

/// Line numbers and text; a wrong line is marked, with the message at its end.
fn text(ui: &mut Ui, author: &mut Author) {
    let path = author.path();
    let faults: Vec<Fault> = match author.state() {
        State::Bad(faults) => faults.clone(),
        _ => Vec::new(),
    };
    let here = |line: usize| {
        faults.iter().find(|fault| fault.at.as_ref().is_some_and(|(file, at)| *file == path && *at == line))
    };
    ScrollArea::both().id_salt("author.text").auto_shrink(false).show(ui, |ui| {
        ui.horizontal_top(|ui| {
            let lines = author.text.matches('\n').count() + 1;
            let numbers = (1..=lines).map(|line| format!("{line:>3}")).collect::<Vec<_>>().join("\n");
            ui.add_space(2.0);
            ui.vertical(|ui| {
                ui.add_space(2.0); // the margin of the text beside it
                ui.label(RichText::new(numbers).font(FONT).weak());
            });
            let mut layouter = |ui: &Ui, buffer: &dyn egui::TextBuffer, _: f32| {
                ui.fonts_mut(|fonts| fonts.layout_job(layout(buffer.as_str(), &here)))
            };
            // Whatever comes and goes around it, it is the same field, and keeps the keys.
            let edit = TextEdit::multiline(&mut author.text)
                .id(Id::new("author.text"))
                .font(FONT)
                .desired_width(f32::INFINITY)
                .desired_rows(24);
            let shown = edit.lock_focus(true).layouter(&mut layouter).show(ui);
            named(ui, &shown.response, "author.text");
            for (row, line) in shown.galley.rows.iter().zip(1..) {
                if let Some(fault) = here(line) {
                    let at = shown.galley_pos + row.rect().right_center().to_vec2() + egui::vec2(16.0, 0.0);
                    ui.painter().text(at, Align2::LEFT_CENTER, format!("◀ {}", fault.text), FONT, WRONG);
                }
            }
            if shown.response.changed() {
                author.touch();
            }
        });
    });
}

/// The text with its comments and declarations told apart; lines are not wrapped, so that a row is a line.
fn layout<'a>(text: &str, wrong: &dyn Fn(usize) -> Option<&'a Fault>) -> LayoutJob {
    let mut job = LayoutJob { break_on_newline: true, ..LayoutJob::default() };
    for (line, number) in text.split_inclusive('\n').zip(1..) {
        let trimmed = line.trim_start();
        let color = match () {
            () if trimmed.starts_with("// @") => DECLARATION,
            () if trimmed.starts_with("//") => COMMENT,
            () => Color32::from_gray(214),
        };
        let background = if wrong(number).is_some() { WRONG_LINE } else { Color32::TRANSPARENT };
        job.append(line, 0.0, TextFormat { background, ..TextFormat::simple(FONT, color) });
    }
    job
}
