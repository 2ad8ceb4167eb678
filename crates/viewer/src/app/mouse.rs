//! Mouse input over the picture.

use super::state::{App, Drag};
use crate::input::keys;
use crate::input::trackball::{drag_light, orbit, zoom_to};
use crate::worker::LoadedScene;
use egui::{Color32, PointerButton, Pos2, Response, Stroke, Ui, Vec2};
use glam::DVec3;
use hypertexture::render;
use hypertexture::render::variant::Variant;

/// Fraction of its speed that a gliding ball retains per second.
const GLIDE: f64 = 0.2;

impl App {
    /// Handles mouse input over the picture.
    pub(super) fn navigate(&mut self, ui: &Ui, response: &Response) {
        let delta = response.drag_delta();
        self.navigation.pointer = response.hover_pos();
        self.navigation.dragging = response.dragged();
        if response.is_pointer_button_down_on() {
            keys::stop_writing(ui.ctx());
        }
        if self.place(ui, response) || self.paint(ui, response) {
            return;
        }
        if response.drag_started() {
            let modifiers = ui.input(|input| input.modifiers);
            self.navigation.drag = if !response.dragged_by(PointerButton::Primary) || modifiers.shift {
                Drag::Pan
            } else if modifiers.command {
                Drag::Light
            } else {
                Drag::Turn
            };
            if self.navigation.drag != Drag::Light {
                self.turns();
            }
            (self.navigation.glide, self.navigation.last_turn) = (None, (DVec3::Y, 0.0));
        }
        let is_fixed = self.document.model.scene().camera.matrices.is_some() && self.navigation.drag != Drag::Light;
        if let Some(to) = response.interact_pointer_pos().filter(|_| response.dragged() && !is_fixed) {
            match self.navigation.drag {
                Drag::Turn if self.navigation.level => self.orbit(delta),
                Drag::Turn => self.roll(ui, to, delta),
                Drag::Pan => self.pan(delta),
                Drag::Light => self.drag_light(to, delta),
            }
        }
        if response.drag_stopped() {
            self.navigation.glide =
                (self.navigation.inertia && self.navigation.last_turn.1 > 0.05).then_some(self.navigation.last_turn);
            self.document.model.end_undo_group();
        }
        if response.clicked() {
            let at = response.interact_pointer_pos();
            if self.inspector.is_open() {
                self.inspect_clicked(at);
            } else {
                self.select_clicked(at);
            }
        }
        if let Some(at) = response.hover_pos() {
            let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
            let factor = (scroll / 400.0).exp() * if scroll == 0.0 { pinch } else { 1.0 };
            if factor != 1.0 && self.document.painting.is_on {
                let brush = &mut self.document.painting.brush;
                brush.radius = (brush.radius * factor).clamp(0.02, 1.0);
            } else if factor != 1.0
                && let Some(half) = self.half_height()
            {
                let from = (at - self.place.center()) / (0.5 * self.place.height().max(1.0));
                if self.turns() {
                    self.document.model.look(|camera| *camera = zoom_to(camera, factor, [from.x, -from.y], half));
                }
            }
        }
    }

    /// Moves the light around the object by a drag.
    pub(super) fn drag_light(&mut self, to: Pos2, delta: Vec2) {
        let [from, to] = [to - delta, to].map(|at| self.on_ball(at));
        self.document.model.edit("light.position", |scene| {
            scene.light.position = drag_light(scene.light.position, from, to);
        });
    }

    /// A position of the window on the trackball, right and up in units of its radius.
    fn on_ball(&self, at: Pos2) -> [f64; 2] {
        let radius = 0.5 * self.place.width().min(self.place.height()).max(1.0);
        let from = (at - self.place.center()) / radius;
        [f64::from(from.x), f64::from(-from.y)]
    }

    /// Rotates the trackball.
    fn roll(&mut self, ui: &Ui, to: Pos2, delta: Vec2) {
        self.navigation.ball.follow(&self.document.model.present().camera);
        if delta == Vec2::ZERO {
            self.navigation.last_turn.1 = 0.0;
            return;
        }
        let (axis, angle) = self.navigation.ball.drag(self.on_ball(to - delta), self.on_ball(to));
        let passed = f64::from(ui.input(|input| input.stable_dt)).max(1e-3);
        self.navigation.last_turn = (axis, angle / passed);
        self.turn();
    }

    /// Orbits about the vertical axis; the shorter side of the picture is half a turn.
    fn orbit(&mut self, delta: Vec2) {
        if delta != Vec2::ZERO {
            let part = delta / self.place.width().min(self.place.height()).max(1.0);
            self.document.model.look(|camera| *camera = orbit(camera, part.into()));
        }
    }

    fn pan(&mut self, delta: Vec2) {
        if delta != Vec2::ZERO
            && let Some(half) = self.half_height()
        {
            let unit = half / (0.5 * self.place.height().max(1.0));
            self.document.model.look(|camera| {
                let [x, y] = camera.pan;
                camera.pan = [x + delta.x * unit, y - delta.y * unit].map(|side| side.clamp(-100.0, 100.0));
            });
        }
    }

    /// Half the height of the view, object units.
    pub(super) fn half_height(&self) -> Option<f32> {
        let LoadedScene { scene, library, subject } = self.jobs.submitted.as_ref()?.variants.first()?;
        let variant = Variant::of(scene, library).ok()?;
        Some(render::half_height(&variant, subject))
    }

    fn turn(&mut self) {
        let rotation = self.navigation.ball.rotation();
        self.document.model.look(|camera| camera.rotation = Some(rotation));
    }

    /// Rotates a gliding trackball.
    pub(super) fn glide(&mut self, passed: f64) {
        let Some((axis, speed)) = self.navigation.glide else { return };
        self.navigation.ball.follow(&self.document.model.present().camera);
        self.navigation.ball.spin(axis, speed * passed);
        self.turn();
        let slower = speed * GLIDE.powf(passed);
        self.navigation.glide = (slower > 0.02).then_some((axis, slower));
        if self.navigation.glide.is_none() {
            self.document.model.end_undo_group();
        }
    }

    /// Shows the light on the trackball while it is dragged: a disk in front of the object, a ring behind it.
    pub(super) fn show_light(&self, ui: &Ui) {
        if !self.navigation.dragging || self.navigation.drag != Drag::Light {
            return;
        }
        let [x, y, z] = self.document.model.scene().light.position;
        let length = (x * x + y * y + z * z).sqrt().max(1e-6);
        let radius = 0.5 * self.place.width().min(self.place.height());
        let at = self.place.center() + Vec2::new(x, -y) / length * radius;
        let (painter, sun) = (ui.painter_at(self.place), Color32::from_rgb(255, 214, 110));
        painter.circle_stroke(self.place.center(), radius, Stroke::new(1.0, Color32::from_white_alpha(40)));
        let fill = if z >= 0.0 { sun } else { Color32::TRANSPARENT };
        painter.circle(at, 7.0, fill, Stroke::new(2.0, sun));
    }
}
