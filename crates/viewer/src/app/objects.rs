//! Additional objects under the mouse: selection by a click, and placement by drags.

use super::gizmo::{own_turn, with_turn};
use super::state::{App, Gizmo};
use crate::background::Background;
use crate::worker::LoadedScene;
use egui::{PointerButton, Pos2, Response, Ui, Vec2};
use glam::{Quat, Vec3};
use hypertexture::render::object_along;
use hypertexture::scene::Transform;
use std::task::Poll;

/// Points on the ray of a click. Lower: thin objects are missed.
const PLACES: usize = 256;

impl App {
    /// Starts the search for the object at a position.
    pub(super) fn select_clicked(&mut self, at: Option<Pos2>) {
        let pixel = at.and_then(|at| self.pixel_at(at));
        let variant = self.jobs.submitted.as_ref().map(|job| job.variants[0].clone());
        if let (Some(pixel), Some(variant), false) = (pixel, variant, self.document.model.scene().parts.is_empty()) {
            let LoadedScene { scene, library, subject } = variant;
            self.objects.clicked = Some(Background::start(&self.notify, move |task| {
                let found = object_along(&library, &*scene, &subject, pixel, PLACES);
                task.send(found.map_err(|error| log::info!("object of a click: {error}")).ok().flatten());
            }));
        }
    }

    /// Selects the object that was found.
    pub(super) fn receive_selection(&mut self) {
        if let Some(Poll::Ready(found)) = self.objects.clicked.as_ref().map(Background::poll) {
            self.objects.clicked = None;
            match found.flatten() {
                Some(name) if self.document.selection.is_locked(&name) => {
                    self.note(format!("{name} is locked, see Objects"))
                }
                Some(name) => {
                    self.note(format!("selected: {name}"));
                    self.document.selection.select(Some(name));
                }
                None => {}
            }
        }
    }

    /// Starts or ends the placement of the selected object.
    pub(super) fn toggle_placement(&mut self) {
        self.objects.places ^= true;
        if !self.objects.places {
            self.objects.gizmo = Gizmo::default();
            return self.note("placing ended");
        }
        match self.document.selection.part() {
            Some(part) if self.document.selection.is_locked(part) => {
                self.objects.places = false;
                self.note(format!("{part} is locked: unlock it in Objects first"));
            }
            Some(part) => self.note(format!(
                "placing {part}: drag moves, on an axis along it, with Shift about it; right drag turns, the wheel sizes"
            )),
            None => self.note("placing the light: drag moves it around the object, the wheel its distance"),
        }
    }

    /// Places the selected object or the light; whether the mouse belongs to it.
    pub(super) fn place(&mut self, ui: &Ui, response: &Response) -> bool {
        if !self.objects.places {
            return false;
        }
        let wheel = if response.hovered() { ui.input(|input| input.smooth_scroll_delta().y) } else { 0.0 };
        let Some(part) = self.document.selection.part().map(String::from) else {
            return self.place_light(response, wheel);
        };
        if self.document.selection.is_locked(&part) {
            return false;
        }
        if self.place_on_axis(ui, response, &part) {
            return true;
        }
        let (delta, turns) = (response.drag_delta(), response.dragged_by(PointerButton::Secondary));
        if let Some(half) = self.half_height().filter(|_| delta != Vec2::ZERO || wheel != 0.0) {
            let unit = half / (0.5 * self.place.height().max(1.0));
            let view = self.document.model.present().camera.turn();
            self.document.model.edit("transform", |scene| {
                if let Some(part) = scene.parts.get_mut(&part) {
                    part.transform = placed(part.transform, view, delta * unit, turns, (wheel / 400.0).exp());
                }
            });
        }
        if response.drag_stopped() {
            self.document.model.end_undo_group();
        }
        true
    }
}

/// A placement after a drag by `delta`, right and down in object units, and a change of size. `view` rotates object space to
/// eye space.
fn placed(before: Transform, view: Quat, delta: Vec2, turns: bool, factor: f32) -> Transform {
    let mut after = Transform { scale: (before.scale * factor).clamp(0.01, 100.0), ..before };
    if turns {
        let by = Quat::from_rotation_y(delta.x) * Quat::from_rotation_x(delta.y);
        after = with_turn(after, view.inverse() * by * view * own_turn(&before));
    } else {
        after.at = (Vec3::from(before.at) + view.inverse() * Vec3::new(delta.x, -delta.y, 0.0)).into();
    }
    after
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::render::Subject;
    use hypertexture::scene::{Part, preset};
    use hypertexture::shader::shipped;
    use std::f32::consts::FRAC_PI_2;

    #[test]
    fn a_drag_moves_along_the_axes_of_the_view() {
        let from_the_right = Quat::from_rotation_y(-FRAC_PI_2);
        let moved = placed(Transform::default(), from_the_right, Vec2::new(1.0, 2.0), false, 2.0);
        assert!(Vec3::from(moved.at).abs_diff_eq(Vec3::new(0.0, -2.0, -1.0), 1e-6), "{moved:?}");
        assert_eq!((moved.scale, moved.turn), (2.0, [0.0; 3]));
        let turned = placed(Transform::default(), Quat::IDENTITY, Vec2::new(0.5, 0.0), true, 1.0);
        assert!((turned.turn[1] - 0.5f32.to_degrees()).abs() < 1e-4 && turned.at == [0.0; 3], "{turned:?}");
    }

    #[test]
    fn a_click_finds_the_object_in_front() {
        let mut scene = preset("lit").unwrap();
        (scene.object.input, scene.image.size) = ("sphere".into(), [81, 81]);
        let mut part = Part::default();
        part.object.input = "sphere".into();
        part.transform = Transform { at: [0.0, 0.0, 2.0], scale: 0.2, ..part.transform };
        scene.parts.insert("near".into(), part);
        (scene.camera.azimuth, scene.camera.elevation, scene.camera.rotation) = (0.0, 0.0, None);
        let subject = Subject::load(&scene, &shipped(), &|_| ()).unwrap();
        let at = |pixel| object_along(&shipped(), &scene, &subject, pixel, PLACES).unwrap();
        assert_eq!([[40, 40], [40, 22], [0, 0]].map(at), [Some("near".into()), Some("main".into()), None]);
    }
}
