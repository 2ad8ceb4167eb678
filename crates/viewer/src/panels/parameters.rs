//! Parameters of modules, as sliders and colors.

use super::context::{Pass, own, prefix};
use super::widgets::{self, color, field, number};
use egui::{Button, RichText, Ui};
use hypertexture::scene::ParameterValue;
use hypertexture::shader::ParameterKind;

/// The parameters of an object.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>) {
    let (model, declared) = (pass.model, pass.model.parameters(part));
    if declared.iter().next().is_none() {
        ui.label(RichText::new("the modules of this effect have no parameters").weak());
    }
    let values = own(&mut pass.draft, part).parameters;
    for (parameter, value) in declared.iter() {
        let name = format!("{}parameters.{}", prefix(part), parameter.name);
        let field = field(&name, &parameter.doc);
        let mut new = value.clone();
        ui.horizontal(|ui| {
            match (parameter.kind, &mut new) {
                (ParameterKind::Number(_, [low, high]), ParameterValue::Number(value)) => {
                    number(ui, &mut pass.touch, &field, value, low..=high);
                }
                (_, ParameterValue::Color(value)) => color(ui, &mut pass.touch, &field, value),
                _ => {}
            }
            let default = model.parameter_in_preset(part, parameter);
            let reset = ui.add_enabled(*value != default, Button::new("⟲").small());
            let shown = match &default {
                ParameterValue::Number(value) => value.to_string(),
                ParameterValue::Color(color) => String::from(*color),
            };
            if widgets::named(ui, &reset, &format!("{name}.reset"))
                .on_hover_text(format!("Reset to {shown}, the value of the preset."))
                .clicked()
            {
                new = default;
                pass.touch = Some(name.clone());
            }
        });
        if new != *value {
            values.insert(parameter.name.clone(), new);
        }
    }
}
