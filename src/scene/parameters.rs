//! Parameters of a scene: the declarations of its modules with the values of the scene.

use super::rules::check::within;
use super::{Looped, ParameterValue, Scene, SceneError};
use crate::shader::declare::{Parameter, ParameterKind};
use crate::shader::drift::Drift;
use crate::shader::reach::{GIVEN, NOISE_BOUND};
use crate::shader::{Declarations, Reach, Sides};
use std::sync::Arc;

/// Declared parameters with their values in a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    declared: Arc<Declarations>,
    /// The value of each parameter that is declared.
    values: Vec<ParameterValue>,
    looped: Option<Looped>,
}

/// Displacement of lookups by the modules of an object, and the growth of its matter; object units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Growth of matter beyond the soft region.
    pub grows: Sides,
    /// Displacement of a lookup.
    pub moves: Sides,
    /// Radius beyond which displacements along the radius are clamped to their length there.
    pub hold_radius: f32,
    /// Whether matter may lie beyond that radius, so that lobes are shorter than by the formula of the warp.
    pub held: bool,
}

/// Growth factor of the soft region at which displacements along the radius are clamped. Higher: slices are too far apart.
const MAX_GROWTH: f32 = 2.25;
/// Smallest such factor, so that the object itself follows the formula.
const MIN_HOLD: f32 = 1.1547005;

/// The parameter of `glsl/phases/two.glsl` that is the length of the loop.
pub const LOOP_SECONDS: &str = "loop_seconds";
/// The parameter of `glsl/wind/breeze.glsl` that is the time after which it repeats: a whole part of a loop.
const WIND_PERIOD: &str = "wind_period";

impl Parameters {
    /// Every parameter with its value, in the order of the modules.
    pub fn iter(&self) -> impl Iterator<Item = (&Parameter, &ParameterValue)> {
        self.declared.parameters.iter().zip(&self.values)
    }

    /// The declarations of the modules.
    pub(super) fn declared(&self) -> &Declarations {
        &self.declared
    }

    /// Signed distance at which the soft region starts, if a module declares it; the largest of several. Object units.
    pub fn outer_iso(&self) -> Option<f32> {
        self.outer().iter().map(|name| self.number(name)).reduce(f32::max)
    }

    /// Names of the parameters that set it.
    pub fn outer(&self) -> &[String] {
        &self.declared.outer
    }

    /// Displacements and growth around a soft region of this radius.
    ///
    /// A displacement along the radius from x to x (1 - k) moves matter of radius r to r / (1 - k). It is clamped from there
    /// on, or earlier if that is too far. Warps act with at most `strength` times their full effect.
    pub fn spread(&self, radius: f32, strength: f32) -> Spread {
        type Of = fn(&Reach, &dyn Fn(&str) -> f32) -> Sides;
        let all = |hold: f32, of: Of| {
            let given = [hold, self.declared.noise_bound.unwrap_or(NOISE_BOUND)];
            let value = |name: &str| {
                GIVEN.iter().zip(given).find(|(given, _)| **given == name).map_or_else(|| self.number(name), |(_, v)| v)
            };
            let sides = self.declared.reach.iter().map(|reach| of(reach, &value)).fold(Sides::default(), Sides::plus);
            sides.times(strength)
        };
        let bare = all(0.0, Reach::grows);
        let start = radius + bare.farthest();
        let part = all(1.0, Reach::grows).round - bare.round;
        let whole = if part < 1.0 { start / (1.0 - part) } else { f32::INFINITY };
        let room = if part > 0.0 { (MAX_GROWTH - 1.0) / part } else { f32::INFINITY };
        let hold_radius = whole.min(start * room.max(MIN_HOLD));
        let [grows, moves] = [Reach::grows, Reach::moves].map(|of| all(hold_radius, of));
        Spread { grows, moves, hold_radius, held: hold_radius < whole }
    }

    /// Speeds that are adjusted at a time (seconds): to whole periods of noise in a loop, else to preserve precision far from
    /// the origin; see [`crate::shader::drift`].
    pub fn held_speeds(&self, time: f64) -> impl Iterator<Item = (&str, f32)> {
        let value = |name: &str| self.number(name);
        let held = move |drift: &Drift| match &self.looped {
            Some(looped) => looped.speed(drift, value),
            None => drift.wrapped(time, value),
        };
        self.declared.drifts.iter().filter_map(move |drift| Some((drift.speed.as_str(), held(drift)?)))
    }

    /// Length of the loop, and whether noise has two phases in it.
    pub fn looped(&self) -> Option<(f64, bool)> {
        self.looped.map(|looped| (looped.period, looped.two_phases))
    }

    /// The parameters in the loop of a scene, if it has one.
    pub(super) fn in_loop(mut self, looped: Option<Looped>) -> Parameters {
        for (parameter, value) in self.declared.parameters.iter().zip(&mut self.values) {
            let (Some(Looped { period, .. }), ParameterValue::Number(value)) = (&looped, value) else { continue };
            match parameter.name.as_str() {
                LOOP_SECONDS => *value = *period as f32,
                WIND_PERIOD => *value = (period / (period / f64::from(*value)).round().max(1.0)) as f32,
                _ => {}
            }
        }
        Parameters { looped, ..self }
    }

    /// Value of a parameter that is a number; 0 for any other.
    pub fn number(&self, name: &str) -> f32 {
        let found = self.iter().find(|(parameter, _)| parameter.name == name);
        match found.map(|(_, value)| value) {
            Some(ParameterValue::Number(value)) => *value,
            _ => 0.0,
        }
    }
}

impl Scene {
    pub(super) fn parameters(&self, declared: &Arc<Declarations>) -> Result<Parameters, SceneError> {
        if let Some(name) = self.parameters.keys().find(|name| find(declared, name).is_none()) {
            return Err(unknown(declared, name));
        }
        let value = |parameter: &Parameter| checked(parameter, self.parameters.get(&parameter.name));
        let values = declared.parameters.iter().map(value).collect::<Result<_, SceneError>>()?;
        Ok(Parameters { declared: declared.clone(), values, looped: None })
    }
}

/// The parameter of a name.
fn find<'a>(declared: &'a Declarations, name: &str) -> Option<&'a Parameter> {
    declared.parameters.iter().find(|parameter| parameter.name == name)
}

fn unknown(declared: &Declarations, name: &str) -> SceneError {
    let known: Vec<&str> = declared.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    SceneError::unknown("parameter", name, &known)
}

/// Checks the value of a parameter.
///
/// # Errors
/// No module declares the parameter, or it does not take the value.
pub(super) fn check(declared: &Declarations, name: &str, value: &ParameterValue) -> Result<(), SceneError> {
    checked(find(declared, name).ok_or_else(|| unknown(declared, name))?, Some(value)).map(drop)
}

/// The value of a parameter, its default without one.
fn checked(parameter: &Parameter, value: Option<&ParameterValue>) -> Result<ParameterValue, SceneError> {
    Ok(match (parameter.kind, value) {
        (ParameterKind::Number(default, _), None) => ParameterValue::Number(default),
        (ParameterKind::Color(default), None) => ParameterValue::Color(super::Color(default)),
        (ParameterKind::Number(_, [low, high]), Some(ParameterValue::Number(value))) => {
            if !(low..=high).contains(value) {
                within(&format!("parameters.{}", parameter.name), *value, low, high)?;
            }
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
            return Err(SceneError::value(format!("parameters.{}", parameter.name), value, limit));
        }
    })
}
