//! The dialog for final pictures.

use super::print_fields;
use super::status::Status;
use super::widgets::{Field, button, field, fit, named, number, short, switch};
use crate::document::exports::{
    ExportOrder, Exports, GRID, Kind, Motion, Print, VIDEO_BACKGROUND, is_installed, longest_side,
};
use crate::document::model::Model;
use crate::input::Command;
use egui::{DragValue, Id, TextEdit, Ui, Window};
use hypertexture::scene::schema::Unit;
use std::path::PathBuf;
use std::sync::LazyLock;

/// Common sizes.
const SIZES: [[u32; 2]; 2] = [[1920, 1080], [3840, 2160]];
/// Initial error target: a quarter of a step of 8 bits in the mid tones.
const FIRST_ERROR: f64 = 1e-3;

/// Whether ffmpeg is installed.
static FFMPEG: LazyLock<bool> = LazyLock::new(|| is_installed("ffmpeg"));

/// State of the dialog.
pub(crate) struct ExportDialog {
    pub(crate) is_open: bool,
    kind: Kind,
    path: String,
    /// `None`: the size of the scene.
    size: Option<[u32; 2]>,
    /// `None`: the samples of the scene.
    samples: Option<u32>,
    supersampling: u32,
    max_error: Option<f64>,
    motion: Motion,
    grid: u32,
    print: Print,
    /// Longest side of a print, millimeters; `None`: that of the object.
    side: Option<f32>,
}

impl Default for ExportDialog {
    fn default() -> ExportDialog {
        ExportDialog {
            is_open: false,
            kind: Kind::Picture,
            path: "final.png".into(),
            size: None,
            samples: None,
            supersampling: 4,
            max_error: None,
            motion: Motion::default(),
            grid: GRID,
            print: Print::default(),
            side: None,
        }
    }
}

impl ExportDialog {
    /// Frames per second of sequences.
    pub(super) fn fps(&self) -> f64 {
        self.motion.fps
    }

    /// Whether a file for another program is written in place of pictures.
    fn is_export(&self) -> bool {
        matches!(self.kind, Kind::Mesh | Kind::Print | Kind::Volume | Kind::Page)
    }

    /// The order as described in the dialog.
    fn order(&self, model: &Model, status: &Status) -> ExportOrder {
        let mut scene = model.scene().clone();
        if !self.is_export() {
            scene.image.size = self.size.unwrap_or(scene.image.size);
            scene.quality.samples = self.samples.unwrap_or(scene.quality.samples);
            scene.quality.supersampling = self.supersampling;
        }
        if matches!(self.kind, Kind::Sequence | Kind::Video) && !scene.animation.is_empty() {
            scene.camera.time = status.playback.range[0];
        }
        if self.kind == Kind::Video {
            scene.image.background.get_or_insert(VIDEO_BACKGROUND);
        }
        if self.kind == Kind::Print {
            scene.object.scale_to = self.side.unwrap_or_else(|| longest_side(&scene.object));
        }
        let turntable = Some(self.motion.turns(!scene.animation.is_empty()));
        let motion = matches!(self.kind, Kind::Sequence | Kind::Video).then_some(Motion { turntable, ..self.motion });
        let path = PathBuf::from(self.path.trim());
        ExportOrder {
            kind: self.kind,
            motion,
            max_error: self.max_error.filter(|_| !self.is_export()),
            grid: self.grid,
            print: self.print,
            ..ExportOrder::picture(scene, model.library().clone(), path)
        }
    }

    /// Shows the dialog if it is open; returns a command for the window.
    pub(super) fn show(&mut self, ui: &Ui, exports: &mut Exports, model: &Model, status: &Status) -> Option<Command> {
        let mut is_open = self.is_open;
        let window = Window::new("Final picture").id(Id::new("final")).open(&mut is_open).collapsible(false);
        let form = |ui: &mut Ui| self.form(ui, exports, model, status);
        let shown = window.resizable(false).default_width(380.0).show(ui.ctx(), form);
        self.is_open &= is_open;
        shown?.inner?
    }

    fn form(&mut self, ui: &mut Ui, exports: &mut Exports, model: &Model, status: &Status) -> Option<Command> {
        fit(ui);
        self.kinds(ui, exports);
        if self.is_export() {
            match self.kind {
                Kind::Print => print_fields::show(ui, &mut self.print, &mut self.side, &model.scene().object),
                Kind::Page => {}
                _ => {
                    let grid = field("final.grid", "Samples along the longest side of the mesh or the volume.");
                    number(ui, &mut None, &grid, &mut self.grid, 8..=512);
                }
            }
            ui.separator();
            return self.buttons(ui, exports, self.order(model, status));
        }
        self.sizes(ui, model, status);
        self.accuracy(ui, model);
        if self.kind != Kind::Picture {
            let is_animated = !model.scene().animation.is_empty();
            let motion = &mut self.motion;
            // Whichever of frames and seconds was typed last stays while the frames per second change.
            let frames = field("final.frames", "Number of pictures.");
            let mut touch = None;
            number(ui, &mut touch, &frames, &mut motion.frames, 1..=1000);
            let mut seconds = f64::from(motion.frames) / motion.fps;
            let length = field("final.seconds", "Length of the motion, seconds.");
            let length = Field { unit: Unit::Seconds.symbol(), ..length };
            number(ui, &mut touch, &length, &mut seconds, 0.1..=60.0);
            match touch.as_deref() {
                Some("final.seconds") => {
                    motion.frames = ((seconds * motion.fps).round() as u32).max(1);
                    motion.seconds = Some(seconds);
                }
                Some(_) => motion.seconds = None,
                None => {}
            }
            let mut rate = None;
            number(ui, &mut rate, &field("final.fps", "Pictures per second."), &mut motion.fps, 1.0..=60.0);
            if let (Some(_), Some(seconds)) = (rate, motion.seconds) {
                motion.frames = ((seconds * motion.fps).round() as u32).max(1);
            }
            let length = f64::from(motion.frames) / motion.fps;
            let plural = if motion.frames == 1 { "frame" } else { "frames" };
            ui.weak(format!("{} {plural} = {} s", motion.frames, short(length)));
            let around = field(
                "final.turntable",
                "The camera goes once around the object. Off by default where anything is animated.",
            );
            let (mut turns, mut touch) = (motion.turns(is_animated), None);
            switch(ui, &mut touch, &around, &mut turns);
            if touch.is_some() {
                motion.turntable = Some(turns);
            }
            if let (true, Some(field)) = (turns, model.scene().keyed_turn()) {
                let line =
                    format!("{} is keyed: its motion replaces the turntable", field.trim_start_matches("camera."));
                ui.colored_label(ui.visuals().warn_fg_color, line);
            }
            let again = field("final.restart", "Render finished frames again; otherwise a stopped sequence continues.");
            switch(ui, &mut None, &again, &mut motion.restart);
        }
        let order = self.order(model, status);
        let has_background = order.scene.image.background.is_some();
        ui.weak(if has_background { "with its background" } else { "with a transparent background" });
        ui.separator();
        self.buttons(ui, exports, order)
    }

    /// Kind and path of the output.
    fn kinds(&mut self, ui: &mut Ui, exports: &mut Exports) {
        ui.horizontal_wrapped(|ui| {
            for (kind, text, name, end) in [
                (Kind::Picture, "Picture", "final.picture", "final.png"),
                (Kind::Sequence, "Sequence", "final.sequence", "final_####.png"),
                (Kind::Video, "Video", "final.video", "final.mp4"),
                (Kind::Mesh, "Mesh", "final.mesh", "final.ply"),
                (Kind::Print, "Print", "final.print", "final.3mf"),
                (Kind::Volume, "Volume", "final.volume", "final.vdb"),
                (Kind::Page, "Web page", "final.page", "final.html"),
            ] {
                let is_there = kind != Kind::Video || *FFMPEG;
                let chosen = ui.add_enabled(is_there, egui::Button::selectable(self.kind == kind, text));
                let chosen = chosen.on_disabled_hover_text("A video needs ffmpeg, which is not installed.");
                if named(ui, &chosen, name).clicked() {
                    (self.kind, self.path) = (kind, end.into());
                    exports.forget_written();
                }
            }
            if !*FFMPEG {
                ui.weak("video: install ffmpeg");
            }
        });
        let response = ui.add(TextEdit::singleline(&mut self.path).desired_width(f32::INFINITY));
        let doc = "Path: .png or .exr, #### is the number of a frame; a sequence may be a .webp, .gif or .apng. A mesh \
                   or a print is a .3mf, .stl, .ply, .obj or .glb, a volume a .vdb, .nrrd or .npy. A page is a \
                   .html, or a folder.";
        named(ui, &response, "final.file").on_hover_text(doc);
    }

    /// Width and height.
    fn sizes(&mut self, ui: &mut Ui, model: &Model, status: &Status) {
        let scene = model.scene().image.size;
        ui.horizontal_wrapped(|ui| {
            let mut size = self.size.unwrap_or(scene);
            for (side, name) in size.iter_mut().zip(["final.size.x", "final.size.y"]) {
                let response = ui.add(DragValue::new(side).range(1..=16384).speed(4.0).suffix(" px"));
                named(ui, &response, name).on_hover_text("Width and height in pixels.");
            }
            let mut offer = |text: String, name: String, wanted: [u32; 2]| {
                if button(ui, &text, &name, "").clicked() {
                    size = wanted;
                }
            };
            offer("scene".into(), "final.size.scene".into(), scene);
            if status.window[0] > 0 {
                offer("window".into(), "final.size.window".into(), status.window);
            }
            for wanted in SIZES {
                let text = format!("{} x {}", wanted[0], wanted[1]);
                offer(text.clone(), format!("final.size {text}"), wanted);
            }
            self.size = (size != scene).then_some(size);
        });
    }

    /// Samples, or an error target.
    fn accuracy(&mut self, ui: &mut Ui, model: &Model) {
        let target = Field {
            text: Some("Error target"),
            ..field("final.max_error.on", "Render with the fastest settings within an error.")
        };
        let mut on = self.max_error.is_some();
        switch(ui, &mut None, &target, &mut on);
        self.max_error = on.then(|| self.max_error.unwrap_or(FIRST_ERROR));
        if let Some(error) = &mut self.max_error {
            let row = field("final.max_error", "Root mean square, linear light.");
            return number(ui, &mut None, &Field { text: Some(""), ..row }, error, 1e-4..=0.1);
        }
        let own = model.scene().quality.samples;
        let mut samples = self.samples.unwrap_or(own);
        number(ui, &mut None, &field("final.samples", "Samples of a ray, or slices."), &mut samples, 1..=4096);
        self.samples = (samples != own).then_some(samples);
        let smooth = field("final.supersampling", "Number of averaged pictures: smooth edges, less noise.");
        number(ui, &mut None, &smooth, &mut self.supersampling, 1..=64);
    }

    /// The progress of an order, or the button that gives it, with facts about what was written.
    fn buttons(&self, ui: &mut Ui, exports: &mut Exports, order: ExportOrder) -> Option<Command> {
        let first = order.first();
        if let Some(progress) = exports.progress() {
            ui.horizontal(|ui| {
                match exports.part() {
                    Some(part) => drop(ui.add(egui::ProgressBar::new(part).desired_width(60.0))),
                    None => drop(ui.spinner()),
                }
                ui.label(progress);
                if button(ui, "Stop", "final.stop", "Stop; finished frames stay.").clicked() {
                    exports.stop();
                }
            });
            return None;
        }
        let text = if exports.replaces(&first) {
            ui.colored_label(ui.visuals().warn_fg_color, format!("{} exists", first.display()));
            "Replace it"
        } else if self.is_export() {
            "Write"
        } else {
            "Render"
        };
        if button(ui, text, "final.render", "Write it in the background.").clicked() {
            exports.add(order);
        }
        exports.written().and_then(|written| print_fields::written(ui, written))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::scene::preset;
    use hypertexture::shader::shipped;

    #[test]
    fn a_print_is_ordered_in_millimeters() {
        let model = Model::new(preset("lit").unwrap(), shipped()).unwrap();
        let ordered = |dialog: ExportDialog| {
            let order = dialog.order(&model, &Status::default());
            (order.scene.object.scale_to, order.command()[2..].join(" "))
        };
        let dialog = || ExportDialog { kind: Kind::Print, path: "a.3mf".into(), ..ExportDialog::default() };
        assert_eq!(ordered(dialog()), (60.0, "mesh scene --output a.3mf --tolerance 0.1mm".into()));
        let print = Print { tolerance: 0.25, apart: true, ..Print::default() };
        let words = "mesh scene --output a.3mf --tolerance 0.25mm --bodies apart";
        assert_eq!(ordered(ExportDialog { side: Some(20.0), print, ..dialog() }), (20.0, words.into()));
    }
}
