//! The panels around the picture, and the order of their sections.

use super::context::{Pass, prefix};
use super::dialogs::{self, Question};
use super::status::Status;
use super::{
    accuracy, bookmarks, camera, editor, effect, export_dialog, field_menu, file_info, groom, keyframes, menu,
    messages, object, parameters, presets, settings, status_bar, theme, timeline, toolbar, transfer, widgets,
};
use crate::document::model::Model;
use crate::document::painting::Painting;
use crate::document::{Document, Selection};
use crate::input::Command;
use crate::message::Message;
use egui::{CollapsingHeader, Id, Panel, PanelState, RichText, ScrollArea, Ui};
use hypertexture::scene::Scene;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

/// Interval between looks at a running final picture.
const EXPORT_POLL: Duration = Duration::from_millis(300);
/// Default width of the panel with the settings, points.
const WIDTH: f32 = 376.0;
/// Minimal and maximal width of the panel, and its maximal fraction of the window.
const MIN_WIDTH: f32 = 184.0;
const MAX_WIDTH: f32 = 640.0;
const MAX_SHARE: f32 = 0.36;
/// Default height of the timeline with its tracks, points.
const TRACKS_HEIGHT: f32 = 178.0;
/// Height of the window below which the menus are in the panel, and the timeline is one row, points.
const LOW_HEIGHT: f32 = 480.0;

/// State of the panels.
pub struct Panels {
    transfer: transfer::TransferControls,
    known: file_info::FileInfo,
    /// Whether an iso-value of the selected object is being dragged.
    pub(crate) iso_drag: bool,
    dialogs: dialogs::Dialogs,
    bookmarks: bookmarks::Bookmarks,
    /// Paths of the scene file and of the picture.
    paths: [String; 2],
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
    max_width: f32,
    theme: theme::Chosen,
    keyframes: keyframes::Keyframes,
    pub(crate) export: export_dialog::ExportDialog,
}

impl Default for Panels {
    fn default() -> Panels {
        Panels {
            transfer: transfer::TransferControls::default(),
            known: file_info::FileInfo::default(),
            iso_drag: false,
            dialogs: dialogs::Dialogs::default(),
            bookmarks: bookmarks::Bookmarks::default(),
            paths: [String::new(), "picture.png".into()],
            editor: editor::Editor::default(),
            author_is_open: false,
            author_was_open: false,
            advanced: false,
            with_own: false,
            hidden: false,
            width: WIDTH,
            max_width: 0.0,
            theme: theme::Chosen::default(),
            keyframes: keyframes::Keyframes::default(),
            export: export_dialog::ExportDialog::default(),
        }
    }
}

impl Panels {
    /// Offers unsaved work of earlier windows, and reads recent files, bookmarks and theme from a folder of the
    /// cache.
    pub fn remember(&mut self, kept: Vec<PathBuf>, folder: Option<PathBuf>) {
        self.bookmarks = bookmarks::Bookmarks::of(folder.as_deref());
        self.theme.remember(folder.as_deref());
        self.dialogs.remember(kept, folder);
    }

    /// Asks a question.
    pub fn ask(&mut self, question: Question) {
        self.dialogs.question = Some(question);
    }

    /// Whether a question or the file dialog is open, which own all keys.
    pub fn is_asking(&self) -> bool {
        self.dialogs.is_open()
    }

    /// Removes the selected keyframe of the tracks, if they are shown; returns whether there was one.
    pub(crate) fn remove_key(&mut self, model: &mut Model) -> bool {
        !self.hidden && self.keyframes.remove_selected(model)
    }

    /// Shows the panels; the remaining area of `ui` is for the picture. Returns the commands for the window. Called
    /// once per frame.
    pub fn show(&mut self, ui: &mut Ui, document: &mut Document, status: &Status) -> Vec<Command> {
        self.theme.apply(ui.ctx());
        ui.spacing_mut().item_spacing.y = 5.0;
        let is_editing = self.author_is_open && !self.hidden;
        let complaint = document.author.complaint().filter(|_| !is_editing).map(Message::error);
        Panel::bottom("status").show(ui, |ui| status_bar::show(ui, status));
        let mut commands = if self.hidden { Vec::new() } else { self.bars(ui, document, status) };
        self.editor(ui, document);
        // Polls for the compiler and the watched file without user input.
        document.author.wakes().into_iter().for_each(|wait| ui.ctx().request_repaint_after(wait));
        let is_quitting = self.dialogs.question == Some(Question::Quit);
        let at_stake = if is_quitting { document.at_stake() } else { None };
        commands.extend(self.dialogs.show(ui, &mut document.model, &self.paths[0], at_stake));
        for command in &commands {
            if let Command::Screenshot(path) = command {
                document.exports.note_own(path.clone());
            }
        }
        document.exports.poll();
        if document.exports.is_running() {
            ui.ctx().request_repaint_after(EXPORT_POLL);
        }
        commands.extend(self.export.show(ui, &mut document.exports, &document.model, status));
        let outcome = document.exports.outcome();
        let all = [complaint.as_ref(), document.model.notice(), status.message.as_ref(), outcome];
        let all: Vec<&Message> = all.into_iter().flatten().collect();
        messages::show(ui, &all);
        commands
    }

    /// Shows the menus, the timeline and the panel with the settings.
    fn bars(&mut self, ui: &mut Ui, document: &mut Document, status: &Status) -> Vec<Command> {
        let mut commands = Vec::new();
        let is_low = ui.available_height() < LOW_HEIGHT;
        if !is_low {
            let recent = &self.dialogs.recent;
            let bar = |ui: &mut Ui| menu::show(ui, recent, &status.states, &document.model, &mut commands);
            Panel::top("menu").show(ui, bar);
        }
        let time = if self.keyframes.shown {
            // A fixed height with a handle.
            Panel::bottom("tracks").resizable(true).default_size(TRACKS_HEIGHT).size_range(96.0..=480.0)
        } else {
            Panel::bottom("time")
        };
        let form = timeline::Form { fps: self.export.fps(), is_row: is_low && !self.keyframes.shown };
        let (model, keyframes) = (&mut document.model, &mut self.keyframes);
        time.show(ui, |ui| timeline::show(ui, model, status, keyframes, form, &mut commands));
        // In a small window, most of the area is for the picture.
        let max_width = (MAX_SHARE * ui.available_width()).clamp(MIN_WIDTH, MAX_WIDTH);
        if std::mem::replace(&mut self.max_width, max_width) != max_width {
            // A wider window restores the chosen width.
            ui.data_mut(|data| data.remove::<PanelState>(Id::new("scene")));
        }
        let panel = Panel::right("scene").default_size(self.width.min(max_width)).size_range(MIN_WIDTH..=max_width);
        let shown = panel.show(ui, |ui| {
            widgets::fit(ui);
            let mut chosen = Vec::new();
            if is_low {
                // The menus of a low window take no height from the picture.
                menu::show(ui, &self.dialogs.recent, &status.states, &document.model, &mut chosen);
            }
            let mut commands = self.controls(ui, document, status);
            commands.extend(chosen);
            ui.take_available_width();
            commands
        });
        commands.extend(shown.inner);
        let width = shown.response.rect.width();
        self.width = if width < max_width { width } else { self.width };
        commands
    }

    /// Shows the editor if it is open, and polls the check of its text.
    fn editor(&mut self, ui: &mut Ui, document: &mut Document) {
        let Document { author, model, .. } = document;
        if !self.author_is_open || self.hidden {
            self.author_was_open = false;
            if author.poll(model) {
                ui.ctx().request_repaint();
            }
            return;
        }
        let panel = Panel::left("author").default_size(520.0).size_range(280.0..=1200.0).show(ui, |ui| {
            ui.add_space(4.0);
            editor::show(ui, author, model, &mut self.editor);
        });
        editor::keep_focus(ui, panel.response.rect);
        if !std::mem::replace(&mut self.author_was_open, true) {
            editor::focus(ui);
        }
    }

    fn controls(&mut self, ui: &mut Ui, document: &mut Document, status: &Status) -> Vec<Command> {
        let Document { model, selection, painting, exports, .. } = document;
        selection.follow(model.scene());
        let before = model.present();
        let (draft, shown, commands) = (Scene::clone(&before), BTreeMap::new(), Vec::new());
        let (advanced, keys) = (self.advanced, self.keyframes.shown);
        let mut pass =
            Pass { draft, before, shown, refused: None, touch: None, commands, model, status, advanced, keys };
        ui.add_space(4.0);
        field_menu::take_pasted(ui, &mut pass);
        self.dialogs.offer(ui, &mut pass.commands);
        toolbar::history(ui, &mut pass, &mut self.author_is_open);
        ui.horizontal_wrapped(|ui| {
            let (is_open, doc) = (self.export.is_open, "A picture, a sequence or a video, in any size.");
            self.export.is_open ^= widgets::toggle(ui, is_open, "Final picture", "final", doc).clicked();
            exports.progress().map(|progress| ui.weak(progress));
        });
        ui.separator();
        let sections = |ui: &mut Ui| self.sections(ui, &mut pass, selection, painting);
        ScrollArea::vertical().id_salt("controls").auto_shrink(false).show(ui, sections);
        let Pass { draft, touch, refused, commands, keys, .. } = pass;
        self.keyframes.shown = keys;
        match touch {
            // A view is not an undo step.
            Some(what) if what == "camera" => drop(model.look(|camera| *camera = draft.camera)),
            Some(what) => drop(model.change(&what, draft)),
            None => {}
        }
        refused.into_iter().for_each(|line| model.say(line));
        let commands = commands.into_iter().filter_map(|command| self.perform(command, document)).collect();
        // A drag is one undo step, and two keys are two.
        if !ui.ctx().input(|input| input.pointer.any_down()) {
            document.model.end_undo_group();
        }
        commands
    }

    fn sections(&mut self, ui: &mut Ui, pass: &mut Pass<'_>, selection: &mut Selection, painting: &mut Painting) {
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
        section(ui, "Objects", false, |ui| object::list(ui, pass, selection));
        let part = selection.part();
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
        section(ui, "Groom", false, |ui| groom::show(ui, pass, painting));
        section(ui, "Transfer map", false, |ui| transfer::show(ui, pass, part, &mut self.transfer));
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

    /// Performs a command on the dialogs or the document; returns one for the window.
    pub fn perform(&mut self, command: Command, document: &mut Document) -> Option<Command> {
        let model = &mut document.model;
        match command {
            Command::ChooseFile => self.dialogs.choose(),
            Command::Save => self.dialogs.save(model, &self.paths[0]),
            Command::SaveTo(path) => self.dialogs.scene(path, model),
            Command::SaveAs => self.dialogs.save_as(model),
            // Replacing a file takes a confirmation.
            Command::Screenshot(path) if document.exports.replaces(&path) => self.ask(Question::Picture(path)),
            Command::Open(path) => self.author_is_open |= document.open(&path),
            Command::Restore(_) => {
                document.perform(command);
                self.author_is_open |= document.author.file().is_some();
            }
            other => return document.perform(other),
        }
        None
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
