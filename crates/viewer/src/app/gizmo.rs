//! The gizmo: own axes of the placed object or the sun of the placed light, and numbers typed while placing.

use super::state::App;
use crate::input::keys;
use egui::{Align2, Color32, Context, Event, FontId, Key, PointerButton, Pos2, Response, Stroke, Ui, Vec2, vec2};
use glam::{EulerRot, Quat, Vec3};
use hypertexture::render::ViewPose;
use hypertexture::scene::Transform;

/// Length of an axis, and the distance at which the pointer takes hold of it, points.
const LENGTH: f32 = 80.0;
const GRAB_DISTANCE: f32 = 9.0;
/// Names and colors of the axes.
const AXES: [(&str, Color32); 3] = [
    ("x", Color32::from_rgb(235, 87, 87)),
    ("y", Color32::from_rgb(111, 207, 99)),
    ("z", Color32::from_rgb(86, 148, 255)),
];
const SUN: Color32 = Color32::from_rgb(255, 214, 110);
/// Margin of a sun beside the picture, points.
const MARGIN: f32 = 14.0;
/// Most characters of a typed number.
const DIGITS: usize = 12;

impl App {
    /// A point of the picture, in points of the window.
    pub(super) fn on_screen(&self, [x, y]: [f32; 2]) -> Pos2 {
        self.place.min + 0.5 * self.place.size() * vec2(x + 1.0, y + 1.0)
    }

    /// Center and ends of the axes of an object, in points of the window, and the length of an axis in object units.
    fn axes(&self, pose: &ViewPose, transform: &Transform) -> Option<(Pos2, [Pos2; 3], f32)> {
        let length = LENGTH * self.half_height()? / (0.5 * self.place.height().max(1.0));
        let at = Vec3::from(transform.at);
        let end = |axis: Vec3| self.on_screen(pose.place(at + length * axis));
        Some((self.on_screen(pose.place(at)), own_axes(transform).map(end), length))
    }

    /// Moves the selected object along the axis that a drag began at, or turns it about this axis with Shift; whether the
    /// drag belongs to an axis.
    pub(super) fn place_on_axis(&mut self, ui: &Ui, response: &Response, part: &str) -> bool {
        let Some(transform) = self.document.model.present().parts.get(part).map(|part| part.transform) else {
            return false;
        };
        let Some(pose) = self.jobs.current_view else { return false };
        let Some((center, ends, length)) = self.axes(&pose, &transform) else { return false };
        if response.drag_started_by(PointerButton::Primary) {
            let from = ui.input(|input| input.pointer.press_origin());
            self.objects.gizmo.grabbed = from.and_then(|from| nearest(from, center, &ends));
        }
        let Some(axis) = self.objects.gizmo.grabbed else { return false };
        let delta = response.drag_delta();
        if let Some(to) = response.interact_pointer_pos().filter(|_| delta != Vec2::ZERO) {
            let along = own_axes(&transform)[axis];
            let turns = ui.input(|input| input.modifiers.shift);
            let after = if turns {
                let eye = self.document.model.present().camera.turn() * along;
                Some(turned(transform, axis, turn_of(delta, eye)))
            } else {
                let part = |at: Pos2| {
                    let [x, y] = (2.0 * (at - self.place.min) / self.place.size()).into();
                    let (from, ray) = pose.ray([x - 1.0, y - 1.0]);
                    nearest_on_line(transform.at.into(), along, from, ray)
                };
                let moved = part(to).zip(part(to - delta)).map(|(to, from)| to - from);
                moved.filter(|moved| moved.abs() < 100.0 * length).map(|by| moved_along(transform, axis, by))
            };
            self.objects.gizmo.last = (axis, turns);
            after.into_iter().for_each(|after| self.transform(part, after));
        }
        if response.drag_stopped() {
            self.objects.gizmo.grabbed = None;
            self.document.model.end_undo_group();
        }
        true
    }

    fn transform(&mut self, part: &str, transform: Transform) {
        self.document.model.edit("transform", |scene| {
            if let Some(part) = scene.parts.get_mut(part) {
                part.transform = transform;
            }
        });
    }

    /// Moves the light around the object by a drag, and changes its distance by the wheel; whether the mouse belongs to it.
    pub(super) fn place_light(&mut self, response: &Response, wheel: f32) -> bool {
        let is_drag = response.dragged_by(PointerButton::Primary);
        if let Some(to) = response.interact_pointer_pos().filter(|_| is_drag && response.drag_delta() != Vec2::ZERO) {
            self.drag_light(to, response.drag_delta());
        }
        if wheel != 0.0 {
            self.light_at(|distance| distance * (wheel / 400.0).exp());
        }
        if response.drag_stopped() {
            self.document.model.end_undo_group();
        }
        is_drag || wheel != 0.0 || response.drag_stopped()
    }

    /// Changes the distance of the light from the object.
    fn light_at(&mut self, distance: impl Fn(f32) -> f32) {
        self.document.model.edit("light.position", |scene| {
            let at = Vec3::from(scene.light.position);
            let far = distance(at.length()).clamp(0.01, 1e6);
            scene.light.position = (at.try_normalize().unwrap_or(Vec3::Z) * far).to_array();
        });
    }

    /// Takes the keys of numbers while something is placed: Enter applies the number.
    pub(super) fn type_number(&mut self, context: &Context) {
        let is_taken =
            keys::writes(context) || context.egui_wants_keyboard_input() || egui::Popup::is_any_open(context);
        if !self.objects.places || is_taken {
            return;
        }
        let mut typed = std::mem::take(&mut self.objects.gizmo.typed);
        let (before, mut is_done) = (typed.clone(), false);
        context.input_mut(|input| {
            input.events.retain(|event| match event {
                Event::Text(text) if text.chars().all(is_of_number) => {
                    typed.extend(text.chars().take(DIGITS.saturating_sub(typed.len())));
                    false
                }
                Event::Key { key, pressed, .. } => match key {
                    Key::Backspace | Key::Enter | Key::Escape if !typed.is_empty() && *pressed => {
                        match key {
                            Key::Backspace => drop(typed.pop()),
                            Key::Enter => is_done = true,
                            _ => typed.clear(),
                        }
                        false
                    }
                    key => !key.symbol_or_name().chars().all(is_of_number) && *key != Key::Minus,
                },
                _ => true,
            });
        });
        let part = self.document.selection.part().map(String::from);
        let (axis, turns) = self.objects.gizmo.last;
        let what = match (&part, turns) {
            (None, _) => "distance of the light".into(),
            (Some(part), true) => format!("{part}: degrees about {}", AXES[axis].0),
            (Some(part), false) => format!("{part}: move along {}", AXES[axis].0),
        };
        match typed.parse::<f32>() {
            Ok(number) if is_done => {
                match part {
                    None => self.light_at(|_| number),
                    Some(part) => {
                        let before = self.document.model.present().parts.get(&part).map(|part| part.transform);
                        let after = before.map(|before| {
                            if turns {
                                turned(before, axis, number.to_radians())
                            } else {
                                moved_along(before, axis, number)
                            }
                        });
                        after.into_iter().for_each(|after| self.transform(&part, after));
                    }
                }
                self.document.model.end_undo_group();
                self.note(format!("{what}: {number}"));
            }
            Err(_) if is_done => self.note(format!("{what}: `{typed}` is not a number")),
            _ => {
                if typed != before {
                    self.note(format!("{what}: {typed}"));
                }
                self.objects.gizmo.typed = typed;
            }
        }
    }

    /// Shows the axes of the placed object, or the sun of the placed light.
    pub(super) fn show_gizmo(&self, ui: &Ui) {
        let Some(pose) = self.jobs.current_view.filter(|_| self.objects.places) else { return };
        let scene = self.document.model.present();
        let painter = ui.painter_at(self.place);
        let Some(part) = self.document.selection.part() else {
            let at = scene.light.position;
            let (at, is_seen) = sun(self.place, pose.place_in_view(at.into()).map(|at| self.on_screen(at)), at);
            let fill = if is_seen { SUN } else { Color32::TRANSPARENT };
            painter.circle(at, 6.0, fill, Stroke::new(2.0, SUN));
            for ray in 0..8u8 {
                let way = Vec2::angled(f32::from(ray) * std::f32::consts::FRAC_PI_4);
                painter.line_segment([at + 8.5 * way, at + 12.0 * way], Stroke::new(2.0, SUN));
            }
            return;
        };
        let Some(transform) = scene.parts.get(part).map(|part| part.transform) else { return };
        let Some((center, ends, _)) = self.axes(&pose, &transform) else { return };
        let held = self.objects.gizmo.grabbed.or(self.navigation.pointer.and_then(|at| nearest(at, center, &ends)));
        for (axis, (end, (name, color))) in ends.into_iter().zip(AXES).enumerate() {
            let width = if held == Some(axis) { 4.0 } else { 2.0 };
            painter.line_segment([center, end], Stroke::new(width + 2.0, Color32::from_black_alpha(110)));
            painter.line_segment([center, end], Stroke::new(width, color));
            painter.circle(end, 4.0 + 0.5 * width, color, Stroke::new(1.0, Color32::from_black_alpha(160)));
            let beside = end + 14.0 * (end - center).normalized();
            painter.text(beside, Align2::CENTER_CENTER, name, FontId::proportional(13.0), color);
        }
        painter.circle_filled(center, 3.0, Color32::WHITE);
    }
}

fn is_of_number(c: char) -> bool {
    c.is_ascii_digit() || ['.', '-'].contains(&c)
}

/// The rotation of an object.
pub(super) fn own_turn(transform: &Transform) -> Quat {
    let [x, y, z] = transform.turn.map(f32::to_radians);
    Quat::from_euler(EulerRot::ZYX, z, y, x)
}

/// The object's own axes in object space of the scene.
fn own_axes(transform: &Transform) -> [Vec3; 3] {
    Vec3::AXES.map(|axis| own_turn(transform) * axis)
}

/// A transform moved along one of its own axes.
fn moved_along(before: Transform, axis: usize, by: f32) -> Transform {
    Transform { at: (Vec3::from(before.at) + by * own_axes(&before)[axis]).into(), ..before }
}

/// A transform turned about one of its own axes, radians.
fn turned(before: Transform, axis: usize, angle: f32) -> Transform {
    with_turn(before, own_turn(&before) * Quat::from_axis_angle(Vec3::AXES[axis], angle))
}

/// A transform with another rotation.
pub(super) fn with_turn(before: Transform, turn: Quat) -> Transform {
    let (z, y, x) = turn.to_euler(EulerRot::ZYX);
    Transform { turn: [x, y, z].map(f32::to_degrees), ..before }
}

/// The parameter of the point on a line that is nearest to a ray, both of unit direction; `None` if they are parallel.
fn nearest_on_line(at: Vec3, along: Vec3, from: Vec3, ray: Vec3) -> Option<f32> {
    let (cos, between) = (along.dot(ray), from - at);
    let sin_squared = 1.0 - cos * cos;
    (sin_squared > 1e-3).then(|| (between.dot(along) - cos * between.dot(ray)) / sin_squared)
}

/// Radians about an axis, given in eye space, by a drag across it: its front follows the pointer.
fn turn_of(delta: Vec2, axis: Vec3) -> f32 {
    let across = vec2(axis.y, axis.x);
    if across.length() < 0.05 { delta.y / LENGTH } else { delta.dot(across.normalized()) / LENGTH }
}

/// The axis whose line is nearest to a point, if one is near.
fn nearest(at: Pos2, center: Pos2, ends: &[Pos2; 3]) -> Option<usize> {
    let distance = |end: Pos2| {
        let (way, from) = (end - center, at - center);
        let part = (from.dot(way) / way.length_sq().max(1e-6)).clamp(0.25, 1.0);
        (from - part * way).length()
    };
    let all = ends.iter().map(|end| distance(*end)).enumerate();
    all.filter(|(_, distance)| *distance < GRAB_DISTANCE).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(axis, _)| axis)
}

/// The place of the sun, and whether it is that of the light. One behind the eye or beside the picture stands at its edge,
/// in the direction of the light.
fn sun(picture: egui::Rect, at: Option<Pos2>, [x, y, _]: [f32; 3]) -> (Pos2, bool) {
    let inside = picture.shrink(MARGIN);
    if let Some(at) = at.filter(|at| inside.contains(*at)) {
        return (at, true);
    }
    let way = vec2(x, -y);
    let to_edge = 0.5 * inside.size() / way.abs().max(Vec2::splat(1e-6));
    (inside.center() + way * to_edge.min_elem(), false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    #[test]
    fn a_ray_meets_a_line_where_it_is_nearest() {
        // A ray straight down on the x axis from (2, 1, 5), and one 3 beside it.
        let line = (Vec3::new(1.0, 1.0, 1.0), Vec3::X);
        assert_eq!(nearest_on_line(line.0, line.1, Vec3::new(3.0, 1.0, 5.0), -Vec3::Z), Some(2.0));
        assert_eq!(nearest_on_line(line.0, line.1, Vec3::new(-1.0, 4.0, 5.0), -Vec3::Z), Some(-2.0));
        // Slanted by 45 degrees in the plane of the line: it meets the line 4 farther.
        let slanted = Vec3::new(1.0, 0.0, -1.0).normalize();
        let met = nearest_on_line(line.0, line.1, Vec3::new(1.0, 1.0, 5.0), slanted).unwrap();
        assert!((met - 4.0).abs() < 1e-5, "{met}");
        assert_eq!(nearest_on_line(line.0, line.1, Vec3::ZERO, Vec3::X), None);
    }

    #[test]
    fn a_move_and_a_turn_are_about_the_own_axes() {
        // A quarter about z: the own x axis is y, and the own y axis is -x.
        let quarter = Transform { turn: [0.0, 0.0, 90.0], ..Transform::default() };
        assert!(Vec3::from(moved_along(quarter, 0, 0.25).at).abs_diff_eq(Vec3::new(0.0, 0.25, 0.0), 1e-6));
        assert!(Vec3::from(moved_along(quarter, 1, 0.25).at).abs_diff_eq(Vec3::new(-0.25, 0.0, 0.0), 1e-6));
        let more = turned(quarter, 2, 30f32.to_radians()).turn;
        assert!(Vec3::from(more).abs_diff_eq(Vec3::new(0.0, 0.0, 120.0), 1e-3), "{more:?}");
        // About its own axis, the axis stays.
        for axis in 0..3 {
            let before = Transform { turn: [20.0, 40.0, -70.0], ..Transform::default() };
            let (own, now) = (own_axes(&before), own_axes(&turned(before, axis, 1.0)));
            assert!(own[axis].abs_diff_eq(now[axis], 1e-5));
            let next = (axis + 1) % 3;
            assert!((own[next].dot(now[next]) - 1f32.cos()).abs() < 1e-5);
        }
    }

    #[test]
    fn the_front_follows_a_drag_across_the_axis() {
        for (delta, axis) in [(vec2(LENGTH, 0.0), Vec3::Y), (vec2(0.0, LENGTH), Vec3::X), (vec2(LENGTH, 0.0), -Vec3::Y)]
        {
            // The front of the object, toward the eye, by a small turn.
            let angle = 1e-3 * turn_of(delta, axis);
            let front = Quat::from_axis_angle(axis, angle) * Vec3::Z;
            assert!((vec2(front.x, -front.y) - 1e-3 * delta / LENGTH).length() < 1e-6, "{delta} {axis}");
        }
        assert_eq!(turn_of(vec2(0.0, 5.0), Vec3::Y), 0.0, "along the axis");
    }

    #[test]
    fn the_sun_stands_where_the_light_is_or_at_the_edge_toward_it() {
        let picture = egui::Rect::from_min_size(pos2(100.0, 50.0), vec2(400.0, 200.0));
        assert_eq!(sun(picture, Some(pos2(150.0, 90.0)), [1.0, 1.0, 1.0]), (pos2(150.0, 90.0), true));
        let (at, is_seen) = sun(picture, None, [0.0, 3.0, 9.0]);
        assert_eq!((at, is_seen), (pos2(300.0, 50.0 + MARGIN), false));
        let (at, _) = sun(picture, Some(pos2(9000.0, 90.0)), [8.0, 0.0, 0.0]);
        assert_eq!(at, pos2(500.0 - MARGIN, 150.0));
        assert_eq!(sun(picture, None, [0.0; 3]).0, picture.center());
    }

    #[test]
    fn the_pointer_takes_hold_of_the_nearest_axis() {
        let ends = [pos2(180.0, 100.0), pos2(100.0, 20.0), pos2(60.0, 140.0)];
        let center = pos2(100.0, 100.0);
        assert_eq!(nearest(pos2(150.0, 105.0), center, &ends), Some(0));
        assert_eq!(nearest(pos2(97.0, 22.0), center, &ends), Some(1));
        assert_eq!(nearest(pos2(100.0, 101.0), center, &ends), None, "the center moves freely");
        assert_eq!(nearest(pos2(190.0, 190.0), center, &ends), None);
    }
}
