//! The axis of time below the picture.

use super::widgets::short;
use egui::{FontId, Pos2, Rect, Sense, Stroke, Ui, vec2};

/// Width left of the axis: names and buttons of the tracks, points.
pub(super) const LEFT: f32 = 206.0;
/// Height of the ticks with their numbers, points.
const TICKS: f32 = 16.0;
/// Smallest distance of two ticks, and of two numbers, points.
const APART: [f32; 2] = [6.0, 56.0];
/// Ticks between two numbers, in frames below a second, and in seconds above.
const FRAMES: [f64; 4] = [1.0, 2.0, 5.0, 10.0];
const SECONDS: [f64; 12] = [1.0, 2.0, 5.0, 10.0, 20.0, 60.0, 120.0, 300.0, 600.0, 3600.0, 36000.0, 1e6];

/// The axis of time, shared by the handle, the ticks and the keyframes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    /// Place of the left end, points.
    pub left: f32,
    /// Points.
    pub width: f32,
    /// Times at both ends, seconds.
    pub range: [f64; 2],
    /// Frames per second of the ticks.
    pub fps: f64,
}

impl Axis {
    /// The place of a time, points.
    pub(super) fn x(&self, time: f64) -> f32 {
        let [from, to] = self.range;
        self.left + (f64::from(self.width) * (time - from) / (to - from)) as f32
    }

    /// The time of a place.
    pub(super) fn time(&self, x: f32) -> f64 {
        let [from, to] = self.range;
        from + (to - from) * f64::from(x - self.left) / f64::from(self.width.max(1.0))
    }

    /// The start of the nearest frame.
    pub(super) fn snapped(&self, time: f64) -> f64 {
        // Milliseconds, as keyframes that are set at the present time.
        (1e3 * (time * self.fps).round() / self.fps).round() / 1e3
    }

    /// The horizontal range with a margin.
    pub(super) fn span(&self, margin: f32) -> egui::Rangef {
        egui::Rangef::new(self.left - margin, self.left + self.width + margin)
    }

    /// Distances of ticks and of numbers, seconds.
    fn steps(&self) -> [f64; 2] {
        let a_second = f64::from(self.width) / (self.range[1] - self.range[0]);
        let all = || FRAMES.iter().map(|frames| frames / self.fps).chain(SECONDS);
        APART.map(|least| all().find(|step| step * a_second >= f64::from(least)).unwrap_or(1e6))
    }
}

/// The frame of a time. Times are rounded to milliseconds, which may be before the start of their frame.
pub(super) fn frame(time: f64, fps: f64) -> f64 {
    (time * fps + 0.05).floor()
}

/// Ticks of frames or seconds below the handle, with numbers of seconds or of frames.
pub(super) fn ticks(ui: &mut Ui, axis: &Axis) {
    let (place, _) = ui.allocate_exact_size(vec2(ui.available_width(), TICKS), Sense::hover());
    let (painter, visuals) = (ui.painter_at(place), ui.visuals());
    let [tick, number] = axis.steps();
    let [from, to] = axis.range;
    let all = |step: f64| {
        let first = (from / step - 1e-6).ceil() as i64;
        (first..).map(move |index| index as f64 * step).take_while(move |time| *time <= to + 1e-9).take(4000)
    };
    for time in all(tick) {
        let x = axis.x(time);
        painter.vline(x, place.top()..=place.top() + 3.0, Stroke::new(1.0, visuals.weak_text_color()));
    }
    for time in all(number) {
        let x = axis.x(time);
        painter.vline(x, place.top()..=place.top() + 6.0, Stroke::new(1.0, visuals.text_color()));
        let text = match number {
            step if step < 1.0 => format!("{:.0}", (time * axis.fps).round()),
            _ => format!("{} s", short(time)),
        };
        let galley = painter.layout_no_wrap(text, FontId::proportional(10.0), visuals.weak_text_color());
        let left = (x - 0.5 * galley.size().x).clamp(place.left(), (place.right() - galley.size().x).max(place.left()));
        let at = Rect::from_min_size(Pos2::new(left, place.top() + 5.0), galley.size());
        painter.galley(at.min, galley, visuals.weak_text_color());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_places_of_an_axis_are_inverse_and_snap_to_frames() {
        let axis = Axis { left: 100.0, width: 500.0, range: [2.0, 12.0], fps: 25.0 };
        assert_eq!([axis.x(2.0), axis.x(7.0), axis.x(12.0)], [100.0, 350.0, 600.0]);
        assert!((axis.time(axis.x(3.21)) - 3.21).abs() < 1e-5);
        assert_eq!([3.21, 3.19, 3.0].map(|time| axis.snapped(time)), [3.2, 3.2, 3.0]);
        // 50 points a second: a tick for each 5 frames, and a number for each 2 seconds.
        assert_eq!(axis.steps(), [0.2, 2.0]);
        let near = Axis { range: [0.0, 1.0], ..axis };
        assert_eq!(near.steps(), [0.04, 0.2]);
    }

    #[test]
    fn a_time_that_snaps_to_a_frame_is_in_that_frame() {
        for fps in [24.0, 25.0, 30.0, 60.0] {
            let axis = Axis { left: 0.0, width: 500.0, range: [0.0, 10.0], fps };
            for number in 0..200 {
                let number = f64::from(number);
                assert_eq!(frame(axis.snapped((number + 0.2) / fps), fps), number, "{fps} frames per second");
                assert_eq!(frame((number + 0.9) / fps, fps), number, "{fps} frames per second");
            }
        }
    }
}
