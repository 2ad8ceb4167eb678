//! The knobs of a scene: what its modules declare, and what the scene says.

use super::check::within;
use super::{KnobValue, Scene, SceneError};
use crate::glsl::Declarations;
use crate::glsl::library::{Default, Knob};

/// The declared parameters of a scene's modules with the values that the scene gives them.
#[derive(Clone, Debug, PartialEq)]
pub struct Knobs {
    declared: Vec<(Knob, KnobValue)>,
    outer: Option<String>,
    reach: Vec<String>,
}

impl Knobs {
    /// Every knob with its value, in the order of the modules.
    pub fn iter(&self) -> impl Iterator<Item = (&Knob, &KnobValue)> {
        self.declared.iter().map(|(knob, value)| (knob, value))
    }

    /// Signed distance at which the soft region starts, if a module says so; object units.
    pub fn outer_iso(&self) -> Option<f32> {
        self.outer.as_deref().map(|name| self.number(name))
    }

    /// How far matter reaches beyond the soft region, object units.
    pub fn reach(&self) -> f32 {
        self.reach.iter().map(|name| self.number(name)).sum()
    }

    fn number(&self, name: &str) -> f32 {
        let found = self.declared.iter().find(|(knob, _)| knob.name == name);
        match found.map(|(_, value)| value) {
            Some(KnobValue::Number(value)) => *value,
            _ => 0.0,
        }
    }
}

impl Scene {
    pub(super) fn knobs(&self, declarations: &Declarations) -> Result<Knobs, SceneError> {
        let known: Vec<&str> = declarations.knobs.iter().map(|knob| knob.name.as_str()).collect();
        if let Some(name) = self.knobs.keys().find(|name| !known.contains(&name.as_str())) {
            return Err(SceneError::unknown("knob", name, &known));
        }
        let mut declared = Vec::new();
        for knob in &declarations.knobs {
            let value = match (knob.default, self.knobs.get(&knob.name)) {
                (Default::Number(default, _), None) => KnobValue::Number(default),
                (Default::Color(default), None) => KnobValue::Color(super::Color(default)),
                (Default::Number(_, [low, high]), Some(KnobValue::Number(value))) => {
                    within(&format!("knobs.{}", knob.name), *value, low, high)?;
                    KnobValue::Number(*value)
                }
                (Default::Color(_), Some(KnobValue::Color(color))) => KnobValue::Color(*color),
                (default, Some(value)) => {
                    let limit = match default {
                        Default::Number(_, [low, high]) => format!("must be a number from {low} to {high}"),
                        Default::Color(_) => "must be a color, #rrggbb".into(),
                    };
                    let value = match value {
                        KnobValue::Number(value) => value.to_string(),
                        KnobValue::Color(color) => String::from(*color),
                    };
                    return Err(SceneError::Value { field: format!("knobs.{}", knob.name), value, limit });
                }
            };
            declared.push((knob.clone(), value));
        }
        Ok(Knobs { declared, outer: declarations.outer.clone(), reach: declarations.reach.clone() })
    }
}
