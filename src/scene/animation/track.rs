//! The motion of one field.

use super::keys::{Curve, Key};
use crate::scene::fields::setting::{Leaf, Moment};
use crate::scene::{Color, SceneError};
use toml::Value;

/// Longest expression, since its parser recurses.
const MAX_LENGTH: usize = 1000;
/// Largest distance of a keyframe from time 0, seconds: that of `camera.time`.
const MAX_KEY_TIME: f64 = 1e9;

/// Motion of a field.
#[derive(Clone, Debug, PartialEq)]
pub enum Track {
    /// Keyframes, in the order of time.
    Keys(Vec<Key>),
    /// An expression in `time` for a number, or one for each of several numbers.
    Expressions(Vec<String>),
}

/// Form of a value.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Form {
    Number,
    Numbers,
    /// A color in linear light.
    Color,
}

impl Form {
    /// Numbers of this form.
    pub(super) fn moment(self, numbers: &[f64]) -> Moment<'_> {
        match (self, numbers) {
            (Form::Number, &[number]) => Moment::Number(number),
            (Form::Color, &[r, g, b]) => Moment::Color([r, g, b]),
            _ => Moment::Numbers(numbers),
        }
    }

    /// Numbers of this form as a file has them.
    pub(super) fn value(self, numbers: &[f64]) -> Value {
        match self.moment(numbers) {
            Moment::Number(number) => number.into(),
            Moment::Numbers(numbers) => numbers.to_vec().into(),
            color @ Moment::Color(_) => {
                Color::at(color).map_or(Value::Boolean(false), |color| String::from(color).into())
            }
        }
    }
}

impl TryFrom<Value> for Track {
    type Error = String;

    fn try_from(value: Value) -> Result<Track, String> {
        let wrong = || {
            "must be keyframes, such as [{ time = 0, value = 1 }, { time = 2, value = 3 }], or an expression, such as \
             \"1 + sin(time)\""
                .to_string()
        };
        match value {
            Value::String(text) => Ok(Track::Expressions(vec![text])),
            Value::Array(all) if all.is_empty() => Err(wrong()),
            Value::Array(all) if all.iter().all(Value::is_str) => {
                Ok(Track::Expressions(all.iter().filter_map(Value::as_str).map(String::from).collect()))
            }
            Value::Array(all) if all.iter().all(Value::is_table) => {
                let keys =
                    all.into_iter().map(|key| key.try_into().map_err(|error| crate::scene::error::reason(&error)));
                Ok(Track::Keys(keys.collect::<Result<_, _>>()?))
            }
            _ => Err(wrong()),
        }
    }
}

impl From<Track> for Value {
    fn from(track: Track) -> Value {
        match track {
            Track::Keys(keys) => {
                let keys = keys.into_iter().map(|key| Value::try_from(key).unwrap_or(Value::Boolean(false)));
                Value::Array(keys.collect())
            }
            Track::Expressions(texts) if texts.len() == 1 => texts.into_iter().collect::<String>().into(),
            Track::Expressions(texts) => texts.into(),
        }
    }
}

impl Track {
    /// Checks keyframes and expressions of the track `name`.
    pub(super) fn check(&self, name: &str, period: Option<f64>) -> Result<(), SceneError> {
        let Track::Keys(keys) = self else { return self.at(name, 0.0, period).map(drop) };
        let fail = |time: f64, limit: String| Err(SceneError::value(format!("{name}.time"), time, limit));
        let last = period.unwrap_or(MAX_KEY_TIME);
        let first = if period.is_some() { 0.0 } else { -MAX_KEY_TIME };
        for key in keys {
            if !(first..=last).contains(&key.time) {
                return fail(key.time, format!("must be from {first} to {last} seconds"));
            }
        }
        if let Some(pair) = keys.windows(2).find(|pair| pair[0].time >= pair[1].time) {
            return fail(pair[1].time, format!("must be later than the keyframe before it, at {} s", pair[0].time));
        }
        let forms: Vec<_> = keys.iter().map(|key| numbers(&key.value)).collect();
        for (key, form) in keys.iter().zip(&forms) {
            let alike = |(form, numbers): &(Form, Vec<f64>)| (*form, numbers.len());
            if form.is_none() || form.as_ref().map(alike) != forms[0].as_ref().map(alike) {
                let limit = "keyframes are numbers, lists of numbers or colors, all of one kind";
                return Err(SceneError::value(name, format!("{} at {} s", key.value, key.time), limit));
            }
        }
        match (&keys[0], &keys[keys.len() - 1], period) {
            (start, end, Some(period)) if start.time == 0.0 && end.time == period && start.value != end.value => {
                let limit = format!("must be {}, as at 0 s, where the loop begins anew", start.value);
                Err(SceneError::value(name, format!("{} at {period} s", end.value), limit))
            }
            _ => Ok(()),
        }
    }

    /// Form and numbers of the track `name` at a time.
    pub(super) fn at(&self, name: &str, time: f64, period: Option<f64>) -> Result<(Form, Vec<f64>), SceneError> {
        let keys = match self {
            Track::Keys(keys) => keys,
            Track::Expressions(texts) => {
                let form = if texts.len() == 1 { Form::Number } else { Form::Numbers };
                let numbers = texts.iter().map(|text| evaluate(name, text, time)).collect::<Result<_, _>>()?;
                return Ok((form, numbers));
            }
        };
        let mut form = Form::Number;
        let ends = |key: &&Key| period.is_none_or(|period| key.time < period || keys[0].time > 0.0);
        let knots: Vec<_> = keys
            .iter()
            .filter(ends) // the keyframe at the end of a loop is that of its beginning
            .filter_map(|key| {
                let (own, numbers) = numbers(&key.value)?;
                form = own;
                Some((key.time, key.ease, numbers))
            })
            .collect();
        Ok((form, Curve { knots: &knots, period }.at(time)))
    }
}

/// Form and numbers of a value; a color in linear light.
fn numbers(value: &Value) -> Option<(Form, Vec<f64>)> {
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    match value {
        Value::Array(all) => Some((Form::Numbers, all.iter().map(number).collect::<Option<_>>()?)),
        Value::String(text) => {
            let color = Color::try_from(text.clone()).ok()?;
            Some((Form::Color, color.linear().map(f64::from).into()))
        }
        value => Some((Form::Number, vec![number(value).filter(|number| number.is_finite())?])),
    }
}

/// Value of an expression in `time`.
fn evaluate(name: &str, text: &str, time: f64) -> Result<f64, SceneError> {
    use exmex::Express;
    let wrong = |limit: String| SceneError::value(name, format!("\"{text}\""), limit);
    if text.len() > MAX_LENGTH {
        return Err(SceneError::value(name, "an expression", format!("must have at most {MAX_LENGTH} characters")));
    }
    let read = exmex::parse::<f64>(text).map_err(|error| wrong(error.msg().replace('\n', " ")))?;
    if let Some(other) = read.var_names().iter().find(|own| *own != "time") {
        return Err(wrong(format!("`{other}` is unknown; `time` is the variable, in seconds")));
    }
    let value = read.eval(&[time][..read.var_names().len()]).map_err(|error| wrong(error.msg().replace('\n', " ")))?;
    if value.is_finite() { Ok(value) } else { Err(wrong(format!("must be finite, and is {value} at {time} s"))) }
}
