//! Light, background and camera.

use super::bookmarks::{Bookmarks, looking};
use super::context::Pass;
use super::settings;
use super::widgets::{button, named};
use crate::input::Command;
use crate::input::trackball::level_angles;
use egui::{Button, Ui};
use hypertexture::scene::{Camera, Ease, Key, Scene};
use toml::Value;

/// Standard views: name, azimuth and elevation in degrees.
pub(crate) const SIDES: [(&str, f32, f32); 6] = [
    ("front", 0.0, 0.0),
    ("right", 90.0, 0.0),
    ("top", 0.0, 90.0),
    ("back", 180.0, 0.0),
    ("left", -90.0, 0.0),
    ("bottom", 0.0, -90.0),
];

/// The light, its shadows, and the background.
pub(super) fn light(ui: &mut Ui, pass: &mut Pass<'_>) {
    settings::table(ui, pass, "", "light");
    settings::show(ui, pass, "", "image.background");
}

/// The camera and the time. Azimuth and elevation also follow a rotation by hand; setting one of them removes the
/// roll.
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
        if button(ui, "Reset view", "camera.reset", "Reset the camera to that of the preset (R).").clicked() {
            pass.commands.push(Command::ResetCamera);
        }
        let mut level = pass.status.level;
        let response = ui.checkbox(&mut level, "level orbit");
        let doc = "A drag orbits about the vertical axis, which stays upright; otherwise like a trackball (O).";
        if named(ui, &response, "camera.level").on_hover_text(doc).changed() {
            pass.commands.push(Command::LevelOrbit);
        }
        if button(ui, "bookmark", "camera.bookmark", "Bookmark this view for this and later sessions.").clicked() {
            bookmarks.add(&pass.draft.camera);
        }
    });
    views(ui, pass, bookmarks);
    let angles = pass.draft.camera.rotation.map(|_| angles(&pass.draft.camera));
    for (name, angle) in ["camera.azimuth", "camera.elevation"].into_iter().zip(angles.into_iter().flatten()) {
        pass.shown.insert(name.into(), Value::Float(angle.into()));
    }
    let touched = pass.touch.take();
    settings::table(ui, pass, "", "camera");
    let camera = &mut pass.draft.camera;
    if let Some([azimuth, elevation]) = angles {
        match pass.touch.as_deref() {
            Some("camera.azimuth") => (camera.elevation, camera.rotation) = (elevation, None),
            Some("camera.elevation") => (camera.azimuth, camera.rotation) = (azimuth, None),
            _ => {}
        }
    }
    pass.touch = pass.touch.take().or(touched);
}

/// Azimuth and elevation of any camera, to a tenth of a degree.
fn angles(camera: &Camera) -> [f32; 2] {
    level_angles(camera).map(|angle| (10.0 * angle).round() / 10.0)
}

/// The bookmarks.
fn views(ui: &mut Ui, pass: &mut Pass<'_>, bookmarks: &mut Bookmarks) {
    let mut removed = None;
    ui.horizontal_wrapped(|ui| {
        for (index, view) in bookmarks.views.iter().enumerate() {
            let name = format!("view {}", index + 1);
            let [azimuth, elevation] = level_angles(view);
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
    if bookmarks.views.len() > 1 {
        let doc = "Let the camera go from view to view over the range of the timeline: keyframes.";
        if button(ui, "path through the views", "camera.path", doc).clicked() {
            path(&mut pass.draft, &bookmarks.views, pass.status.playback.range);
            pass.touch = Some("path of the camera".into());
        }
    }
    removed.into_iter().for_each(|index| bookmarks.remove(index));
}

/// Sets keyframes of the camera that go through views, over a range of time, or around the loop.
fn path(scene: &mut Scene, views: &[Camera], [from, to]: [f64; 2]) {
    scene.animation.tracks.retain(|field, _| !field.starts_with("camera."));
    let spans = views.len() as f64 - if scene.animation.period.is_some() { 0.0 } else { 1.0 };
    let [from, to] = scene.animation.period.map_or([from, to], |period| [0.0, period]);
    let mut last = views[0].turn();
    for (index, view) in views.iter().enumerate() {
        let turn = view.turn();
        last = if turn.dot(last) < 0.0 { -turn } else { turn }; // the shorter way
        let time = from + (to - from) * index as f64 / spans;
        let floats = |values: &[f32]| Value::from(values.iter().map(|value| f64::from(*value)).collect::<Vec<_>>());
        for (field, value) in [
            ("camera.rotation", floats(&last.to_array())),
            ("camera.pan", floats(&view.pan)),
            ("camera.zoom", Value::from(f64::from(view.zoom))),
            ("camera.field_of_view", Value::from(f64::from(view.field_of_view))),
        ] {
            scene.animation.set_key(field, Key { time, value, ease: Ease::Smooth });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angles_of_a_turn_are_those_that_it_was_made_of() {
        for [azimuth, elevation] in [[0.0, 0.0], [30.0, 12.0], [-120.0, -45.0], [179.0, 80.0]] {
            let by_angles = Camera { azimuth, elevation, rotation: None, ..Camera::default() };
            let turn = by_angles.turn();
            let by_turn = Camera { rotation: Some(turn.to_array()), ..Camera::default() };
            assert_eq!(angles(&by_turn), [azimuth, elevation]);
            // Roll about the axis of view changes neither.
            let rolled = glam::Quat::from_rotation_z(0.7) * turn;
            assert_eq!(angles(&Camera { rotation: Some(rolled.to_array()), ..by_turn }), [azimuth, elevation]);
        }
    }
}
