//! The parameters of a scene: what its modules declare, and what the scene says.

use super::check::within;
use super::{ParameterValue, Scene, SceneError};
use crate::shader::declare::{Parameter, ParameterKind};
use crate::shader::drift::Drift;
use crate::shader::reach::{GIVEN, NOISE_BOUND};
use crate::shader::{Declarations, Reach, Sides};

/// The declared parameters of a scene's modules with the values that the scene gives them.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    declared: Vec<(Parameter, ParameterValue)>,
    outer: Vec<String>,
    reach: Vec<Reach>,
    drifts: Vec<Drift>,
    noise_bound: f32,
}

/// How far the modules of an object move lookups, and how far its matter grows by that; units of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// How far matter grows beyond the soft region.
    pub grows: Sides,
    /// How far a lookup moves.
    pub moves: Sides,
    /// Radius beyond which a step along the radius stays as long as it is there.
    pub hold_radius: f32,
    /// Whether there may be matter beyond it: lobes are shorter than the formula of the warp has them.
    pub held: bool,
}

/// Steps along the radius are held so that matter gets this many times as far as the soft region alone. Larger: the
/// slices lie so far apart that the picture is coarse.
const MOST_GROWTH: f32 = 2.25;
/// But not within this many radii, so that the object itself is what the formula says.
const LEAST_HOLD: f32 = 1.1547005;

impl Parameters {
    /// Every parameter with its value, in the order of the modules.
    pub fn iter(&self) -> impl Iterator<Item = (&Parameter, &ParameterValue)> {
        self.declared.iter().map(|(parameter, value)| (parameter, value))
    }

    /// Signed distance at which the soft region starts, if a module says so: of several, that of the widest; object units.
    pub fn outer_iso(&self) -> Option<f32> {
        self.outer.iter().map(|name| self.number(name)).reduce(f32::max)
    }

    /// The parameters that say so.
    pub fn outer(&self) -> &[String] {
        &self.outer
    }

    /// How far lookups move and matter grows, around a soft region of this radius.
    ///
    /// A step along the radius that shortens it by up to a part k, from x to x (1 - k), brings matter of radius r from
    /// r / (1 - k): from there on it may be held, and where that is too far, earlier.
    pub fn spread(&self, radius: f32) -> Spread {
        type Of = fn(&Reach, &dyn Fn(&str) -> f32) -> Sides;
        let all = |hold: f32, of: Of| {
            let given = [hold, self.noise_bound];
            let value = |name: &str| {
                GIVEN.iter().zip(given).find(|(given, _)| **given == name).map_or_else(|| self.number(name), |(_, v)| v)
            };
            self.reach.iter().map(|reach| of(reach, &value)).fold(Sides::default(), Sides::plus)
        };
        let bare = all(0.0, Reach::grows);
        let start = radius + bare.farthest();
        let part = all(1.0, Reach::grows).round - bare.round;
        let whole = if part < 1.0 { start / (1.0 - part) } else { f32::INFINITY };
        let room = if part > 0.0 { (MOST_GROWTH - 1.0) / part } else { f32::INFINITY };
        let hold_radius = whole.min(start * room.max(LEAST_HOLD));
        let [grows, moves] = [Reach::grows, Reach::moves].map(|of| all(hold_radius, of));
        Spread { grows, moves, hold_radius, held: hold_radius < whole }
    }

    /// Speeds that have another value at a time (seconds), so that far places are told as well as near ones; see
    /// [`crate::shader::drift`].
    pub fn held_speeds(&self, time: f64) -> impl Iterator<Item = (&str, f32)> {
        self.drifts
            .iter()
            .filter_map(move |drift| Some((drift.speed.as_str(), drift.wrapped(time, |name| self.number(name))?)))
    }

    /// The value of a parameter that is one number; 0 for any other.
    pub fn number(&self, name: &str) -> f32 {
        let found = self.declared.iter().find(|(parameter, _)| parameter.name == name);
        match found.map(|(_, value)| value) {
            Some(ParameterValue::Number(value)) => *value,
            _ => 0.0,
        }
    }
}

impl Scene {
    pub(super) fn parameters(&self, declarations: &Declarations) -> Result<Parameters, SceneError> {
        let known: Vec<&str> = declarations.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
        if let Some(name) = self.parameters.keys().find(|name| !known.contains(&name.as_str())) {
            return Err(SceneError::unknown("parameter", name, &known));
        }
        let mut declared = Vec::new();
        for parameter in &declarations.parameters {
            let value = match (parameter.kind, self.parameters.get(&parameter.name)) {
                (ParameterKind::Number(default, _), None) => ParameterValue::Number(default),
                (ParameterKind::Color(default), None) => ParameterValue::Color(super::Color(default)),
                (ParameterKind::Number(_, [low, high]), Some(ParameterValue::Number(value))) => {
                    within(&format!("parameters.{}", parameter.name), *value, low, high)?;
                    ParameterValue::Number(*value)
                }
                (ParameterKind::Color(_), Some(ParameterValue::Color(color))) => ParameterValue::Color(*color),
                (default, Some(value)) => {
                    let limit = match default {
                        ParameterKind::Number(_, [low, high]) => format!("must be a number from {low} to {high}"),
                        ParameterKind::Color(_) => "must be a color, #rrggbb".into(),
                    };
                    let value = match value {
                        ParameterValue::Number(value) => value.to_string(),
                        ParameterValue::Color(color) => String::from(*color),
                    };
                    return Err(SceneError::Value { field: format!("parameters.{}", parameter.name), value, limit });
                }
            };
            declared.push((parameter.clone(), value));
        }
        let noise_bound = declarations.noise_bound.unwrap_or(NOISE_BOUND);
        let (outer, reach) = (declarations.outer.clone(), declarations.reach.clone());
        let drifts = declarations.drifts.clone();
        Ok(Parameters { declared, outer, reach, drifts, noise_bound })
    }
}
