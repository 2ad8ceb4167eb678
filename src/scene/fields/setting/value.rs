//! Values against the schema.

use super::{Kind, Range, Setting};
use crate::scene::SceneError;
use hypertexture_support::words::nearest;
use toml::Value;

impl Setting {
    /// Checks a value of a scene file; errors call the setting `name`.
    ///
    /// # Errors
    /// [`SceneError::Value`]: a value of another kind, or out of range, as NaN always is.
    pub fn check(&self, name: &str, value: &Value) -> Result<(), SceneError> {
        let wrong = |shown: String, limit: String| Err(SceneError::Value { field: name.into(), value: shown, limit });
        let one = |value: &Value, range: Range| match float(value) {
            Some(number) if (range.low..=range.high).contains(&number) => Ok(()),
            Some(_) => wrong(text(value), format!("must be {}", range.must())),
            None if range.is_all() => wrong(text(value), "must be a finite number".into()),
            None => wrong(text(value), format!("must be a number {}", range.must())),
        };
        let whole = |value: &Value, range: Range| match value {
            Value::Integer(_) => one(value, range),
            _ => wrong(text(value), format!("must be a whole number {}", range.must())),
        };
        let all = |count: usize, check: &dyn Fn(&Value) -> Result<(), SceneError>| match value {
            Value::Array(values) if values.len() == count => values.iter().try_for_each(check),
            other => wrong(text(other), format!("must be {count} numbers, such as {}", self.example())),
        };
        match self.kind {
            Kind::Number(range) => one(value, range),
            Kind::Whole(range) => whole(value, range),
            Kind::Numbers(count, range) => all(count, &|value| one(value, range)),
            Kind::Wholes(count, range) => all(count, &|value| whole(value, range)),
            Kind::OneOf(numbers) => match float(value) {
                Some(found) if numbers.iter().any(|&number| number as f32 == found) => Ok(()),
                _ => wrong(text(value), format!("must be {}", self.limits())),
            },
            Kind::Choice(choices) => match value.as_str() {
                Some(found) if choices.iter().any(|(name, _)| *name == found) => Ok(()),
                found => {
                    let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
                    let near = found.and_then(|found| nearest(found, &names));
                    let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
                    wrong(text(value), format!("must be {}{near}", self.limits()))
                }
            },
            Kind::Switch if !value.is_bool() => wrong(text(value), "must be true or false".into()),
            _ => Ok(()), // serde checks their types
        }
    }

    /// An example of a value.
    pub fn example(&self) -> String {
        match self.kind {
            Kind::Numbers(count, _) | Kind::Wholes(count, _) => format!("[{}]", vec!["1"; count].join(", ")),
            _ => self.limits(),
        }
    }
}

impl Range {
    fn must(self) -> String {
        if self.is_all() { "finite".into() } else { format!("from {} to {}", self.low, self.high) }
    }
}

/// A number in single precision, as a scene holds it.
pub fn float(value: &Value) -> Option<f32> {
    match value {
        Value::Integer(whole) => Some(*whole as f32),
        Value::Float(number) => Some(*number as f32),
        _ => None,
    }
}

/// A value as errors show it.
fn text(value: &Value) -> String {
    match value {
        Value::Float(number) => (*number as f32).to_string(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}
