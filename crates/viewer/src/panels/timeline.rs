//! The timeline below the picture.

use super::axis::{Axis, LEFT, frame, ticks};
use super::keyframes::Keyframes;
use super::status::Status;
use super::widgets::{button, named, short};
use crate::document::model::Model;
use crate::input::Command;
use crate::playback::Playback;
use egui::{Align, DragValue, Layout, Rect, Slider, SliderClamping, Ui, vec2};

/// Form of the timeline.
#[derive(Clone, Copy)]
pub(super) struct Form {
    /// Frames per second of the ticks.
    pub(super) fps: f64,
    /// Whether all is one row, without ticks.
    pub(super) is_row: bool,
}

/// Playback button, time, speed, repetition and range; the axis with its handle; below it the tracks.
pub(super) fn show(
    ui: &mut Ui,
    model: &mut Model,
    status: &Status,
    keyframes: &mut Keyframes,
    form: Form,
    commands: &mut Vec<Command>,
) {
    let (mut playback, mut time) = (status.playback, status.time.unwrap_or(model.scene().camera.time));
    ui.horizontal(|ui| {
        let (text, doc) = if status.paused { ("\u{23f5}", "Play (Space).") } else { ("\u{23f8}", "Pause (Space).") };
        if button(ui, text, "timeline play", doc).clicked() {
            commands.push(Command::Play);
        }
        if button(ui, "\u{23ee}", "timeline start", "Go to the beginning.").clicked() {
            commands.push(Command::Time(playback.range[0]));
        }
        let speed =
            DragValue::new(&mut playback.speed).range(0.01..=100.0).speed(0.01).prefix("\u{d7} ").max_decimals(2);
        let response = ui.add(speed);
        named(ui, &response, "timeline speed").on_hover_text("Seconds of the scene per second.");
        ends(ui, &mut playback);
        let is_edited = playback.range != status.playback.range;
        let repeats = ui.toggle_value(&mut playback.repeats, "loop");
        named(ui, &repeats, "timeline loop").on_hover_text("Repeat the range.");
        seamless(ui, model, playback.range, is_edited);
        keyframes.switch(ui, model, &mut playback);
        if form.is_row {
            slider(ui, &mut time, playback.range, commands);
        }
    });
    playback.range[1] = playback.range[1].max(playback.range[0] + 0.01);
    if playback != status.playback {
        commands.push(Command::Playback(playback));
    }
    if form.is_row {
        return;
    }
    let axis = ui.horizontal(|ui| {
        let is_narrow = ui.available_width() < 2.0 * LEFT;
        let left = if is_narrow { 90.0 } else { LEFT - ui.spacing().item_spacing.x };
        let height = ui.spacing().interact_size.y;
        ui.allocate_ui_with_layout(vec2(left, height), Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(left);
            let drag = DragValue::new(&mut time).speed(0.02).suffix(" s").custom_formatter(|time, _| short(time));
            let response = ui.add(drag);
            if named(ui, &response, "timeline time").on_hover_text("Time, seconds.").changed() {
                commands.push(Command::Time(time));
            }
            ui.weak(format!("frame {:.0}", frame(time, form.fps)));
        });
        let place = slider(ui, &mut time, playback.range, commands);
        // The handle of a slider stays within its ends.
        let aspect = match ui.visuals().handle_shape {
            egui::style::HandleShape::Circle => 1.0,
            egui::style::HandleShape::Rect { aspect_ratio } => aspect_ratio,
        };
        let span = place.x_range().shrink(aspect * place.height() / 2.5);
        Axis { left: span.min, width: span.span().max(1.0), range: playback.range, fps: form.fps }
    });
    let axis = axis.inner;
    ticks(ui, &axis);
    keyframes.show(ui, model, &axis, commands);
}

/// The handle of the time, over the rest of the row; returns its place.
fn slider(ui: &mut Ui, time: &mut f64, [from, to]: [f64; 2], commands: &mut Vec<Command>) -> Rect {
    ui.spacing_mut().slider_width = ui.available_width().max(60.0);
    let slider = Slider::new(time, from..=to).clamping(SliderClamping::Never).show_value(false);
    let response = ui.add(slider);
    if named(ui, &response, "timeline").on_hover_text("Time; drag it to scrub.").changed() {
        commands.push(Command::Time(*time));
    }
    response.rect
}

/// Start and end of the range.
fn ends(ui: &mut Ui, playback: &mut Playback) {
    let [from, to] = &mut playback.range;
    let end = |ui: &mut Ui, value: &mut f64, name: &str, doc: &str| {
        let drag = DragValue::new(value).speed(0.05).max_decimals(2).suffix(" s");
        let response = ui.add(drag);
        named(ui, &response, name).on_hover_text(doc);
    };
    end(ui, from, "timeline from", "Start of the timeline.");
    end(ui, to, "timeline to", "End of the timeline.");
}

/// The switch of the loop of the scene, whose length is that of the range; an edited range is another loop.
fn seamless(ui: &mut Ui, model: &mut Model, [from, to]: [f64; 2], is_edited: bool) {
    let period = model.scene().animation.period;
    let mut on = period.is_some();
    let doc = "All motion begins anew at the end of the range without a seam: keyframes, expressions and the drift of noise.\n\
               animation.loop";
    let response = ui.checkbox(&mut on, "seamless").on_hover_text(doc);
    let is_switched = named(ui, &response, "animation.has_loop").changed();
    if is_switched || (on && is_edited) {
        let length = (((to - from).max(0.01) * 1e3).round() / 1e3).max(0.01);
        model.edit("animation.loop", |scene| scene.animation.period = on.then_some(length));
    }
    if is_switched {
        model.end_undo_group();
    }
}
