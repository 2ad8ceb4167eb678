//! Diagrams of a lesson.

use crate::panels::widgets::named;
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};
use std::ops::RangeInclusive;

/// Size of the labels, points: legible from the back of a room.
const LABEL: f32 = 13.5;

/// A diagram: a rectangle with a range of values on each axis.
pub(super) struct Plot {
    pub(super) painter: Painter,
    inner: Rect,
    x: [f64; 2],
    y: [f64; 2],
    text: Color32,
}

impl Plot {
    /// Allocates a diagram of `width` and `height` points.
    pub(super) fn new(
        ui: &mut Ui,
        name: &str,
        [width, height]: [f32; 2],
        x: RangeInclusive<f64>,
        y: RangeInclusive<f64>,
    ) -> Plot {
        let (rect, response) = ui.allocate_exact_size(vec2(width, height), Sense::hover());
        named(ui, &response, name);
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
        let [x, y] = [x, y].map(|range| [*range.start(), *range.end()]);
        Plot { painter, inner: rect.shrink2(vec2(6.0, LABEL + 5.0)), x, y, text: ui.visuals().text_color() }
    }

    /// The position of a pair of values.
    pub(super) fn at(&self, x: f64, y: f64) -> Pos2 {
        let part = |value: f64, [low, high]: [f64; 2]| ((value - low) / (high - low).max(1e-9)).clamp(0.0, 1.0) as f32;
        let (x, y) = (part(x, self.x), part(y, self.y));
        pos2(egui::lerp(self.inner.x_range(), x), egui::lerp(self.inner.bottom()..=self.inner.top(), y))
    }

    /// A curve through points.
    pub(super) fn curve(&self, points: impl Iterator<Item = (f64, f64)>, width: f32, color: Color32) {
        let line = points.map(|(x, y)| self.at(x, y)).collect();
        self.painter.add(Shape::line(line, Stroke::new(width, color)));
    }

    /// A vertical bar from the lowest value up to `y`.
    pub(super) fn bar(&self, x: f64, y: f64, width: f32, color: Color32) {
        let top = self.at(x, y);
        self.painter.vline(top.x, top.y..=self.inner.bottom(), Stroke::new(width, color));
    }

    /// Text at the upper left, the lower left and the lower right corner.
    pub(super) fn label(&self, [title, left, right]: [&str; 3]) {
        let rect = self.painter.clip_rect();
        let text = |corner: Align2, at: Pos2, text: &str| {
            self.painter.text(at, corner, text, FontId::proportional(LABEL), self.text);
        };
        text(Align2::LEFT_TOP, rect.left_top() + vec2(4.0, 1.0), title);
        text(Align2::LEFT_BOTTOM, rect.left_bottom() + vec2(4.0, -1.0), left);
        text(Align2::RIGHT_BOTTOM, rect.right_bottom() + vec2(-4.0, -1.0), right);
    }
}
