//! The timeline below the picture.

use super::keyframes::Keyframes;
use super::request::Request;
use super::status::Status;
use super::widgets::{button, named};
use crate::model::Model;
use egui::{DragValue, Slider, SliderClamping, Ui};

/// Width of the controls right of the slider, points.
const RIGHT: f32 = 330.0;

/// Playback button, time slider, speed, repetition and range; below them the tracks.
pub(super) fn show(
    ui: &mut Ui,
    model: &mut Model,
    status: &Status,
    keyframes: &mut Keyframes,
    requests: &mut Vec<Request>,
) {
    let (mut playback, mut time) = (status.playback, status.time.unwrap_or(model.scene().camera.time));
    ui.horizontal(|ui| {
        let (text, doc) = if status.paused { ("⏵", "Play (Space).") } else { ("⏸", "Pause (Space).") };
        if button(ui, text, "timeline play", doc).clicked() {
            requests.push(Request::Pause(!status.paused));
        }
        if button(ui, "⏮", "timeline start", "Go to the beginning.").clicked() {
            requests.push(Request::Time(playback.range[0]));
        }
        let [from, to] = playback.range;
        ui.spacing_mut().slider_width = (ui.available_width() - RIGHT).max(60.0);
        let slider = Slider::new(&mut time, from..=to).clamping(SliderClamping::Never).fixed_decimals(2).suffix(" s");
        let response = ui.add(slider);
        if named(ui, &response, "timeline").on_hover_text("Time, seconds; drag it to scrub.").changed() {
            requests.push(Request::Time(time));
        }
        let speed = DragValue::new(&mut playback.speed).range(0.01..=100.0).speed(0.01).prefix("× ").max_decimals(2);
        let response = ui.add(speed);
        named(ui, &response, "timeline speed").on_hover_text("Seconds of the scene per second.");
        let repeats = ui.toggle_value(&mut playback.repeats, "loop");
        named(ui, &repeats, "timeline loop").on_hover_text("Repeat the range.");
        let [from, to] = &mut playback.range;
        let end = |ui: &mut Ui, value: &mut f64, name: &str, doc: &str| {
            let drag = DragValue::new(value).speed(0.05).max_decimals(2).suffix(" s");
            let response = ui.add(drag);
            named(ui, &response, name).on_hover_text(doc);
        };
        end(ui, from, "timeline from", "Start of the timeline.");
        end(ui, to, "timeline to", "End of the timeline.");
        keyframes.switch(ui, model, &mut playback);
    });
    playback.range[1] = playback.range[1].max(playback.range[0] + 0.01);
    if playback != status.playback {
        requests.push(Request::Playback(playback));
    }
    keyframes.show(ui, model, playback.range, requests);
}
