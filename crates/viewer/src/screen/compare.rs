//! Comparison of two variants: with a movable divider, by their difference, or one at a time.

use crate::panels::widgets::named;
use egui::{Align2, Area, Color32, CursorIcon, FontId, Frame, Id, Rect, Sense, Slider, Stroke, Ui, Vec2, pos2, vec2};

/// Display mode of a comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CompareMode {
    /// The pinned variant left of a divider, the edited one right of it.
    #[default]
    Wipe,
    /// The amplified difference.
    Difference,
    /// The edited variant.
    Now,
    /// The pinned variant.
    Kept,
}

/// Display modes with label and tooltip.
const MODES: [(CompareMode, &str, &str); 4] = [
    (CompareMode::Wipe, "wipe", "The pinned variant left of a divider, the edited one right of it."),
    (
        CompareMode::Difference,
        "difference",
        "The absolute difference in linear light, or of the opacity if that is larger, times the gain.",
    ),
    (CompareMode::Now, "now", "The edited variant."),
    (CompareMode::Kept, "kept", "The pinned variant."),
];
/// Width of the divider for the pointer, points.
const GRIP: f32 = 12.0;

/// State of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// How the pictures are shown.
    pub mode: CompareMode,
    /// Position of the divider, from 0 at the left to 1 at the right.
    pub at: f32,
    /// Amplification of the difference.
    pub gain: f32,
}

impl Default for Comparison {
    fn default() -> Comparison {
        Comparison { mode: CompareMode::Wipe, at: 0.5, gain: 8.0 }
    }
}

impl Comparison {
    /// Selects the next display mode.
    pub fn next(&mut self) {
        let here = MODES.iter().position(|(mode, ..)| *mode == self.mode).unwrap_or_default();
        self.mode = MODES[(here + 1) % MODES.len()].0;
    }

    /// Shows the divider, the titles `now` and `kept`, and the controls over the pictures in `place`. `rms` is the
    /// difference of equally sampled pictures.
    pub fn show(&mut self, ui: &mut Ui, place: Rect, [now, kept]: &[String; 2], rms: Option<f64>) {
        if self.mode == CompareMode::Wipe {
            self.line(ui, place);
        }
        let shows = |mode: CompareMode| self.mode == mode || self.mode == CompareMode::Wipe;
        if shows(CompareMode::Kept) {
            title(ui, place, Align2::LEFT_BOTTOM, kept);
        }
        if shows(CompareMode::Now) {
            title(ui, place, Align2::RIGHT_BOTTOM, now);
        }
        let frame = Frame::popup(ui.style());
        Area::new(Id::new("compare")).fixed_pos(place.left_top() + Vec2::splat(10.0)).show(ui.ctx(), |ui| {
            frame.show(ui, |ui| {
                ui.set_max_width((place.width() - 40.0).max(120.0));
                ui.horizontal_wrapped(|ui| self.bar(ui, rms));
            });
        });
    }

    fn bar(&mut self, ui: &mut Ui, rms: Option<f64>) {
        for (mode, text, doc) in MODES {
            let response = ui.selectable_value(&mut self.mode, mode, text).on_hover_text(doc);
            named(ui, &response, &format!("compare.{text}"));
        }
        match self.mode {
            CompareMode::Wipe => {
                let response = ui.add(Slider::new(&mut self.at, 0.0..=1.0).show_value(false).text("line"));
                named(ui, &response, "compare.at")
                    .on_hover_text("Position of the divider; drag it, or use the arrow keys.");
            }
            CompareMode::Difference => {
                let response = ui.add(Slider::new(&mut self.gain, 1.0..=1024.0).logarithmic(true).text("gain"));
                named(ui, &response, "compare.gain").on_hover_text("Amplification of the difference.");
            }
            CompareMode::Now | CompareMode::Kept => {}
        }
        let text = match rms {
            Some(rms) => format!("RMS {rms:.1e}"),
            None => "RMS: not equally sampled yet".into(),
        };
        ui.label(text).on_hover_text(
            "Root mean square of the difference over all channels, linear light; only of two pictures with the same number of samples.",
        );
    }

    /// The movable divider.
    fn line(&mut self, ui: &Ui, place: Rect) {
        let x = egui::lerp(place.x_range(), self.at);
        let grip = Rect::from_center_size(pos2(x, place.center().y), vec2(GRIP, place.height()));
        let response =
            ui.interact(grip, Id::new("compare.line"), Sense::drag()).on_hover_cursor(CursorIcon::ResizeHorizontal);
        if let Some(pos) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            self.at = ((pos.x - place.left()) / place.width().max(1.0)).clamp(0.0, 1.0);
        }
        let x = egui::lerp(place.x_range(), self.at);
        let painter = ui.painter_at(place);
        let held = response.hovered() || response.dragged();
        painter.vline(x, place.y_range(), Stroke::new(3.0, Color32::from_black_alpha(160)));
        painter.vline(x, place.y_range(), Stroke::new(if held { 2.0 } else { 1.0 }, Color32::WHITE));
        painter.circle(pos2(x, place.center().y), 5.0, Color32::WHITE, Stroke::new(1.0, Color32::BLACK));
    }
}

/// The title of a variant.
fn title(ui: &Ui, place: Rect, corner: Align2, text: &str) {
    let painter = ui.painter_at(place);
    let galley = painter.layout_no_wrap(text.into(), FontId::proportional(13.0), Color32::WHITE);
    let rect = corner.anchor_size(corner.pos_in_rect(&place.shrink(10.0)), galley.size());
    painter.rect_filled(rect.expand(4.0), 3.0, Color32::from_black_alpha(190));
    painter.galley(rect.min, galley, Color32::WHITE);
}
