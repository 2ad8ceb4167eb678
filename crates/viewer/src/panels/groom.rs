//! The brush that paints the groom.

use super::context::Pass;
use super::settings;
use super::widgets::{Field, button, color, field, named, number, switch};
use crate::document::painting::{Painting, SEVERAL};
use egui::{DragValue, Label, RichText, Ui};
use hypertexture::scene::schema::Unit;
use hypertexture::scene::{Color, linear_to_srgb, srgb_to_linear};
use hypertexture::shape::BrushKind;
use std::ops::RangeInclusive;

/// The kinds of the brush as buttons, whose accessible names begin with `prefix`.
fn kinds(ui: &mut Ui, painting: &mut Painting, prefix: &str) {
    for (kind, name, doc) in BrushKind::ALL {
        let is_on = painting.is_on && painting.brush.kind == kind;
        let response = ui.selectable_label(is_on, name).on_hover_text(doc);
        if named(ui, &response, &format!("{prefix}.{name}")).clicked() {
            (painting.is_on, painting.brush.kind) = (!is_on, kind);
        }
    }
}

/// The brush over the picture: kind, size and strength.
pub(crate) fn bar(ui: &mut Ui, painting: &mut Painting) {
    ui.horizontal_wrapped(|ui| {
        kinds(ui, painting, "bar");
        ui.separator();
        let brush = &mut painting.brush;
        let part = |ui: &mut Ui, value: &mut f32, text: &str, range: RangeInclusive<f32>, doc: &str| {
            let drag = DragValue::new(value).range(range).speed(0.005).prefix(format!("{text} ")).max_decimals(2);
            let response = ui.add(drag).on_hover_text(doc);
            named(ui, &response, &format!("bar {text}"));
        };
        part(ui, &mut brush.radius, "radius", 0.02..=1.0, "Radius of the brush, object units (wheel).");
        part(ui, &mut brush.strength, "strength", 0.02..=1.0, "Part of the full effect of a touch ([ and ]).");
        if button(ui, "done", "bar done", "Stop painting (B).").clicked() {
            painting.is_on = false;
        }
    });
}

/// Kinds of the brush, its size, strength and color; a scene of several objects has no groom.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, painting: &mut Painting) {
    if pass.model.scene().has_several() {
        painting.is_on = false;
        ui.add(Label::new(RichText::new(SEVERAL).weak()).wrap());
        return drop(ui.add_enabled_ui(false, |ui| controls(ui, pass, painting)));
    }
    controls(ui, pass, painting);
}

fn controls(ui: &mut Ui, pass: &mut Pass<'_>, painting: &mut Painting) {
    ui.horizontal_wrapped(|ui| kinds(ui, painting, "brush"));
    let (brush, mut touch) = (&mut painting.brush, None);
    let doc = "Radius of the brush, object units; the wheel over the picture changes it.";
    let radius = Field { unit: Unit::ObjectUnits.symbol(), ..field("brush.radius", doc) };
    number(ui, &mut touch, &radius, &mut brush.radius, 0.02..=1.0);
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
