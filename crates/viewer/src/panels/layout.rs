//! The panels around the picture, and the order of their sections.

use super::context::{Pass, prefix};
use super::dialogs::{self, Question};
use super::status::Status;
use super::{
    accuracy, bookmarks, camera, editor, effect, field_menu, file_info, finals, groom, keyframes, menu, messages,
    object, parameters, presets, settings, status_bar, theme, timeline, toolbar, transfer, widgets,
};
use crate::document::author::Author;
use crate::document::model::Model;
use crate::document::painting::Painting;
use crate::document::unsaved;
use crate::input::Command;
use crate::message::Message;
use egui::{CollapsingHeader, Id, Panel, PanelState, RichText, ScrollArea, Ui};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Default width of the panel with the settings, points.
const WIDTH: f32 = 376.0;
/// Minimal and maximal width of the panel, and its maximal fraction of the window.
const LEAST: f32 = 184.0;
const MOST: f32 = 640.0;
const PART: f32 = 0.36;
/// Default height of the timeline with its tracks, points.
const TRACKS: f32 = 178.0;
/// Height of the window below which the menus are in the panel, and the timeline is one row, points.
const LOW: f32 = 480.0;

/// State of the panels.
pub struct Panels {
    /// The selected additional object; `None` for the main one.
    selected: Option<String>,
    /// Objects that a click in the picture does not select and that are not placed.
    locked: BTreeSet<String>,
    /// The selected stop of the transfer map.
    stop: usize,
    known: file_info::FileInfo,
    /// Whether an iso-value of the selected object is being dragged.
    pub(crate) iso_drag: bool,
    dialogs: dialogs::Dialogs,
    bookmarks: bookmarks::Bookmarks,
    /// Paths of the scene file and of the picture.
    paths: [String; 2],
    /// The edited module.
    pub author: Author,
    editor: editor::Editor,
    pub(crate) author_is_open: bool,
    /// Whether the editor was open in the last pass.
    author_was_open: bool,
    /// Whether advanced settings are shown.
    advanced: bool,
    /// Whether presets bring their own object and view.
    with_own: bool,
    /// Whether the panels are hidden.
    pub hidden: bool,
    /// The chosen width of the panel, and its limit in the last pass.
    width: f32,
    most: f32,
    theme: theme::Chosen,
    keyframes: keyframes::Keyframes,
    pub(crate) finals: finals::Finals,
    pub(crate) painting: Painting,
    /// The folder of unsaved work that was restored since the last look.
    pub(crate) restored: Option<PathBuf>,
}

impl Panels {
    /// Panels for a model. `program` is the executable of hypertexture, which compiles edited modules.
    ///
    /// # Errors
    /// The library lacks the first module of the effect.
    pub fn new(program: PathBuf, model: &Model) -> Result<Panels, hypertexture::shader::LibraryError> {
        let effect = &model.scene().effect;
        let first = effect.dmf.first().map(|name| ("dmf", name.split('@').next().unwrap_or_default()));
        let (slot, name) = first.unwrap_or(("surface", &effect.surface));
        let author = Author::new(program, model.library(), slot, name)?;
        Ok(Panels {
            selected: None,
            locked: BTreeSet::new(),
            stop: 0,
            known: file_info::FileInfo::default(),
            iso_drag: false,
            dialogs: dialogs::Dialogs::default(),
            bookmarks: bookmarks::Bookmarks::default(),
            paths: [String::new(), "picture.png".into()],
            finals: finals::Finals::new(author.gate().clone()),
            author,
            editor: editor::Editor::default(),
            author_is_open: false,
            author_was_open: false,
            advanced: false,
            with_own: false,
            hidden: false,
            width: WIDTH,
            most: 0.0,
            theme: theme::Chosen::default(),
            keyframes: keyframes::Keyframes::default(),
            painting: Painting::default(),
            restored: None,
        })
    }

    /// Offers unsaved work of earlier windows, and reads recent files, bookmarks and theme from a folder of the
    /// cache.
    pub fn remember(&mut self, kept: Vec<PathBuf>, folder: Option<PathBuf>) {
        self.bookmarks = bookmarks::Bookmarks::of(folder.as_deref());
        self.theme.remember(folder.as_deref());
        self.dialogs.remember(kept, folder);
    }

    /// Description of what would end with the window: unsaved work, and a final picture in progress.
    pub fn at_stake(&self, model: &Model) -> Option<String> {
        let kept = |what: &str| format!("{what} is not saved. It is kept, and offered at the next start.");
        let text = || !unsaved::texts(model, &self.author).is_empty();
        let unsaved = match model.is_dirty() {
            true => Some(kept("The scene")),
            false => text().then(|| kept("The text of a module")),
        };
        let running = self.finals.progress().map(|progress| format!("The running render also ends ({progress})."));
        let all: Vec<String> = unsaved.into_iter().chain(running).collect();
        (!all.is_empty()).then(|| all.join("\n"))
    }

    /// The selected additional object.
    pub(crate) fn selected(&self) -> Option<&str> {
        self.selected.as_deref()
    }

    /// Selects an additional object, or the main one.
    pub(crate) fn select(&mut self, part: Option<String>) {
        self.selected = part;
    }

    /// Whether an object is locked: it is neither selected by a click in the picture nor placed.
    pub(crate) fn is_locked(&self, name: &str) -> bool {
        self.locked.contains(name)
    }

    /// Asks a question.
    pub fn ask(&mut self, question: Question) {
        self.dialogs.question = Some(question);
    }

    /// Whether a question or the file dialog is open, which own all keys.
    pub fn is_asking(&self) -> bool {
        self.dialogs.is_open()
    }

    /// Saves the scene to its file or to the one in the panel; asks for a path if there is neither, and before a file
    /// of another program is replaced.
    pub fn save(&mut self, model: &mut Model) {
        self.dialogs.save(model, &self.paths[0]);
    }

    /// Whether there is unsaved work.
    pub fn is_unsaved(&self, model: &Model) -> bool {
        model.is_dirty() || !unsaved::texts(model, &self.author).is_empty()
    }

    /// Removes the selected keyframe of the tracks, if they are shown; returns whether there was one.
    pub(crate) fn remove_key(&mut self, model: &mut Model) -> bool {
        !self.hidden && self.keyframes.remove_selected(model)
    }

    /// Shows the panels; the remaining area of `ui` is for the picture. Returns the commands for the window. Called once per
    /// frame.
    pub fn show(&mut self, ui: &mut Ui, model: &mut Model, status: &Status) -> Vec<Command> {
        self.theme.apply(ui.ctx());
        ui.spacing_mut().item_spacing.y = 5.0;
        let complaint = self.author.complaint().filter(|_| !self.author_is_open || self.hidden).map(Message::error);
        Panel::bottom("status").show(ui, |ui| status_bar::show(ui, status));
        let mut commands: Vec<Command> = Vec::new();
        if !self.hidden {
            let is_low = ui.available_height() < LOW;
            if !is_low {
                let recent = &self.dialogs.recent;
                let bar = |ui: &mut Ui| menu::show(ui, recent, &status.states, model, &mut commands);
                Panel::top("menu").show(ui, bar);
            }
            let fps = self.finals.fps();
            let time = match self.keyframes.shown {
                // A fixed height with a handle.
                true => Panel::bottom("tracks").resizable(true).default_size(TRACKS).size_range(96.0..=480.0),
                false => Panel::bottom("time"),
            };
            let row = is_low && !self.keyframes.shown;
            time.show(ui, |ui| timeline::show(ui, model, status, &mut self.keyframes, (fps, row), &mut commands));
            // In a small window, most of the area is for the picture.
            let most = (PART * ui.available_width()).clamp(LEAST, MOST);
            if std::mem::replace(&mut self.most, most) != most {
                // A wider window restores the chosen width.
                ui.data_mut(|data| data.remove::<PanelState>(Id::new("scene")));
            }
            let panel = Panel::right("scene").default_size(self.width.min(most)).size_range(LEAST..=most);
            let shown = panel.show(ui, |ui| {
                widgets::fit(ui);
                let mut chosen = Vec::new();
                if is_low {
                    // The menus of a low window take no height from the picture.
                    menu::show(ui, &self.dialogs.recent, &status.states, model, &mut chosen);
                }
                let mut commands = self.controls(ui, model, status);
                commands.extend(chosen);
                ui.take_available_width();
                commands
            });
            commands.extend(shown.inner);
            let width = shown.response.rect.width();
            self.width = if width < most { width } else { self.width };
        }
        if self.author_is_open && !self.hidden {
            let panel = Panel::left("author").default_size(520.0).size_range(280.0..=1200.0).show(ui, |ui| {
                ui.add_space(4.0);
                editor::show(ui, &mut self.author, model, &mut self.editor);
            });
            editor::keep_focus(ui, panel.response.rect);
            if !std::mem::replace(&mut self.author_was_open, true) {
                editor::focus(ui);
            }
        } else {
            self.author_was_open = false;
            if self.author.poll(model) {
                ui.ctx().request_repaint();
            }
        }
        // Polls for the compiler and the watched file without user input.
        self.author.wakes().into_iter().for_each(|wait| ui.ctx().request_repaint_after(wait));
        let at_stake = self.dialogs.question.as_ref().filter(|asked| **asked == Question::Quit);
        let at_stake = at_stake.and_then(|_| self.at_stake(model));
        commands.extend(self.dialogs.show(ui, model, &self.paths[0], at_stake));
        for command in &commands {
            if let Command::Screenshot(path) = command {
                self.finals.own.insert(path.clone());
            }
        }
        self.finals.show(ui, model, status);
        let all = [complaint.as_ref(), model.notice(), status.message.as_ref(), self.finals.outcome()];
        let all: Vec<&Message> = all.into_iter().flatten().collect();
        messages::show(ui, &all);
        commands
    }

    fn controls(&mut self, ui: &mut Ui, model: &mut Model, status: &Status) -> Vec<Command> {
        self.selected = self.selected.take().filter(|name| model.scene().parts.contains_key(name));
        let (draft, commands) = (model.present(), Vec::new());
        let (before, shown) = (draft.clone(), BTreeMap::new());
        let (advanced, keys) = (self.advanced, self.keyframes.shown);
        let mut pass = Pass { draft, before, shown, refused: None, touch: None, commands, model, status, advanced, keys };
        ui.add_space(4.0);
        field_menu::take_pasted(ui, &mut pass);
        self.dialogs.offer(ui, &mut pass.commands);
        toolbar::history(ui, &mut pass, &mut self.author_is_open);
        ui.horizontal_wrapped(|ui| {
            let (is_open, doc) = (self.finals.is_open, "A picture, a sequence or a video, in any size.");
            self.finals.is_open ^= widgets::toggle(ui, is_open, "Final picture", "final", doc).clicked();
            self.finals.progress().map(|progress| ui.weak(progress));
        });
        ui.separator();
        ScrollArea::vertical().id_salt("controls").auto_shrink(false).show(ui, |ui| self.sections(ui, &mut pass));
        let Pass { draft, touch, refused, commands, keys, .. } = pass;
        self.keyframes.shown = keys;
        match touch {
            // A view is not an undo step.
            Some(what) if what == "camera" => drop(model.look(|camera| *camera = draft.camera)),
            Some(what) => drop(model.change(&what, draft)),
            None => {}
        }
        refused.into_iter().for_each(|line| model.say(line));
        let commands = commands.into_iter().filter_map(|command| self.perform(command, model)).collect();
        // A drag is one undo step, and two keys are two.
        if !ui.ctx().input(|input| input.pointer.any_down()) {
            model.end_undo_group();
        }
        commands
    }

    fn sections(&mut self, ui: &mut Ui, pass: &mut Pass<'_>) {
        ui.horizontal_wrapped(|ui| {
            for (advanced, text, name, doc) in [
                (false, "Basic", "view.basic", "Common settings."),
                (true, "Advanced", "view.advanced", "Every setting of a scene file."),
            ] {
                let response = ui.selectable_label(self.advanced == advanced, text).on_hover_text(doc);
                if widgets::named(ui, &response, name).clicked() {
                    self.advanced = advanced;
                }
            }
        });
        let advanced = pass.advanced;
        section(ui, "Presets", true, |ui| presets::show(ui, pass, &mut self.with_own));
        let recent = &self.dialogs.recent;
        section(ui, "File", false, |ui| toolbar::files(ui, pass, &mut self.paths, recent));
        section(ui, "Objects", false, |ui| object::list(ui, pass, &mut self.selected, &mut self.locked));
        let part = self.selected.clone();
        let part = part.as_deref();
        section(ui, "Object", false, |ui| object::show(ui, pass, part));
        self.iso_drag = false;
        if advanced {
            section(ui, "Contents", false, |ui| self.iso_drag = file_info::show(ui, pass, part, &mut self.known));
        }
        // Above the parameters, whose number changes with the modules, so that nothing moves under the pointer.
        if advanced {
            section(ui, "Effect", true, |ui| effect::show(ui, pass, part));
        }
        section(ui, "Parameters", true, |ui| parameters::show(ui, pass, part));
        section(ui, "Groom", false, |ui| groom::show(ui, pass, &mut self.painting));
        section(ui, "Transfer map", false, |ui| transfer::show(ui, pass, part, &mut self.stop));
        section(ui, "Material", false, |ui| settings::table(ui, pass, &prefix(part), "material"));
        section(ui, "Light and background", false, |ui| camera::light(ui, pass));
        section(ui, "Camera", false, |ui| camera::camera(ui, pass, &mut self.bookmarks));
        section(ui, "Accuracy", false, |ui| accuracy::show(ui, pass));
        section(ui, "Picture", false, |ui| settings::show(ui, pass, "", "image.size"));
        if advanced && !pass.status.made.is_empty() {
            section(ui, "Made with", false, |ui| status_bar::made(ui, &pass.status.made));
        }
        ui.horizontal_wrapped(|ui| {
            ui.weak("theme");
            self.theme.show(ui);
        });
    }

    /// Performs a command on the scene, the edited module or the dialogs; returns one for the window.
    pub(crate) fn perform(&mut self, command: Command, model: &mut Model) -> Option<Command> {
        match command {
            Command::Undo => drop(model.undo()),
            Command::Redo => drop(model.redo()),
            Command::Preset { name, on_object } => drop(match self.selected.as_deref().filter(|_| on_object) {
                Some(part) => model.take_preset_of_part(part, &name),
                None => model.take_preset(&name, on_object),
            }),
            Command::ChooseFile => self.dialogs.choose(),
            Command::Open(path) => self.open(&path, model),
            Command::Restore(folder) => {
                // Work that cannot be opened as a whole is offered again.
                if unsaved::restore(&folder, model, &mut self.author) {
                    self.restored = Some(folder);
                }
                self.author_is_open |= self.author.file().is_some();
            }
            Command::Save => self.dialogs.save(model, &self.paths[0]),
            Command::SaveTo(path) => self.dialogs.scene(path, model),
            Command::SaveAs => self.dialogs.save_as(model),
            Command::AddPart => self.selected = model.add_part("sphere").or(self.selected.take()),
            Command::RemovePart(name) => {
                self.locked.remove(&name);
                model.remove_part(&name);
            }
            Command::RenamePart { from, to } => {
                if model.rename_part(&from, &to) {
                    if self.locked.remove(&from) {
                        self.locked.insert(to.clone());
                    }
                    self.selected = Some(to);
                }
            }
            // Replacing a file takes a confirmation.
            Command::Screenshot(path) if self.finals.replaces(&path) => self.ask(Question::Picture(path)),
            other => return Some(other),
        }
        None
    }

    /// Opens a mesh, a scan or a scene file as the scene, or a module in the editor.
    fn open(&mut self, path: &Path, model: &mut Model) {
        if path.extension().is_none_or(|end| end != "glsl") {
            model.open(path);
            return;
        }
        match self.author.watch(model.library(), path) {
            Ok(()) => self.author_is_open = true,
            Err(reason) => model.say(reason),
        }
    }
}

fn section(ui: &mut Ui, title: &str, open: bool, add: impl FnOnce(&mut Ui)) {
    let header = CollapsingHeader::new(RichText::new(title).strong()).id_salt(title).default_open(open);
    let shown = header.show(ui, |ui| {
        add(ui);
        ui.add_space(4.0);
    });
    widgets::come_into_view(ui, &shown.header_response);
}
