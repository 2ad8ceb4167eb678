//! Messages over the picture.

use crate::message::Message;
use egui::{Align2, Area, Frame, Id, Label, Order, RichText, Ui, Vec2};
use std::time::Duration;

/// Maximal width of a message, points.
const WIDTH: f32 = 620.0;

/// Shows the messages over the lower end of the picture.
pub(super) fn show(ui: &Ui, messages: &[&Message]) {
    let held: Vec<(&Message, Duration)> =
        messages.iter().filter_map(|message| Some((*message, message.remaining()?))).collect();
    let Some(next) = held.iter().map(|(_, left)| *left).min() else { return };
    if next < Duration::MAX {
        ui.ctx().request_repaint_after(next);
    }
    let place = ui.available_rect_before_wrap();
    let area = Area::new(Id::new("messages")).order(Order::Foreground).interactable(false);
    area.fixed_pos(place.center_bottom() - Vec2::new(0.0, 10.0)).pivot(Align2::CENTER_BOTTOM).show(ui.ctx(), |ui| {
        Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_max_width((place.width() - 40.0).clamp(80.0, WIDTH));
            for (message, _) in held {
                let visuals = ui.visuals();
                let color = if message.is_error { visuals.error_fg_color } else { visuals.strong_text_color() };
                ui.add(Label::new(RichText::new(&message.text).color(color)).wrap());
            }
        });
    });
}
