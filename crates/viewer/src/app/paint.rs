//! Strokes of the brush over the picture.

use super::state::App;
use crate::document::painting::SEVERAL;
use crate::worker::LoadedScene;
use egui::{Color32, PointerButton, Pos2, Response, Shape, Stroke, Ui};
use glam::Vec3;
use hypertexture::render::{Subject, ViewPose};
use hypertexture::shape::Brush;

/// Corners of a ring that shows the brush.
const CORNERS: u16 = 48;
/// Part of the radius at which half the strength is left.
const HALF: f32 = 0.541;
/// Share of the soft region whose matter hides what is behind, and that a ray leaves before the next part of the object.
const HIDES: f32 = 0.7;
const AWAY: f32 = 0.2;
/// Longest step along a ray, object units.
const STRIDE: f32 = 0.1;

impl App {
    /// Paints where a drag goes; returns whether the brush owns the drag. One that begins on the background turns the
    /// view. A stroke that is refused moves nothing until the button is released.
    pub(super) fn paint(&mut self, ui: &Ui, response: &Response) -> bool {
        let modifiers = ui.input(|input| input.modifiers);
        let is_free = !modifiers.shift && !modifiers.command && response.dragged_by(PointerButton::Primary);
        let is_touch = response.clicked() && !modifiers.shift && !modifiers.command;
        let begins = self.document.painting.is_on && (response.drag_started() && is_free || is_touch);
        let ends = response.drag_stopped() || is_touch;
        if begins {
            let pressed = ui.input(|input| input.pointer.press_origin());
            let at = pressed.or(response.interact_pointer_pos());
            let Some((place, normal)) = at.and_then(|at| self.surface_at(at)) else { return false };
            self.navigation.is_refused = !self.begin_stroke(place, normal) && !ends;
        } else if self.document.painting.is_stroke() {
            let at = response.interact_pointer_pos();
            if let Some((place, normal)) = at.and_then(|at| self.surface_at(at)) {
                self.document.painting.go(place, normal);
            }
        } else {
            let is_refused = std::mem::take(&mut self.navigation.is_refused);
            self.navigation.is_refused = is_refused && response.dragged();
            return is_refused;
        }
        if ends && self.document.painting.is_stroke() {
            self.document.painting.end().unwrap_or_else(|reason| self.fail(reason));
            self.document.model.end_undo_group();
        }
        true
    }

    /// Begins a stroke, which is one undo step; returns whether it was accepted.
    fn begin_stroke(&mut self, place: Vec3, normal: Vec3) -> bool {
        if self.document.model.scene().has_several() {
            self.note(SEVERAL);
            return false;
        }
        self.document.model.end_undo_group();
        match self.document.painting.begin(self.document.model.scene(), place, normal) {
            Ok(file) => {
                let good = self.document.model.edit("groom", |scene| scene.groom = Some(file));
                if !good {
                    self.document.painting.cancel();
                }
                good
            }
            Err(reason) => {
                self.fail(reason);
                false
            }
        }
    }

    /// Place and normal of the surface under a position of the window: where the ray meets it, or beside it in the soft
    /// region, the nearest place.
    fn surface_at(&self, at: Pos2) -> Option<(Vec3, Vec3)> {
        let (pose, job) = (self.jobs.current_view?, self.jobs.submitted.as_ref()?);
        let part = 2.0 * (at - self.place.min) / self.place.size();
        let (from, along) = pose.ray([part.x - 1.0, part.y - 1.0]);
        let LoadedScene { scene, library, subject } = job.variants.first()?;
        let outer = scene.check(library).ok().and_then(|parameters| parameters.outer_iso());
        touched(subject, from, along, outer.unwrap_or(scene.object.outer_iso))
    }

    /// Shows the brush on the surface under the pointer: its rim, and where half its strength is left.
    pub(super) fn show_brush(&self, ui: &Ui) {
        let (painting, Some(pose)) = (&self.document.painting, self.jobs.current_view) else { return };
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

/// Place and normal of the surface that a ray touches: in the soft region of a part in front, the nearest place of its
/// surface; else where the ray meets the surface; else the nearest place, if the ray passes through the soft region.
/// `outer` is the extent of the soft region, object units.
fn touched(subject: &Subject, from: Vec3, along: Vec3, outer: f32) -> Option<(Vec3, Vec3)> {
    let distance = subject.distance()?;
    let voxel = subject.field.as_ref().map_or(1e-3, |field| field.grid.spacing.max_element() * subject.scale);
    let normal = |place: Vec3| {
        let slope = |axis: Vec3| distance(place + voxel * axis) - distance(place - voxel * axis);
        Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z)).normalize_or(-along)
    };
    let hit = subject.hit(from, along);
    let end = hit.map(|(place, _)| (place - from).dot(along));
    // The part of the ray within the ball around the soft region.
    let (middle, reach) = (-from.dot(along), 1.05 * subject.radius + outer);
    let half = reach * reach - (from + middle * along).length_squared();
    if half <= 0.0 {
        return hit;
    }
    let (mut at, end) = ((middle - half.sqrt()).max(0.0), end.unwrap_or(middle + half.sqrt()));
    let mut best: Option<(f32, f32)> = None;
    while at < end {
        let left = distance(from + at * along);
        match best {
            // Behind a part in front, whose matter is dense enough to hide what is behind.
            Some((_, least)) if least < HIDES * outer && left > least + AWAY * outer => break,
            Some((_, least)) if least <= left => {}
            _ => best = Some((at, left)),
        }
        at += (0.5 * left.abs()).clamp(0.5 * voxel.max(1e-3), STRIDE);
    }
    if let Some((near, least)) = &mut best {
        // The nearest place is between two samples.
        for halving in 1..=6 {
            let step = STRIDE * 0.5_f32.powi(halving);
            for at in [*near - step, *near + step] {
                let left = distance(from + at * along);
                if left < *least {
                    (*near, *least) = (at, left);
                }
            }
        }
    }
    let is_behind = best.is_some_and(|(near, least)| least < HIDES * outer && near < end - AWAY * outer && at < end);
    match (hit, best) {
        (Some(hit), _) if !is_behind => Some(hit),
        (_, Some((near, least))) if least <= outer => {
            let place = from + near * along;
            let out = normal(place);
            Some((place - least * out, out))
        }
        (hit, _) => hit,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::scene::preset;
    use hypertexture::shader::shipped;

    #[test]
    fn a_ray_through_fur_touches_the_nearest_skin() {
        let mut scene = preset("lit").unwrap();
        scene.object.input = "torus".into();
        let subject = Subject::load(&scene, &shipped(), &|_| ()).unwrap();
        // The ring lies about y, of radius 0.7, its tube of radius 0.3.
        let down = |x: f32, outer: f32| touched(&subject, Vec3::new(x, 3.0, 0.0), Vec3::NEG_Y, outer);
        let near = |found: Option<(Vec3, Vec3)>, place: Vec3, normal: Vec3| {
            let (at, out) = found.unwrap();
            assert!(at.distance(place) < 0.02 && out.distance(normal) < 0.03, "{at} {out}");
        };
        near(down(0.7, 0.2), Vec3::new(0.7, 0.3, 0.0), Vec3::Y);
        // Beside the ring, 0.1 from it, and in its hole.
        near(down(1.1, 0.2), Vec3::X, Vec3::X);
        near(down(-1.1, 0.2), Vec3::NEG_X, Vec3::NEG_X);
        near(down(0.3, 0.2), Vec3::new(0.4, 0.0, 0.0), Vec3::NEG_X);
        assert!(down(1.1, 0.05).is_none() && down(0.0, 0.2).is_none() && down(1.3, 0.2).is_none());
        // A ray that passes the front of the ring in its fur, and meets the back.
        let (from, to) = (Vec3::new(0.0, 0.68, 3.0), Vec3::new(0.0, 0.2, -0.7));
        let front = touched(&subject, from, (to - from).normalize(), 0.2).unwrap();
        assert!(front.0.z > 0.4, "{front:?}");
        let bald = touched(&subject, from, (to - from).normalize(), 0.0).unwrap();
        assert!(bald.0.z < 0.0, "{bald:?}");
    }
}
