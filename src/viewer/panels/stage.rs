//! Light, background and the camera.

use super::widgets::button;
use super::{Pass, Request, settings};
use egui::Ui;

/// The light, its shadows, and what is behind.
pub(super) fn light(ui: &mut Ui, pass: &mut Pass<'_>) {
    settings::table(ui, pass, "", "light");
    settings::show(ui, pass, "", "image.background");
}

/// The camera, and the moment.
pub(super) fn camera(ui: &mut Ui, pass: &mut Pass<'_>) {
    if button(ui, "reset view", "camera.reset", "Look at the object as its preset does.").clicked() {
        pass.requests.push(Request::ResetCamera);
    }
    settings::table(ui, pass, "", "camera");
}
