//! Questions before data loss, and the file dialog.

use super::widgets::button;
use crate::document::model::Model;
use crate::input::Command;
use egui::{Id, Modal, RichText, Ui};
use egui_file_dialog::{DialogMode, DialogState, FileDialog};
use hypertexture_support::{open, write_whole};
use std::path::{Path, PathBuf};

/// Length of the list of recent files.
const MAX_RECENT: usize = 8;
/// Size limit of the list, bytes.
const MAX_LIST: u64 = 1 << 16;

/// Warning before a new scene replaces one that is not saved.
const UNSAVED: &str = "The scene is not saved. Undo brings it back.";

/// A question to the user.
#[derive(Clone, Debug, PartialEq)]
pub enum Question {
    /// Close the window in spite of unsaved work?
    Quit,
    /// Begin a new scene though this one is not saved?
    New,
    /// Look at a print in a new scene though this one is not saved?
    Look,
    /// Replace a scene file that this window did not write?
    Scene(PathBuf),
    /// Replace a picture that this window did not write?
    Picture(PathBuf),
}

/// The open dialog, and the lists of files.
#[derive(Default)]
pub(super) struct Dialogs {
    pub(super) question: Option<Question>,
    /// Whether the question was shown in an earlier pass, and its first answer has had the focus.
    had_focus: bool,
    dialog: FileDialog,
    /// Folders with unsaved work of earlier windows, the newest first.
    pub(super) kept: Vec<PathBuf>,
    /// Recent files, the newest first.
    pub(super) recent: Vec<PathBuf>,
    /// Path of the list of recent files.
    list: Option<PathBuf>,
    /// The last scene file and object file.
    seen: [PathBuf; 2],
}

impl Dialogs {
    /// Takes over the unsaved work and the recent files of earlier windows.
    pub(super) fn remember(&mut self, kept: Vec<PathBuf>, folder: Option<PathBuf>) {
        self.kept = kept;
        self.list = folder.map(|folder| folder.join("recent"));
        let list = self.list.as_deref().and_then(|list| open::text(list, MAX_LIST).ok()).unwrap_or_default();
        self.recent = list.lines().map(PathBuf::from).filter(|path| path.exists()).take(MAX_RECENT).collect();
    }

    pub(super) fn is_open(&self) -> bool {
        self.question.is_some() || *self.dialog.state() == DialogState::Open
    }

    /// Opens the file dialog.
    pub(super) fn choose(&mut self) {
        self.dialog.pick_file();
    }

    /// Saves the scene, or asks first if that would replace a file.
    pub(super) fn scene(&mut self, path: PathBuf, model: &mut Model) {
        if model.would_replace(&path) {
            self.question = Some(Question::Scene(path));
        } else {
            model.save(&path);
        }
    }

    /// Saves the scene to its file or to the one in the panel, or opens the file dialog.
    pub(super) fn save(&mut self, model: &mut Model, named: &str) {
        let named = Some(named.trim()).filter(|named| !named.is_empty()).map(PathBuf::from);
        match model.file().map(Path::to_path_buf).or(named) {
            Some(path) => self.scene(path, model),
            None => self.save_as(model),
        }
    }

    /// Opens the file dialog for the name of a scene file.
    pub(super) fn save_as(&mut self, model: &Model) {
        let name = model.file().and_then(Path::file_name).map_or("scene.toml".into(), |name| name.to_string_lossy());
        self.dialog = FileDialog::new().default_file_name(&name);
        self.dialog.save_file();
    }

    /// Adds the opened files to the recent ones.
    fn note(&mut self, model: &Model) {
        let now = [model.file().map(Path::to_path_buf).unwrap_or_default(), PathBuf::from(&model.scene().object.input)];
        let fresh = now.iter().zip(&self.seen).filter(|(now, seen)| now != seen && now.is_file());
        let fresh: Vec<PathBuf> = fresh.filter_map(|(now, _)| std::path::absolute(now).ok()).collect();
        self.seen = now;
        if fresh.is_empty() || fresh.iter().all(|path| self.recent.first() == Some(path)) {
            return;
        }
        self.recent.retain(|path| !fresh.contains(path));
        self.recent.splice(0..0, fresh);
        self.recent.truncate(MAX_RECENT);
        let lines: String = self.recent.iter().map(|path| format!("{}\n", path.display())).collect();
        if let Some(list) = &self.list
            && let Err(error) = write_whole(list, lines.as_bytes())
        {
            log::info!("{}: {error}", list.display());
        }
    }

    /// Shows the question or the file dialog; returns the resulting command. `file` is the path in the panel,
    /// `at_stake` describes the unsaved work.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        model: &mut Model,
        file: &str,
        at_stake: Option<String>,
    ) -> Option<Command> {
        self.note(model);
        if let Some(path) = self.dialog.update(ui).picked() {
            let path = path.to_path_buf();
            let was = std::mem::take(&mut self.dialog);
            match (was.mode(), path.extension()) {
                (DialogMode::SaveFile, Some(_)) => drop(model.save(&path)),
                // The dialog has asked about the name without the extension.
                (DialogMode::SaveFile, None) => self.scene(path.with_extension("toml"), model),
                _ => return Some(Command::Open(path)),
            }
            return None;
        }
        let Some(question) = self.question.clone() else {
            self.had_focus = false;
            return None;
        };
        let had_focus = std::mem::replace(&mut self.had_focus, true);
        let ask = |ui: &mut Ui| answer(ui, &question, model, at_stake, had_focus);
        let shown = Modal::new(Id::new("question")).show(ui.ctx(), ask);
        let closes = shown.should_close();
        let answer = shown.inner.or(closes.then_some(Answer::No))?;
        (self.question, self.had_focus) = (None, false);
        match (answer, question) {
            (Answer::No, _) => None,
            (Answer::Yes, Question::Quit) => Some(Command::Quit),
            (Answer::Yes, Question::New) => Some(Command::Begin),
            (Answer::Yes, Question::Look) => Some(Command::Look),
            (Answer::Yes, Question::Scene(path)) => {
                model.save(&path);
                None
            }
            (Answer::Yes, Question::Picture(path)) => Some(Command::Screenshot(path)),
            (Answer::Save, question) => {
                self.save(model, file);
                let then = match question {
                    Question::New => Command::Begin,
                    Question::Look => Command::Look,
                    _ => Command::Quit,
                };
                (!model.is_dirty()).then_some(then)
            }
        }
    }

    /// Offers the unsaved work of earlier windows.
    pub(super) fn offer(&mut self, ui: &mut Ui, commands: &mut Vec<Command>) {
        let Some(folder) = self.kept.first().cloned() else { return };
        ui.horizontal_wrapped(|ui| {
            let count = if self.kept.len() > 1 { format!(" ({} in all)", self.kept.len()) } else { String::new() };
            ui.label(RichText::new(format!("unsaved work from {}{count}", age(&folder))).strong())
                .on_hover_text(folder.display().to_string());
            if button(ui, "open it", "kept.open", "Restore the scene and its modules.").clicked() {
                commands.push(Command::Restore(folder.clone()));
                self.kept.remove(0);
            }
            if button(ui, "not now", "kept.later", "Keep it and offer it again.").clicked() {
                self.kept.clear();
            }
            if button(ui, "delete", "kept.delete", "Delete it permanently.").clicked() {
                self.kept.remove(0);
                if let Err(error) = std::fs::remove_dir_all(&folder) {
                    log::warn!("{}: {error}", folder.display());
                }
            }
        });
        ui.separator();
    }
}

enum Answer {
    Yes,
    No,
    Save,
}

/// Shows a question with its answers. `had_focus` is whether its first answer has had the focus: the key that led to
/// the question answers nothing.
fn answer(
    ui: &mut Ui,
    question: &Question,
    model: &Model,
    at_stake: Option<String>,
    had_focus: bool,
) -> Option<Answer> {
    ui.set_max_width(420.0);
    let (line, yes, no) = match question {
        Question::Quit => (at_stake.unwrap_or_else(|| "Quit?".into()), "quit", "stay"),
        Question::New => (UNSAVED.into(), "new scene", "stay"),
        Question::Look => (UNSAVED.into(), "look at it", "stay"),
        Question::Scene(path) | Question::Picture(path) => {
            (format!("{} exists and was not written by this window.", path.display()), "replace it", "keep it")
        }
    };
    ui.label(line);
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        let mut answer = None;
        let first = button(ui, yes, "ask.yes", "Enter.");
        // Enter confirms, and Tab goes to the other answers.
        let is_free = ui.memory(|memory| memory.focused()).is_none();
        if is_free || !had_focus {
            first.request_focus();
        }
        let is_entered = is_free && ui.input(|input| input.key_pressed(egui::Key::Enter));
        if had_focus && (first.clicked() || is_entered) {
            answer = Some(Answer::Yes);
        }
        let ends = matches!(question, Question::Quit | Question::New | Question::Look);
        let text = if *question == Question::Quit { "save and quit" } else { "save first" };
        if ends && model.is_dirty() && button(ui, text, "ask.save", "").clicked() {
            answer = Some(Answer::Save);
        }
        if button(ui, no, "ask.no", "").clicked() {
            answer = Some(Answer::No);
        }
        answer
    })
    .inner
}

/// Age of a folder, in words.
fn age(folder: &Path) -> String {
    let passed = folder.metadata().and_then(|about| about.modified()).ok().and_then(|then| then.elapsed().ok());
    match passed.map_or(0, |passed| passed.as_secs() / 60) {
        0..2 => "just now".into(),
        minutes @ 2..120 => format!("{minutes} minutes ago"),
        minutes @ 120..2880 => format!("{} hours ago", minutes / 60),
        minutes => format!("{} days ago", minutes / 1440),
    }
}
