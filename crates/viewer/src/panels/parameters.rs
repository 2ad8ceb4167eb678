//! Parameters of modules, as sliders and colors.

use super::context::{Pass, object_fields, prefix};
use super::field_menu::{Of, with_menu};
use super::keyframes::diamond;
use super::widgets::{self, Field, color, field, number, short};
use egui::{Button, RichText, Ui};
use hypertexture::scene::schema::Unit;
use hypertexture::scene::{LOOP_SECONDS, ParameterValue};
use hypertexture::shader::ParameterKind;
use toml::Value;

/// Units as descriptions of parameters name them: the header of a module has no other place for them.
const UNITS: [(&str, Unit); 3] =
    [("degrees", Unit::Degrees), ("seconds", Unit::Seconds), ("object units", Unit::ObjectUnits)];

/// Symbol of the unit of a parameter: the unit follows a comma, or begins the description as in `Seconds after which`.
fn unit(doc: &str) -> &'static str {
    let sentence = doc.to_lowercase();
    let follows = |word: &str| [", ", "; ", "in "].iter().any(|before| sentence.contains(&format!("{before}{word}")));
    let is_named = |(word, _): &&(&str, Unit)| sentence.starts_with(word) || follows(word);
    UNITS.iter().find(is_named).map_or("", |(_, unit)| unit.symbol())
}

/// The parameters of an object.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>) {
    let (model, declared) = (pass.model, pass.model.parameters(part));
    if declared.iter().next().is_none() {
        ui.label(RichText::new("the modules of this effect have no parameters").weak());
    }
    for (parameter, value) in declared.iter().filter(|(parameter, _)| parameter.name != LOOP_SECONDS) {
        let name = format!("{}parameters.{}", prefix(part), parameter.name);
        let field = Field { unit: unit(&parameter.doc), ..field(&name, &parameter.doc) };
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
            object_fields(&mut pass.draft, part).parameters.insert(parameter.name.clone(), new);
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
