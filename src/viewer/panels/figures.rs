//! The line of figures below the picture.

use super::Status;
use crate::viewer::model::Model;
use egui::{Align, Color32, Label, Layout, ProgressBar, RichText, Sense, Stroke, Ui, Vec2};

/// Color of the last thing that went wrong or was done.
const MESSAGE: Color32 = Color32::from_rgb(236, 196, 120);

/// What goes wrong or was done, and below it what is known of the picture.
///
/// The first line is there when it is empty too: the picture keeps its size when something is said.
pub(super) fn show(ui: &mut Ui, model: &Model, status: &Status, complaint: Option<String>) {
    ui.horizontal(|ui| {
        let message = complaint.as_deref().or(model.message()).or(status.message.as_deref()).unwrap_or(" ");
        ui.add(Label::new(RichText::new(message).color(MESSAGE)).truncate()).on_hover_text(message);
        if !status.ignored.is_empty() {
            let line = format!("ignored: {}", status.ignored.join(", "));
            let doc = format!("{line}: the picture is the same without.");
            ui.add(Label::new(RichText::new(line).weak()).truncate()).on_hover_text(doc);
        }
    });
    ui.horizontal(|ui| {
        if !status.recent_ms.is_empty() {
            plot(ui, &status.recent_ms, status.budget_ms);
        }
        let mut parts = Vec::new();
        parts.extend(status.frame_ms.map(|[ms, spread]| match spread > 0.0 {
            true => format!("{ms:.1} ± {spread:.1} ms"),
            false => format!("{ms:.0} ms"),
        }));
        parts.extend(status.error.map(|[error, spread]| format!("error {error:.1e} ± {spread:.0e}")));
        parts.extend([&status.samples].into_iter().filter(|text| !text.is_empty()).cloned());
        ui.label(RichText::new(parts.join("   ")).monospace());
        if let Some(progress) = status.progress {
            ui.add(ProgressBar::new(progress).desired_width(160.0).show_percentage());
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.label(RichText::new("? keys").weak());
            ui.add(Label::new(RichText::new(&status.device).weak()).truncate());
        });
    });
}

/// What the picture was made with.
pub(super) fn made(ui: &mut Ui, lines: &[[String; 2]]) {
    egui::Grid::new("made").num_columns(2).striped(true).show(ui, |ui| {
        for [about, what] in lines {
            ui.label(RichText::new(about).weak());
            ui.add(Label::new(RichText::new(what).monospace()).wrap());
            ui.end_row();
        }
    });
}

/// The times of the last pictures; the line is what they may take while the scene moves.
fn plot(ui: &mut Ui, recent_ms: &[f64], budget_ms: f64) {
    let (response, painter) = ui.allocate_painter(Vec2::new(120.0, 18.0), Sense::hover());
    let rect = response.rect;
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let top = (2.0 * budget_ms).max(1e-3);
    let y = |ms: f64| rect.bottom() - rect.height() * (ms / top).min(1.0) as f32;
    painter.hline(rect.x_range(), y(budget_ms), Stroke::new(1.0, Color32::from_gray(70)));
    for (index, ms) in recent_ms.iter().rev().take(60).enumerate() {
        let x = rect.right() - 2.0 * index as f32 - 1.0;
        let color = if *ms <= budget_ms { Color32::from_rgb(110, 170, 230) } else { Color32::from_rgb(220, 150, 80) };
        painter.vline(x, y(*ms)..=rect.bottom(), Stroke::new(1.5, color));
    }
    response.on_hover_text(format!("milliseconds on the device of the last pictures; the line: {budget_ms:.0} ms"));
}
