//! The frame of the picture: it is held while objects are placed, hidden or grow, and follows a request.

use super::state::App;
use crate::load::Key;
use crate::worker::LoadedScene;
use egui::{Pos2, Shape, Stroke, Ui};
use glam::Vec3;
use hypertexture::render::variant::Variant;
use hypertexture::render::{self, Subject, ViewPose};
use hypertexture::scene::{Camera, Projection, Scene};
use std::sync::Arc;

/// Fraction of half the picture that a framed object fills.
const FILL: f32 = 0.7;
/// Smallest relative change of the frame that is corrected.
const LEAST: f32 = 1e-4;

/// The view of a scene, and half its height at the middle of the scene, object units.
struct Framed {
    pose: ViewPose,
    half: f32,
}

impl App {
    /// Width and height of the picture in the window, points: its shape decides the distance of the camera.
    fn pane(&self) -> [u32; 2] {
        [self.place.width(), self.place.height()].map(|side| side.max(16.0) as u32)
    }

    /// The view of a scene in the window by objects in the cache.
    fn framed(&mut self, scene: &Scene) -> Option<Framed> {
        let mut scene = scene.moment().ok()?.into_owned();
        scene.image.size = self.pane();
        let library = self.document.model.shared_library().clone();
        let (_, subject) = self.loader.any(&Key::of(&scene, &library).ok()?)?;
        let program = Variant::of(&scene, &library).ok()?;
        Some(Framed { pose: ViewPose::of(&program, &subject), half: render::half_height(&program, &subject) })
    }

    /// Keeps the frame after a change from `before` of anything but the view. The camera looks at the middle of all
    /// objects from a distance that shows them; its pan and zoom make up for a change of both.
    pub(super) fn hold_frame(&mut self, before: &Arc<Scene>) {
        let now = self.document.model.shared_scene().clone();
        if Arc::ptr_eq(before, &now) {
            return;
        }
        let is_held = now.camera == before.camera
            && now.object.input == before.object.input
            && now.about == before.about
            && now.camera.matrices.is_none()
            && !now.animation.tracks.keys().any(|field| field.starts_with("camera."))
            && (now.parts != before.parts
                || now.parameters != before.parameters
                || now.combine != before.combine
                || now.object != before.object);
        if !is_held {
            return;
        }
        let (Some(from), Some(to)) = (self.framed(before), self.framed(&now)) else { return };
        let camera = held(&now.camera, now.object.stretch.into(), &from, &to);
        if camera != now.camera {
            self.document.model.amend_view(camera);
        }
    }

    /// Frames the selected object, or all.
    pub(super) fn frame_objects(&mut self) {
        self.navigation.glide = None;
        if !self.turns() {
            return;
        }
        let selected = self.document.selection.part().map(String::from);
        let Some(name) = selected else {
            self.document.model.look(|camera| (camera.pan, camera.zoom) = ([0.0; 2], 1.0));
            return self.note("all objects are framed");
        };
        let Some((center, radius)) = self.ball_of(&name) else {
            return self.note(format!("{name} is not loaded yet: it cannot be framed"));
        };
        let mut scene = self.document.model.scene().clone();
        let [width, height] = self.pane();
        let aspect = width as f32 / height as f32;
        (scene.camera.pan, scene.camera.zoom) = ([0.0; 2], 1.0);
        let Some(Framed { half, .. }) = self.framed(&scene) else { return };
        scene.camera.zoom = (FILL * half * aspect.min(1.0) / radius.max(1e-3)).clamp(0.02, 100.0);
        // From its distance, the place of the object in the picture gives the way to it.
        let Some(Framed { pose, half }) = self.framed(&scene) else { return };
        let ([x, y], zoom) = (pose.place(center), scene.camera.zoom);
        let pan = [-x * half * aspect, y * half].map(|side| side.clamp(-100.0, 100.0));
        self.document.model.look(|camera| (camera.pan, camera.zoom) = (pan, zoom));
        self.note(format!("{name} is framed"));
    }

    /// Center and radius of an additional object, object space of the scene.
    fn ball_of(&self, name: &str) -> Option<(Vec3, f32)> {
        let part = self.document.model.present().parts.get(name)?.transform;
        let subject = self.jobs.submitted.as_ref()?.variants.first()?.subject.parts.get(name)?;
        Some((part.at.into(), part.scale * subject.radius))
    }

    /// Outlines the selected object of several by the box around it.
    pub(super) fn show_selected(&self, ui: &Ui) {
        let scene = self.document.model.present();
        let Some(job) = self.jobs.submitted.as_ref().filter(|_| !scene.parts.is_empty()) else { return };
        let (Some(pose), Some(LoadedScene { subject, .. })) = (self.jobs.current_view, job.variants.first()) else {
            return;
        };
        let selected = self.document.selection.part();
        let (own, matrix) = match selected {
            None => (&**subject, glam::Mat4::IDENTITY),
            Some(name) => match (subject.parts.get(name), scene.parts.get(name)) {
                (Some(own), Some(part)) if !part.hidden => (own, part.transform.matrix()),
                _ => return,
            },
        };
        let color = ui.visuals().selection.stroke.color;
        let painter = ui.painter_at(self.place);
        for [from, to] in edges(own) {
            let ends = [from, to].map(|corner| self.on_screen(pose.place(matrix.transform_point3(corner))));
            if ends.iter().all(|end: &Pos2| end.x.is_finite() && end.y.is_finite()) {
                painter.add(Shape::line_segment(ends, Stroke::new(3.0, egui::Color32::from_black_alpha(90))));
                painter.add(Shape::line_segment(ends, Stroke::new(1.0, color)));
            }
        }
    }
}

/// Corners of the box around an object: the ends of its edges, of which the middles are left out.
fn edges(subject: &Subject) -> Vec<[Vec3; 2]> {
    let half = subject.half_size;
    let mut all = Vec::new();
    for corner in 0..8u8 {
        let sign = |axis: u8| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
        let at = half * Vec3::new(sign(0), sign(1), sign(2));
        for axis in Vec3::AXES {
            all.push([at, at - 0.5 * at * axis]);
        }
    }
    all
}

/// A camera for the objects of `to` whose picture of the main object has the place and the size of that of `from`: the
/// distance of its center stays, and the pan makes up for the middle of all objects, at which the camera looks.
fn held(camera: &Camera, stretch: Vec3, from: &Framed, to: &Framed) -> Camera {
    let eye = |framed: &Framed| camera.turn() * (stretch * framed.pose.ray([0.0; 2]).0);
    // Eyes from the center of the main object: right, up, toward the eye.
    let [before, after] = [from, to].map(eye);
    let way = after - before;
    // Distances of the eyes from the middles; factors from object units of one pan to those of the other.
    let [closer, own, across] = match camera.projection {
        Projection::Parallel => [from.half / to.half, 1.0, 1.0],
        Projection::Perspective => {
            let slope = (0.5 * camera.field_of_view.to_radians()).tan();
            let [first, second] = [from, to].map(|framed| framed.half / slope);
            let distance = second - way.z;
            // An eye beside or behind the center is held to the middle.
            let depth = if before.z > 0.1 * first { before.z } else { first };
            [distance / second, distance / first, distance / depth]
        }
    };
    let is_still = (closer - 1.0).abs() < LEAST && way.truncate().length() < LEAST * to.half;
    if is_still || !closer.is_finite() || closer <= 0.0 {
        return camera.clone();
    }
    let pan = [camera.pan[0] * own + way.x * across, camera.pan[1] * own + way.y * across];
    let zoom = (camera.zoom / closer).clamp(0.01, 100.0);
    Camera { zoom, pan: pan.map(|side| side.clamp(-100.0, 100.0)), ..camera.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::scene::{Part, preset};
    use hypertexture::shader::shipped;

    #[test]
    fn the_main_object_keeps_its_place_while_another_moves() {
        for projection in [Projection::Perspective, Projection::Parallel] {
            let mut scene = preset("lit").unwrap();
            scene.object.input = "sphere".into();
            let mut part = Part::default();
            part.object.input = "cube".into();
            part.transform.scale = 0.5;
            scene.parts.insert("b".into(), part);
            (scene.camera.projection, scene.camera.pan, scene.camera.zoom) = (projection, [0.3, -0.2], 1.3);
            let subject = Subject::load(&scene, &shipped(), &|_| ()).unwrap();
            let framed = |scene: &Scene| {
                let program = Variant::of(scene, &shipped()).unwrap();
                Framed { pose: ViewPose::of(&program, &subject), half: render::half_height(&program, &subject) }
            };
            // The center, and a place beside it in the plane of the picture.
            let side = scene.camera.turn().inverse() * Vec3::new(0.5, 0.4, 0.0);
            let seen = |scene: &Scene| [Vec3::ZERO, side].map(|place| framed(scene).pose.place(place));
            let (first, own) = (scene.camera.clone(), seen(&scene));
            for at in [[1.0, 0.0, 0.0], [2.5, 1.0, -1.0], [0.0, -3.0, 2.0], [0.0; 3]] {
                let before = framed(&scene);
                scene.parts.get_mut("b").unwrap().transform.at = at;
                scene.camera = held(&scene.camera, Vec3::ONE, &before, &framed(&scene));
                let now = seen(&scene);
                for (now, own) in now.iter().flatten().zip(own.iter().flatten()) {
                    assert!((now - own).abs() < 2e-3, "{projection:?} {at:?}: {now} for {own}");
                }
            }
            // Back at its place, the camera is that of the beginning.
            let off = [0, 1].map(|axis| (scene.camera.pan[axis] - first.pan[axis]).abs());
            assert!(off[0].max(off[1]) < 2e-3 && (scene.camera.zoom - first.zoom).abs() < 2e-3, "{:?}", scene.camera);
        }
    }
}
