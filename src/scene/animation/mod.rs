//! Motion of settings over time.
//!
//! Role: the table `animation` of a scene file, in which a field of the scene has keyframes or an expression in place of its
//! value. Invariant: [`Scene::moment`] is a scene without tracks, so that pictures, references and proofs know no motion.

mod keys;
mod repeat;
mod track;

pub use keys::{Ease, Key};
pub(crate) use repeat::Looped;
pub use track::Track;

use super::fields::schema::{self, ChangeSet, Changes, Kind, Setting, Unit, setting};
use super::fields::setting::{Leaf, Moment, Node, number, push_name};
use super::{FieldId, ParameterValue, Scene, SceneError, parameters};
use crate::shader::Declarations;
use serde::de::Error;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;
use toml::{Table, Value};

/// Name of the length of a loop in the table.
const LOOP: &str = "loop";
/// Name of the table.
const TABLE: &str = "animation";

/// Motion of a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Table", into = "Table")]
pub struct Animation {
    /// Seconds after which all motion begins anew.
    pub period: Option<f64>,
    /// Motion of fields, by their names such as `camera.azimuth`.
    pub tracks: BTreeMap<String, Track>,
}

impl Animation {
    /// The settings of this table.
    pub const SETTINGS: &[Setting] = &[Setting::new(
        "animation.loop",
        "Seconds after which all motion begins anew: keyframes, expressions, and the drift of noise.",
        Changes::Images,
        number(0.01, 1e6),
    )
    .usual(1.0, 20.0)
    .optional("4")
    .unit(Unit::Seconds)];

    /// Whether nothing moves or repeats.
    pub fn is_empty(&self) -> bool {
        self.period.is_none() && self.tracks.is_empty()
    }

    /// The time within the loop.
    pub fn wrapped(&self, time: f64) -> f64 {
        self.period.map_or(time, |period| time.rem_euclid(period))
    }

    /// Adds a keyframe to a field; a keyframe of the same time is replaced, an expression too.
    pub fn set_key(&mut self, field: &str, key: Key) {
        let track = self.tracks.entry(field.into()).or_insert_with(|| Track::Keys(Vec::new()));
        match track {
            Track::Keys(keys) => {
                keys.retain(|own| own.time != key.time);
                let place = keys.partition_point(|own| own.time < key.time);
                keys.insert(place, key);
            }
            Track::Expressions(_) => *track = Track::Keys(vec![key]),
        }
    }

    /// Removes the keyframe of a field at a time; with the last one, the track.
    pub fn remove_key(&mut self, field: &str, time: f64) {
        if let Some(Track::Keys(keys)) = self.tracks.get_mut(field) {
            keys.retain(|key| key.time != time);
            if keys.is_empty() {
                self.tracks.remove(field);
            }
        }
    }
}

impl TryFrom<Table> for Animation {
    type Error = String;

    fn try_from(mut table: Table) -> Result<Animation, String> {
        let period = table.remove(LOOP).map(|value| read_period(&value)).transpose()?;
        let mut animation = Animation { period, tracks: BTreeMap::new() };
        table.into_iter().try_for_each(|(name, value)| read(name, value, &mut animation.tracks))?;
        Ok(animation)
    }
}

/// Reads the length of a loop.
fn read_period(value: &Value) -> Result<f64, String> {
    let number = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    number.ok_or_else(|| format!("{TABLE}.{LOOP} is a number of seconds"))
}

/// Reads the track of a field.
fn read_track(field: &str, value: Value) -> Result<Track, String> {
    Track::try_from(value).map_err(|reason| format!("{TABLE}.{field}: {reason}"))
}

/// Reads the tracks in a table, or that of a field.
fn read(name: String, value: Value, tracks: &mut BTreeMap<String, Track>) -> Result<(), String> {
    match value {
        Value::Table(below) => {
            below.into_iter().try_for_each(|(field, value)| read(format!("{name}.{field}"), value, tracks))
        }
        value => {
            let track = read_track(&name, value)?;
            tracks.insert(name, track);
            Ok(())
        }
    }
}

impl From<Animation> for Table {
    fn from(animation: Animation) -> Table {
        let mut whole = Table::new();
        whole.extend(animation.period.map(|period| (LOOP.into(), period.into())));
        for (name, track) in animation.tracks {
            insert(&mut whole, &name, track.into());
        }
        whole
    }
}

/// Sets a field in a table by its path.
fn insert(whole: &mut Table, path: &str, value: Value) {
    match path.split_once('.') {
        None => drop(whole.insert(path.into(), value)),
        Some((table, rest)) => {
            let below = whole.entry(table).or_insert_with(|| Table::new().into());
            if let Some(below) = below.as_table_mut() {
                insert(below, rest, value);
            }
        }
    }
}

/// Identity of a field of [`Animation`].
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AnimationField {
    /// Seconds after which all motion begins anew.
    Loop,
    /// The track of a field with this name.
    Track(String),
}

impl Node for Animation {
    type Id = AnimationField;

    fn find(name: &str) -> Option<AnimationField> {
        match name {
            LOOP => Some(AnimationField::Loop),
            field => is_movable(field).then(|| AnimationField::Track(field.into())),
        }
    }

    fn write_name(id: &AnimationField, name: &mut String) {
        match id {
            AnimationField::Loop => push_name(name, LOOP),
            AnimationField::Track(field) => push_name(name, field),
        }
    }

    fn setting(id: &AnimationField) -> Option<&'static Setting> {
        (*id == AnimationField::Loop).then_some(&Animation::SETTINGS[0])
    }

    fn each(&self, on: &mut dyn FnMut(AnimationField)) {
        self.period.iter().for_each(|_| on(AnimationField::Loop));
        self.tracks.keys().for_each(|field| on(AnimationField::Track(field.clone())));
    }

    fn get(&self, id: &AnimationField) -> Option<Value> {
        match id {
            AnimationField::Loop => self.period.map(Value::from),
            AnimationField::Track(field) => self.tracks.get(field).cloned().map(Value::from),
        }
    }

    fn set(&mut self, id: &AnimationField, value: Option<&Value>, _: fn() -> Animation) -> Result<(), toml::de::Error> {
        match (id, value) {
            (AnimationField::Loop, value) => {
                self.period = value.map(read_period).transpose().map_err(toml::de::Error::custom)?;
            }
            (AnimationField::Track(field), Some(value)) => {
                let track = read_track(field, value.clone()).map_err(toml::de::Error::custom)?;
                self.tracks.insert(field.clone(), track);
            }
            (AnimationField::Track(field), None) => drop(self.tracks.remove(field)),
        }
        Ok(())
    }

    fn animate(&mut self, _: &AnimationField, _: Moment<'_>, _: Option<&Setting>) -> bool {
        false // nothing moves a track
    }

    fn changes(&self, other: &Animation, _: Option<&Setting>) -> ChangeSet {
        if self == other { ChangeSet::default() } else { ChangeSet::of(&[Changes::Images]) }
    }

    fn is_valid(&self, _: Option<&Setting>) -> bool {
        self.period.is_none_or(|period| period.is_allowed(&Animation::SETTINGS[0].kind))
    }
}

/// Whether a field may have a track: a number, numbers or a color.
pub fn is_movable(field: &str) -> bool {
    let is_parameter = field.split('.').rev().nth(1) == Some("parameters");
    let moves = |setting: &Setting| {
        let is_fixed = ["camera.time", "image.size"].contains(&setting.name) || setting.table() == TABLE;
        !is_fixed && matches!(setting.kind, Kind::Number(_) | Kind::Whole(_) | Kind::Numbers(..) | Kind::Color)
    };
    is_parameter || schema::setting(field).is_some_and(moves)
}

impl Scene {
    /// The scene at its time, without tracks and hidden objects; with a loop, its time is that within the loop.
    ///
    /// # Errors
    /// A track has no value at that time, or one that its field does not take. Without the hidden objects, the formula of
    /// the objects has none left.
    pub fn moment(&self) -> Result<Cow<'_, Scene>, SceneError> {
        let still = self.still()?;
        if still.parts.values().any(|part| part.hidden) {
            Ok(Cow::Owned(still.into_owned().without_hidden()?))
        } else {
            Ok(still)
        }
    }

    /// The scene at its time, without tracks, but with hidden objects.
    ///
    /// # Errors
    /// A track has no value at that time, or one that its field does not take.
    pub fn still(&self) -> Result<Cow<'_, Scene>, SceneError> {
        let Animation { period, tracks } = &self.animation;
        self.check_animation()?;
        let time = self.animation.wrapped(self.camera.time);
        if tracks.is_empty() && time == self.camera.time {
            return Ok(Cow::Borrowed(self));
        }
        let mut still = self.clone();
        still.animation.tracks.clear();
        still.camera.time = time;
        for (field, track) in tracks {
            let name = format!("{TABLE}.{field}");
            let (form, mut numbers) = track.at(&name, time, *period)?;
            if field == "camera.rotation" {
                to_unit(&mut numbers);
            }
            let own = FieldId::named(field);
            if own.is_some_and(|own| still.animate(&own, form.moment(&numbers), None)) {
                continue;
            }
            // The field does not take the value.
            let mut value = form.value(&numbers);
            if let (Some(Kind::Whole(_)), Value::Float(number)) = (setting(field).map(|own| own.kind), &value) {
                value = Value::Integer(number.round() as i64);
            }
            let check = setting(field).map_or(Ok(()), |setting| setting.check(&name, &value));
            check.map_err(|error| at_time(error, time))?;
            still.insert(field, Some(value)).map_err(|limit| SceneError::value(TABLE, "", limit))?;
        }
        Ok(Cow::Owned(still))
    }

    /// Keyed setting whose motion replaces that of a turntable, if any.
    pub fn keyed_turn(&self) -> Option<&'static str> {
        // A rotation replaces the azimuth, with its keyframes.
        let is_read = |field: &&str| *field == "camera.rotation" || self.camera.rotation.is_none();
        let mut fields = ["camera.rotation", "camera.azimuth"].into_iter().filter(is_read);
        fields.find(|field| self.animation.tracks.contains_key(*field))
    }

    /// Checks loop and tracks; the values of keyframes too.
    fn check_animation(&self) -> Result<(), SceneError> {
        let Animation { period, tracks } = &self.animation;
        if let Some(period) = period {
            Animation::SETTINGS[0].check(Animation::SETTINGS[0].name, &(*period).into())?;
        }
        for (field, track) in tracks {
            let name = format!("{TABLE}.{field}");
            if !is_movable(field) {
                let limit = "numbers and colors of the scene have tracks, such as animation.camera.azimuth";
                return Err(SceneError::value(name, "a track", limit));
            }
            track.check(&name, *period)?;
            let Track::Keys(keys) = track else { continue };
            let Some(setting) = setting(field) else { continue };
            keys.iter()
                .try_for_each(|key| setting.check(&name, &key.value).map_err(|error| at_time(error, key.time)))?;
        }
        Ok(())
    }

    /// Checks the keyframes of parameters against the declarations of the modules.
    pub(super) fn check_keys_of_parameters(&self, declared: &Declarations) -> Result<(), SceneError> {
        for (field, track) in &self.animation.tracks {
            let (Some(name), Track::Keys(keys)) = (field.strip_prefix("parameters."), track) else { continue };
            for key in keys {
                let value = key.value.clone().try_into::<ParameterValue>();
                let value =
                    value.map_err(|_| SceneError::value(format!("{TABLE}.{field}"), &key.value, "a parameter"))?;
                parameters::check(declared, name, &value).map_err(|error| at_time(error, key.time))?;
            }
        }
        Ok(())
    }
}

/// The error with the time of a value.
fn at_time(error: SceneError, time: f64) -> SceneError {
    match error {
        SceneError::Value { field, value, limit } => {
            SceneError::Value { field, value: format!("{value} at {time} s"), limit }
        }
        other => other,
    }
}

/// Scales numbers to the sum of squares 1.
fn to_unit(numbers: &mut [f64]) {
    let length = numbers.iter().map(|number| number * number).sum::<f64>().sqrt();
    numbers.iter_mut().for_each(|number| *number /= length);
}

#[cfg(test)]
mod tests;
