//! The parameters that the modules declare: each a slider with its range, or a color.

use super::widgets::{self, color, field, number};
use super::{Pass, own, prefix};
use crate::glsl::declare::Default as KnobDefault;
use crate::scene::{Color, KnobValue};
use egui::{Button, RichText, Ui};

/// Every knob of an object.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>) {
    let declared = pass.model.knobs(part);
    if declared.iter().next().is_none() {
        ui.label(RichText::new("the modules of this effect declare none").weak());
    }
    let values = own(&mut pass.draft, part).knobs;
    for (knob, value) in declared.iter() {
        let name = format!("{}knobs.{}", prefix(part), knob.name);
        let field = field(&name, &knob.doc);
        let mut new = value.clone();
        ui.horizontal(|ui| {
            match (knob.default, &mut new) {
                (KnobDefault::Number(_, [low, high]), KnobValue::Number(value)) => {
                    number(ui, &mut pass.touch, &field, value, low..=high);
                }
                (_, KnobValue::Color(value)) => color(ui, &mut pass.touch, &field, value),
                _ => {}
            }
            let default = match knob.default {
                KnobDefault::Number(value, _) => KnobValue::Number(value),
                KnobDefault::Color(code) => KnobValue::Color(Color(code)),
            };
            let reset = ui.add_enabled(*value != default, Button::new("⟲").small());
            let shown = match &default {
                KnobValue::Number(value) => value.to_string(),
                KnobValue::Color(color) => String::from(*color),
            };
            if widgets::named(ui, &reset, &format!("{name}.reset")).on_hover_text(format!("Back to {shown}.")).clicked()
            {
                new = default;
                pass.touch = Some(name.clone());
            }
        });
        if new != *value {
            values.insert(knob.name.clone(), new);
        }
    }
}
