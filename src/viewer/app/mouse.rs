//! What the mouse does over the picture.

use super::App;
use crate::render;
use crate::render::variant::Variant as Program;
use crate::viewer::screen::Screen;
use crate::viewer::worker::Variant;
use egui::{PointerButton, Response, Ui, Vec2};
use glam::DVec3;

/// The part of its speed that a ball with inertia keeps for a second.
const GLIDE: f64 = 0.2;

impl App {
    /// The mouse over the picture.
    pub(super) fn navigate(&mut self, ui: &Ui, response: &Response) {
        let pane = Screen::pane(self.place, self.kept.is_some());
        let (delta, shift) = (response.drag_delta(), ui.input(|input| input.modifiers.shift));
        let turns = response.dragged_by(PointerButton::Primary) && !shift;
        let pans = response.dragged() && !turns;
        self.dragging = response.dragged();
        if response.drag_started() {
            (self.glide, self.last_turn) = (None, (DVec3::Y, 0.0));
        }
        if let Some(to) = response.interact_pointer_pos().filter(|_| turns) {
            // Every pane has a ball of its own.
            let start = self.place.min.x + ((to.x - self.place.min.x) / pane.x).floor() * pane.x;
            let middle = egui::pos2(start + 0.5 * pane.x, self.place.center().y);
            let radius = 0.5 * pane.x.min(pane.y).max(1.0);
            let on_ball =
                |at: egui::Pos2| [f64::from((at.x - middle.x) / radius), f64::from((middle.y - at.y) / radius)];
            self.ball.follow(&self.model.scene().camera);
            if delta != Vec2::ZERO {
                let (axis, angle) = self.ball.drag(on_ball(to - delta), on_ball(to));
                let passed = f64::from(ui.input(|input| input.stable_dt)).max(1e-3);
                self.last_turn = (axis, angle / passed);
                self.turn();
            } else {
                self.last_turn.1 = 0.0;
            }
        }
        if response.drag_stopped() {
            self.glide = (self.inertia && self.last_turn.1 > 0.05).then_some(self.last_turn);
            self.model.end_undo_group();
        }
        if pans
            && delta != Vec2::ZERO
            && let Some(half) = self.half_height()
        {
            let unit = half / (0.5 * pane.y.max(1.0));
            self.model.edit("camera", |scene| {
                let [x, y] = scene.camera.pan;
                scene.camera.pan = [x + delta.x * unit, y - delta.y * unit].map(|side| side.clamp(-100.0, 100.0));
            });
        }
        if response.hovered() {
            let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
            let factor = (scroll / 400.0).exp() * if scroll == 0.0 { pinch } else { 1.0 };
            if factor != 1.0 {
                self.model.edit("camera.zoom", |scene| {
                    scene.camera.zoom = (scene.camera.zoom * factor).clamp(0.02, 100.0);
                });
            }
        }
    }

    /// Half the height of the view, object units.
    fn half_height(&self) -> Option<f32> {
        let Variant { scene, subject } = self.posted.as_ref()?.variants.first()?;
        let variant = Program::of(scene, &self.library).ok()?;
        Some(render::half_height(scene, subject, &variant))
    }

    fn turn(&mut self) {
        let rotation = self.ball.rotation();
        self.model.edit("camera", |scene| scene.camera.rotation = Some(rotation));
    }

    /// Lets the ball turn on.
    pub(super) fn glide(&mut self, passed: f64) {
        let Some((axis, speed)) = self.glide else { return };
        self.ball.follow(&self.model.scene().camera);
        self.ball.spin(axis, speed * passed);
        self.turn();
        let slower = speed * GLIDE.powf(passed);
        self.glide = (slower > 0.02).then_some((axis, slower));
        if self.glide.is_none() {
            self.model.end_undo_group();
        }
    }
}
