//! The brush that paints the groom.

use super::context::Pass;
use super::settings;
use super::widgets::{color, field, named, number, switch};
use crate::painting::Painting;
use egui::Ui;
use hypertexture::scene::{Color, linear_to_srgb, srgb_to_linear};
use hypertexture::shape::BrushKind;

/// Kinds of the brush, its size, strength and color.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, painting: &mut Painting) {
    ui.horizontal_wrapped(|ui| {
        for (kind, name, doc) in BrushKind::ALL {
            let is_on = painting.is_on && painting.brush.kind == kind;
            let response = ui.selectable_label(is_on, name).on_hover_text(doc);
            if named(ui, &response, &format!("brush.{name}")).clicked() {
                (painting.is_on, painting.brush.kind) = (!is_on, kind);
            }
        }
    });
    let (brush, mut touch) = (&mut painting.brush, None);
    let doc = "Radius of the brush, object units; the wheel over the picture changes it.";
    number(ui, &mut touch, &field("brush.radius", doc), &mut brush.radius, 0.02..=1.0);
    let doc = "Part of the full effect of a touch; [ and ] change it.";
    number(ui, &mut touch, &field("brush.strength", doc), &mut brush.strength, 0.0..=1.0);
    if brush.kind == BrushKind::Color {
        let mut picked = Color(brush.color.map(|channel| (255.0 * linear_to_srgb(channel)).round() as u8));
        color(ui, &mut touch, &field("brush.color", "Painted color."), &mut picked);
        brush.color = picked.0.map(|code| srgb_to_linear(f32::from(code) / 255.0));
    }
    let doc = "Paint on both sides of the plane x = 0.";
    switch(ui, &mut touch, &field("brush.mirrored", doc), &mut brush.mirrored);
    brush.radius = brush.radius.clamp(0.01, 2.0);
    brush.strength = brush.strength.clamp(0.0, 1.0);
    settings::show(ui, pass, "", "groom");
}
