//! Strokes of the brush over the picture.

use super::state::App;
use egui::{Color32, PointerButton, Pos2, Response, Shape, Stroke, Ui};
use glam::Vec3;
use hypertexture::render::ViewPose;
use hypertexture::shape::Brush;

/// Corners of a ring that shows the brush.
const CORNERS: u16 = 48;
/// Part of the radius at which half the strength is left.
const HALF: f32 = 0.541;

impl App {
    /// Paints where a drag goes; returns whether the brush owns the drag. One that begins beside the object turns it.
    pub(super) fn paint(&mut self, ui: &Ui, response: &Response) -> bool {
        let modifiers = ui.input(|input| input.modifiers);
        let is_free = !modifiers.shift && !modifiers.command && response.dragged_by(PointerButton::Primary);
        let is_touch = response.clicked() && !modifiers.shift && !modifiers.command;
        let begins = self.panels.painting.is_on && (response.drag_started() && is_free || is_touch);
        let is_stroke = self.panels.painting.is_stroke();
        if !begins && !is_stroke {
            return false;
        }
        let pressed = ui.input(|input| input.pointer.press_origin()).filter(|_| begins);
        let at = pressed.or(response.interact_pointer_pos());
        match at.and_then(|at| self.surface_at(at)) {
            None if begins => return false,
            Some((place, normal)) if begins => match self.panels.painting.begin(self.model.scene(), place, normal) {
                Ok(file) => {
                    if !self.model.edit("groom", |scene| scene.groom = Some(file)) {
                        self.panels.painting.cancel();
                    }
                }
                Err(reason) => self.fail(reason),
            },
            Some((place, normal)) => self.panels.painting.go(place, normal),
            None => {}
        }
        if response.drag_stopped() || is_touch {
            self.panels.painting.end().unwrap_or_else(|reason| self.fail(reason));
            self.model.end_undo_group();
        }
        true
    }

    /// Place and normal of the surface under a position of the window.
    fn surface_at(&self, at: Pos2) -> Option<(Vec3, Vec3)> {
        let (pose, job) = (self.jobs.current_view?, self.jobs.submitted.as_ref()?);
        let part = 2.0 * (at - self.place.min) / self.place.size();
        let (from, along) = pose.ray([part.x - 1.0, part.y - 1.0]);
        job.variants.first()?.subject.hit(from, along)
    }

    /// Shows the brush on the surface under the pointer: its rim, and where half its strength is left.
    pub(super) fn show_brush(&self, ui: &Ui) {
        let (painting, Some(pose)) = (&self.panels.painting, self.jobs.current_view) else { return };
        let Some(at) = self.navigation.pointer.filter(|_| painting.is_on) else { return };
        let Some((place, normal)) = self.surface_at(at) else { return };
        let Brush { radius, mirrored, .. } = painting.brush;
        for (radius, alpha) in [(radius, 220), (HALF * radius, 110)] {
            self.ring(ui, &pose, [place, normal], radius, alpha);
            if mirrored {
                self.ring(ui, &pose, [place, normal].map(|v| Vec3::new(-v.x, v.y, v.z)), radius, alpha / 2);
            }
        }
    }

    fn ring(&self, ui: &Ui, pose: &ViewPose, [place, normal]: [Vec3; 2], radius: f32, alpha: u8) {
        let (right, up) = normal.any_orthonormal_pair();
        let corner = |corner: u16| {
            let (sin, cos) = (f32::from(corner) / f32::from(CORNERS) * std::f32::consts::TAU).sin_cos();
            let [x, y] = pose.place(place + radius * (cos * right + sin * up));
            self.place.min + 0.5 * self.place.size() * egui::vec2(x + 1.0, y + 1.0)
        };
        let line = Stroke::new(1.5, Color32::from_white_alpha(alpha));
        ui.painter_at(self.place).add(Shape::closed_line((0..CORNERS).map(corner).collect(), line));
    }
}
