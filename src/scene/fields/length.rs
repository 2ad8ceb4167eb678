//! Lengths with a unit, such as `1.2mm`, as values of fields in object units.
//!
//! Role: a scene keeps them beside its fields until the size of its object is known; [`Scene::set_lengths`] sets the fields.

use super::schema::{Kind, Setting, Unit, setting};
use crate::scene::{Scene, SceneError};
use crate::shader::Library;
use crate::shape;
use std::collections::BTreeMap;
use toml::{Table, Value};

/// A length in millimeters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Length(pub f64);

impl Length {
    /// A finite number with the symbol of a unit behind it: `1.2mm`, `50 um`, `0.5in`.
    pub fn parse(text: &str) -> Option<Length> {
        let text = text.trim().trim_matches(['"', '\'']);
        let start = text.find(|letter: char| letter.is_alphabetic() && !matches!(letter, 'e' | 'E'))?;
        let (number, unit) = text.split_at(start);
        let number: f64 = number.trim().parse().ok().filter(|number: &f64| number.is_finite())?;
        Some(Length(number * shape::Unit::named(unit)?.millimeters()))
    }
}

/// How a field takes a length: `None` if it takes no number.
fn taking(name: &str) -> Option<Taking> {
    let is_number = |setting: &Setting| matches!(setting.kind, Kind::Number(_) | Kind::Whole(_) | Kind::OneOf(_));
    match setting(name) {
        Some(setting) if !is_number(setting) => None,
        Some(setting) => Some(match setting.unit {
            Some(Unit::ObjectUnits) => Taking::Later,
            Some(Unit::Millimeters) => Taking::Now,
            _ => Taking::Never,
        }),
        None => parameter(name).map(|_| Taking::Later),
    }
}

#[derive(PartialEq)]
enum Taking {
    /// A length in millimeters.
    Now,
    /// A length in object units, or a parameter.
    Later,
    /// A number that is no length.
    Never,
}

/// The additional object, if it is of one, and the name of a parameter.
fn parameter(name: &str) -> Option<(Option<&str>, &str)> {
    match name.strip_prefix("parts.") {
        None => Some((None, name.strip_prefix("parameters.")?)),
        Some(rest) => {
            let (part, below) = rest.split_once('.')?;
            Some((Some(part), below.strip_prefix("parameters.")?))
        }
    }
}

fn no_length(name: &str, value: &str) -> SceneError {
    let own = name.strip_prefix("parameters.").unwrap_or(name);
    SceneError::value(name, value, format!("{own} is not a length; write a plain number"))
}

/// The key of a field among [`Scene::lengths`].
fn key(name: &str) -> String {
    name.replace('.', "/")
}

/// Moves the lengths out of the text of a scene; those of settings in millimeters become numbers.
pub(super) fn taken(table: &mut Table) -> Result<BTreeMap<String, String>, SceneError> {
    let mut lengths = BTreeMap::new();
    take("", table, &mut lengths)?;
    Ok(lengths)
}

fn take(prefix: &str, table: &mut Table, lengths: &mut BTreeMap<String, String>) -> Result<(), SceneError> {
    let mut moved = Vec::new();
    for (own, value) in table.iter_mut() {
        let name = if prefix.is_empty() { own.clone() } else { format!("{prefix}.{own}") };
        if let Value::Table(below) = value {
            take(&name, below, lengths)?;
            continue;
        }
        let Some((text, length)) = value.as_str().and_then(|text| Some((text, Length::parse(text)?))) else { continue };
        match taking(&name) {
            None => {}
            Some(Taking::Now) => *value = length.0.into(),
            Some(Taking::Later) => {
                lengths.insert(key(&name), text.into());
                moved.push(own.clone());
            }
            Some(Taking::Never) => return Err(no_length(&name, text)),
        }
    }
    moved.iter().for_each(|own| drop(table.remove(own)));
    Ok(())
}

impl Scene {
    /// Takes a value with a unit; `false` if the value has none, or the field takes no number.
    pub(super) fn take_length(&mut self, name: &str, value: &str) -> Result<bool, SceneError> {
        self.lengths.remove(&key(name));
        let Some((length, taking)) = Length::parse(value).zip(taking(name)) else { return Ok(false) };
        match taking {
            Taking::Now => self.set_field(name, &length.0.to_string())?,
            Taking::Later => drop(self.lengths.insert(key(name), value.into())),
            Taking::Never => return Err(no_length(name, value)),
        }
        Ok(true)
    }

    /// Sets the fields that have lengths: `millimeters` are those in one object unit of the main object. Those of an additional
    /// object are divided by its `transform.scale` too.
    ///
    /// # Errors
    /// A field that is no length, or a value out of its range.
    pub fn set_lengths(&mut self, library: &Library, millimeters: f64) -> Result<(), SceneError> {
        let lengths = std::mem::take(&mut self.lengths);
        let (own, parts) = (self.check(library)?, self.check_parts(library)?);
        for (key, text) in lengths {
            let name = key.replace('/', ".");
            let part = name.strip_prefix("parts.").and_then(|rest| rest.split('.').next());
            if let Some((_, parameter)) = parameter(&name) {
                let declared = part.map_or(Some(&own), |part| parts.get(part));
                let found = declared.and_then(|all| all.iter().find(|(declared, _)| declared.name == parameter));
                if found.is_some_and(|(declared, _)| !declared.is_length()) {
                    return Err(no_length(&name, &text));
                }
            }
            let scale = part.and_then(|part| self.parts.get(part)).map_or(1.0, |part| f64::from(part.transform.scale));
            let length = Length::parse(&text).ok_or_else(|| no_length(&name, &text))?;
            let units = (length.0 / (millimeters * scale)) as f32;
            self.set_field(&name, &format!("{units:?}"))?;
        }
        self.check(library)?;
        self.check_parts(library).map(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ParameterValue, parse, preset};
    use crate::shader::shipped;

    #[test]
    fn a_length_is_a_number_with_a_unit() {
        let own = |text| Length::parse(text).map(|length| length.0);
        assert_eq!(["1.2mm", "50 um", "0.5in", "-2cm", "1e-3m"].map(own), [1.2, 0.05, 12.7, -20.0, 1.0].map(Some));
        for text in ["1.2", "mm", "1.2 px", "#aabbcc", "1.2mm2", "nanmm", "infmm", "", "e"] {
            assert_eq!(own(text), None, "{text}");
        }
    }

    #[test]
    fn lengths_of_flags_and_files_become_object_units() {
        // 60 mm along two object units: 30 mm in one.
        let mut scene = preset("noisy_sphere").unwrap();
        scene.set_field("parameters.amplitude", "1.2mm").unwrap();
        scene.set_field("object.shell", "3mm").unwrap();
        scene.set_field("object.scale_to", "6cm").unwrap();
        assert_eq!((scene.object.scale_to, scene.object.shell), (60.0, 0.0));
        scene.set_lengths(&shipped(), 30.0).unwrap();
        assert_eq!(scene.parameters["amplitude"], ParameterValue::Number(0.04));
        assert_eq!((scene.object.shell, scene.lengths.len()), (0.1, 0));
        let text = "preset = \"noisy_sphere\"\n[object]\nscale_to = \"60mm\"\nshell = \"1500um\"\n[parameters]\namplitude = \"1.2mm\"\n";
        let mut file = parse(text, "x.toml").unwrap();
        assert_eq!((file.object.scale_to, file.lengths.len()), (60.0, 2));
        file.set_lengths(&shipped(), 30.0).unwrap();
        assert_eq!((file.object.shell, &file.parameters["amplitude"]), (0.05, &ParameterValue::Number(0.04)));
    }

    #[test]
    fn a_number_that_is_no_length_is_refused() {
        let mut scene = preset("noisy_sphere").unwrap();
        let error = scene.set_field("object.iso", "1mm").unwrap_err().to_string();
        assert_eq!(error, "object.iso = 1mm: object.iso is not a length; write a plain number");
        scene.set_field("parameters.frequency", "1mm").unwrap();
        let error = scene.set_lengths(&shipped(), 1.0).unwrap_err().to_string();
        assert!(error.ends_with("frequency is not a length; write a plain number"), "{error}");
        scene.set_field("parameters.amplitude", "90mm").unwrap();
        let error = scene.set_lengths(&shipped(), 1.0).unwrap_err().to_string();
        assert!(error.contains("amplitude = 90: must be from"), "{error}");
        let error = parse("[object]\niso = \"1mm\"\n", "x.toml").unwrap_err().to_string();
        assert!(error.contains("x.toml:2") && error.contains("is not a length"), "{error}");
    }
}
