//! What is asked before something would be lost, and which file is meant.

use super::context::Act;
use super::request::Request;
use super::widgets::button;
use crate::model::Model;
use crate::unsaved;
use egui::{Id, Modal, RichText, Ui};
use egui_file_dialog::{DialogMode, DialogState, FileDialog};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use support::{open, write_whole};

/// Files that are remembered.
const RECENT: usize = 8;
/// The longest list of them that is read, in bytes.
const MAX_LIST: u64 = 1 << 16;

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub enum Question {
    /// Whether the window is to close.
    Quit,
    /// Whether the scene is written over a file that the window did not write.
    Scene(PathBuf),
    /// Whether the picture is.
    Picture(PathBuf),
}

/// What is asked, and the files that there are to be opened.
#[derive(Default)]
pub(super) struct Dialogs {
    pub(super) question: Option<Question>,
    dialog: FileDialog,
    /// Folders of what was not saved by windows before this one, the newest first.
    pub(super) kept: Vec<PathBuf>,
    /// Files that were opened, the last one first.
    pub(super) recent: Vec<PathBuf>,
    /// Where these are listed.
    list: Option<PathBuf>,
    /// The scene and the object that were seen last.
    seen: [PathBuf; 2],
    /// Pictures that this window has written.
    pictures: BTreeSet<PathBuf>,
}

impl Dialogs {
    /// Takes over what windows before this one have kept, and the files that they have opened, which `folder` lists.
    pub(super) fn remember(&mut self, kept: Vec<PathBuf>, folder: Option<PathBuf>) {
        self.kept = kept;
        self.list = folder.map(|folder| folder.join("recent"));
        let list = self.list.as_deref().and_then(|list| open::text(list, MAX_LIST).ok()).unwrap_or_default();
        self.recent = list.lines().map(PathBuf::from).filter(|path| path.exists()).take(RECENT).collect();
    }

    pub(super) fn is_open(&self) -> bool {
        self.question.is_some() || *self.dialog.state() == DialogState::Open
    }

    /// Asks for a file.
    pub(super) fn choose(&mut self) {
        self.dialog.pick_file();
    }

    /// The picture may be written there, or it is asked whether it may.
    pub(super) fn picture(&mut self, path: PathBuf) -> Option<Request> {
        if path.exists() && !self.pictures.contains(&path) {
            self.question = Some(Question::Picture(path));
            return None;
        }
        self.pictures.insert(path.clone());
        Some(Request::Screenshot(path))
    }

    /// The scene may be written there, or it is asked whether it may.
    pub(super) fn scene(&mut self, path: PathBuf, model: &mut Model) {
        if model.would_replace(&path) {
            self.question = Some(Question::Scene(path));
        } else {
            model.save(&path);
        }
    }

    /// Writes the scene to its file, or to the one that the panel names, or asks for a name.
    pub(super) fn save(&mut self, model: &mut Model, named: &str) {
        let named = Some(named.trim()).filter(|named| !named.is_empty()).map(PathBuf::from);
        match model.file().map(Path::to_path_buf).or(named) {
            Some(path) => self.scene(path, model),
            None => {
                self.dialog = FileDialog::new().default_file_name("scene.toml");
                self.dialog.save_file();
            }
        }
    }

    /// Remembers the scene and the object that were opened.
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
        self.recent.truncate(RECENT);
        let lines: String = self.recent.iter().map(|path| format!("{}\n", path.display())).collect();
        if let Some(list) = &self.list
            && let Err(error) = write_whole(list, lines.as_bytes())
        {
            log::info!("{}: {error}", list.display());
        }
    }

    /// Shows the question or the dialog; what was decided. `file` is where a scene without a file is saved, if it is named;
    /// `at_stake` is what would end with the window.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        model: &mut Model,
        file: &str,
        at_stake: Option<String>,
    ) -> Option<Request> {
        self.note(model);
        if let Some(path) = self.dialog.update(ui).picked() {
            let path = path.to_path_buf();
            let was = std::mem::take(&mut self.dialog);
            match (was.mode(), path.extension()) {
                (DialogMode::SaveFile, Some(_)) => drop(model.save(&path)),
                // The dialog has asked about a file of another name.
                (DialogMode::SaveFile, None) => self.scene(path.with_extension("toml"), model),
                _ => return Some(Request::Open(path)),
            }
            return None;
        }
        let question = self.question.clone()?;
        let shown = Modal::new(Id::new("question")).show(ui.ctx(), |ui| answer(ui, &question, model, at_stake));
        let closes = shown.should_close();
        let answer = shown.inner.or(closes.then_some(Answer::No))?;
        self.question = None;
        match (answer, question) {
            (Answer::No, _) => None,
            (Answer::Yes, Question::Quit) => Some(Request::Quit),
            (Answer::Yes, Question::Scene(path)) => {
                model.save(&path);
                None
            }
            (Answer::Yes, Question::Picture(path)) => {
                self.pictures.insert(path.clone());
                Some(Request::Screenshot(path))
            }
            (Answer::Save, _) => {
                self.save(model, file);
                (!model.is_dirty()).then_some(Request::Quit)
            }
        }
    }

    /// What was not saved by a window before this one.
    pub(super) fn offer(&mut self, ui: &mut Ui, acts: &mut Vec<Act>) {
        let Some(folder) = self.kept.first().cloned() else { return };
        ui.horizontal_wrapped(|ui| {
            let count = if self.kept.len() > 1 { format!(" ({} in all)", self.kept.len()) } else { String::new() };
            ui.label(RichText::new(format!("not saved, kept {}{count}", age(&folder))).strong())
                .on_hover_text(folder.display().to_string());
            if button(ui, "open it", "kept.open", "Show the scene and its modules as they were.").clicked() {
                acts.push(Act::Restore(folder.clone()));
                self.kept.remove(0);
            }
            if button(ui, "not now", "kept.later", "It stays where it is, and is offered again.").clicked() {
                self.kept.clear();
            }
            if button(ui, "delete", "kept.delete", "It is gone for good.").clicked() {
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

fn answer(ui: &mut Ui, question: &Question, model: &Model, at_stake: Option<String>) -> Option<Answer> {
    ui.set_max_width(420.0);
    let (line, yes, no) = match question {
        Question::Quit => (at_stake.unwrap_or_else(|| "Quit?".into()), "quit", "stay"),
        Question::Scene(path) | Question::Picture(path) => {
            (format!("{} is there, and was not written by this window.", path.display()), "replace it", "keep it")
        }
    };
    ui.label(line);
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        let mut answer = None;
        if button(ui, yes, "ask.yes", "").clicked() {
            answer = Some(Answer::Yes);
        }
        if *question == Question::Quit && model.is_dirty() && button(ui, "save and quit", "ask.save", "").clicked() {
            answer = Some(Answer::Save);
        }
        if button(ui, no, "ask.no", "").clicked() {
            answer = Some(Answer::No);
        }
        answer
    })
    .inner
}

/// How long ago something was kept in a folder.
fn age(folder: &Path) -> String {
    let passed = folder.metadata().and_then(|about| about.modified()).ok().and_then(|then| then.elapsed().ok());
    match passed.map_or(0, |passed| passed.as_secs() / 60) {
        0..2 => "just now".into(),
        minutes @ 2..120 => format!("{minutes} minutes ago"),
        minutes @ 120..2880 => format!("{} hours ago", minutes / 60),
        minutes => format!("{} days ago", minutes / 1440),
    }
}

/// The scene and the modules that were kept in a folder, as they were.
pub(super) fn restore(folder: &Path, model: &mut Model, author: &mut crate::author::Author) {
    let scene = folder.join("scene.toml");
    if scene.exists() && !model.open(&scene) {
        return;
    }
    for module in unsaved::modules(folder) {
        if let Err(error) = author.watch(model.library(), &module) {
            model.say(error);
        }
    }
}
