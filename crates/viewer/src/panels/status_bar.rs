//! The status bar below the picture, and the list of facts about its rendering.

use super::status::Status;
use egui::{Align, Color32, Label, Layout, ProgressBar, RichText, Sense, Stroke, Ui, Vec2};

/// Minimal width for device, times and help, points.
const WIDE: f32 = 760.0;
/// Mean step of 8 bits between the codes 64 and 192, linear light.
const STEP: f64 = 0.0037;
/// Largest error of each meaning, in such steps.
const MEANINGS: [(f64, &str); 4] =
    [(0.5, "not visible"), (2.0, "hardly visible"), (8.0, "visible up close"), (f64::INFINITY, "clearly visible")];

/// The status bar: stage, error with its meaning, and time.
pub(super) fn show(ui: &mut Ui, status: &Status) {
    let is_wide = ui.available_width() >= WIDE;
    ui.horizontal(|ui| {
        ui.strong(&status.picture).on_hover_text(&status.detail);
        if let Some([error, spread]) = status.error {
            let line = format!("error {}, {}", plain(error), meaning(error));
            let doc = format!(
                "{} \u{b1} {}: root mean square difference from the converged picture, linear light. A step of 8 bits is about \
                 {STEP} in the mid tones.",
                plain(error),
                plain(spread)
            );
            ui.label(line).on_hover_text(doc);
        }
        if let Some([ms, spread]) = status.frame_ms {
            let doc = format!("Time of the last picture on the device, \u{b1} {spread:.1} ms.");
            ui.label(time(ms)).on_hover_text(doc);
        }
        if let Some(progress) = status.progress {
            ui.add(ProgressBar::new(progress).desired_width(if is_wide { 160.0 } else { 60.0 }).show_percentage());
        }
        if !status.ignored.is_empty() {
            let line = format!("ignored: {}", status.ignored.join(", "));
            let doc = format!("{line}: no effect on the picture.");
            ui.add(Label::new(RichText::new(line).weak()).truncate()).on_hover_text(doc);
        }
        if is_wide {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.weak("? keys");
                if !status.recent_ms.is_empty() {
                    plot(ui, &status.recent_ms, status.budget_ms);
                }
                ui.add(Label::new(RichText::new(&status.device).weak()).truncate());
            });
        }
    });
}

/// Visibility of an error.
fn meaning(error: f64) -> &'static str {
    let steps = error / STEP;
    MEANINGS.iter().find(|(most, _)| steps <= *most).map_or("unknown", |(_, words)| words)
}

/// A small number with two significant digits.
fn plain(value: f64) -> String {
    match value {
        value if value > 0.0 && value < 1e-4 => format!("{value:.1e}"),
        value => {
            let places = (1.0 - value.abs().max(1e-4).log10().floor()).clamp(0.0, 5.0) as usize;
            format!("{value:.places$}")
        }
    }
}

/// A duration.
fn time(ms: f64) -> String {
    match ms {
        ms if ms < 10.0 => format!("{ms:.1} ms"),
        ms if ms < 1000.0 => format!("{ms:.0} ms"),
        ms => format!("{:.1} s", ms / 1000.0),
    }
}

/// The list of facts about the rendering.
pub(super) fn made(ui: &mut Ui, lines: &[[String; 2]]) {
    egui::Grid::new("made").num_columns(2).striped(true).show(ui, |ui| {
        for [about, what] in lines {
            ui.label(RichText::new(about).weak());
            ui.add(Label::new(RichText::new(what).monospace()).wrap());
            ui.end_row();
        }
    });
}

/// A plot of the times of the last previews, with the budget as a line.
fn plot(ui: &mut Ui, recent_ms: &[f64], budget_ms: f64) {
    let (response, painter) = ui.allocate_painter(Vec2::new(120.0, 18.0), Sense::hover());
    let (rect, visuals) = (response.rect, ui.visuals());
    painter.rect_filled(rect, 2.0, visuals.extreme_bg_color);
    let top = (2.0 * budget_ms).max(1e-3);
    let y = |ms: f64| rect.bottom() - rect.height() * (ms / top).min(1.0) as f32;
    painter.hline(rect.x_range(), y(budget_ms), Stroke::new(1.0, visuals.weak_text_color()));
    for (index, ms) in recent_ms.iter().rev().take(60).enumerate() {
        let x = rect.right() - 2.0 * index as f32 - 1.0;
        let color: Color32 = if *ms <= budget_ms { visuals.hyperlink_color } else { visuals.warn_fg_color };
        painter.vline(x, y(*ms)..=rect.bottom(), Stroke::new(1.5, color));
    }
    response.on_hover_text(format!("time of the last previews on the device; the line marks {budget_ms:.0} ms"));
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::scene::Color;

    /// Light of a gray code, as pictures are written.
    fn light(code: u8) -> f64 {
        f64::from(Color([code; 3]).linear()[0])
    }

    #[test]
    fn an_error_is_told_in_steps_that_a_picture_can_have() {
        let mean = (light(192) - light(64)) / 128.0;
        assert!((mean - STEP).abs() < 1e-4, "{mean}");
        assert_eq!(
            [1e-3, 4e-3, 1e-2, 0.2].map(meaning),
            ["not visible", "hardly visible", "visible up close", "clearly visible"]
        );
    }

    #[test]
    fn numbers_have_two_digits_that_count() {
        assert_eq!([0.0021, 0.034, 0.12, 1.5, 3e-5].map(plain), ["0.0021", "0.034", "0.12", "1.5", "3.0e-5"]);
        assert_eq!([1.26, 34.4, 1358.0].map(time), ["1.3 ms", "34 ms", "1.4 s"]);
    }
}
