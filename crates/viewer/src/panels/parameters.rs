//! Parameters of modules, as sliders and colors.

use super::context::{Pass, own, prefix};
use super::field_menu::{Of, with_menu};
use super::keyframes::diamond;
use super::widgets::{self, color, field, number, short};
use egui::{Button, RichText, Ui};
use hypertexture::scene::{LOOP_SECONDS, ParameterValue};
use hypertexture::shader::ParameterKind;
use toml::Value;

/// The parameters of an object.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>) {
    let (model, declared) = (pass.model, pass.model.parameters(part));
    if declared.iter().next().is_none() {
        ui.label(RichText::new("the modules of this effect have no parameters").weak());
    }
    for (parameter, value) in declared.iter().filter(|(parameter, _)| parameter.name != LOOP_SECONDS) {
        let name = format!("{}parameters.{}", prefix(part), parameter.name);
        let field = field(&name, &parameter.doc);
        let mut new = value.clone();
        let now = written(value);
        let home = || Some(written(&model.parameter_in_preset(part, parameter)));
        let of = Of { name: &name, value: Some(now.clone()), home: &home };
        let mut row = |ui: &mut Ui, pass: &mut Pass<'_>| {
            diamond(ui, pass, &name, Some(&now));
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
                ParameterValue::Number(value) => short(f64::from(*value)),
                ParameterValue::Color(color) => String::from(*color),
            };
            if widgets::named(ui, &reset, &format!("{name}.reset"))
                .on_hover_text(format!("Reset to {shown}, the value of the preset."))
                .clicked()
            {
                new = default;
                pass.touch = Some(name.clone());
            }
        };
        with_menu(ui, pass, &of, |ui, pass| drop(ui.horizontal(|ui| row(ui, pass))));
        if new != *value {
            own(&mut pass.draft, part).parameters.insert(parameter.name.clone(), new);
        }
    }
}

/// A value as a scene file has it.
fn written(value: &ParameterValue) -> Value {
    match value {
        ParameterValue::Number(number) => Value::Float(f64::from(*number)),
        ParameterValue::Color(color) => String::from(*color).into(),
    }
}
