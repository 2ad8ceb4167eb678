//! Light, background and the camera.

use super::bookmarks::{Bookmarks, looking};
use super::widgets::{button, named};
use super::{Pass, Request, settings};
use egui::{Button, Ui};

/// Sides to look at the object from: name, azimuth and elevation in degrees.
pub(in crate::viewer) const SIDES: [(&str, f32, f32); 6] = [
    ("front", 0.0, 0.0),
    ("right", 90.0, 0.0),
    ("top", 0.0, 90.0),
    ("back", 180.0, 0.0),
    ("left", -90.0, 0.0),
    ("bottom", 0.0, -90.0),
];

/// The light, its shadows, and what is behind.
pub(super) fn light(ui: &mut Ui, pass: &mut Pass<'_>) {
    settings::table(ui, pass, "", "light");
    settings::show(ui, pass, "", "image.background");
}

/// The camera, and the moment.
pub(super) fn camera(ui: &mut Ui, pass: &mut Pass<'_>, bookmarks: &mut Bookmarks) {
    ui.horizontal_wrapped(|ui| {
        for (name, azimuth, elevation) in SIDES {
            let doc = format!("Look at the object from this side: azimuth {azimuth}, elevation {elevation}.");
            if button(ui, name, &format!("camera.{name}"), &doc).clicked() {
                let camera = &mut pass.draft.camera;
                (camera.azimuth, camera.elevation, camera.rotation) = (azimuth, elevation, None);
                pass.touch = Some("camera".into());
            }
        }
    });
    ui.horizontal_wrapped(|ui| {
        if button(ui, "reset view", "camera.reset", "Look at the object as its preset does.").clicked() {
            pass.requests.push(Request::ResetCamera);
        }
        let mut level = pass.status.level;
        let response = ui.checkbox(&mut level, "level orbit");
        let doc = "A drag orbits about the vertical axis, which stays upright; otherwise like a trackball (O).";
        if named(ui, &response, "camera.level").on_hover_text(doc).changed() {
            pass.requests.push(Request::Level(level));
        }
        if button(ui, "bookmark", "camera.bookmark", "Keep this view; the next window has it too.").clicked() {
            bookmarks.add(&pass.draft.camera);
        }
    });
    views(ui, pass, bookmarks);
    settings::table(ui, pass, "", "camera");
}

/// The views that were kept.
fn views(ui: &mut Ui, pass: &mut Pass<'_>, bookmarks: &mut Bookmarks) {
    let mut removed = None;
    ui.horizontal_wrapped(|ui| {
        for (index, view) in bookmarks.views.iter().enumerate() {
            let name = format!("view {}", index + 1);
            let [azimuth, elevation] = crate::viewer::trackball::level_angles(view);
            let doc = format!("Azimuth {azimuth:.0}, elevation {elevation:.0}, zoom {:.2}.", view.zoom);
            if button(ui, &name, &name, &doc).clicked() {
                pass.draft.camera = looking(&pass.draft.camera, view);
                pass.touch = Some("camera".into());
            }
            let response = ui.add(Button::new("✖").small()).on_hover_text("Forget this view.");
            if named(ui, &response, &format!("forget {name}")).clicked() {
                removed = Some(index);
            }
        }
    });
    removed.into_iter().for_each(|index| bookmarks.remove(index));
}
