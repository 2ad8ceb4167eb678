//! Fields of a scene by name, as for `--set`.

use super::error::reason;
use super::schema::{Changes, float, setting};
use super::{Scene, SceneError};
use std::collections::BTreeMap;
use toml::{Table, Value};

impl Scene {
    /// Sets a field, named with its tables such as `light.color` or `parts.stone.transform.at`. The value is written as in a
    /// scene file; a text needs no quotes. An empty value restores the default.
    ///
    /// # Errors
    /// The field does not exist, or does not take the value. [`Scene::check`] checks it against other fields.
    pub fn set_field(&mut self, name: &str, value: &str) -> Result<(), SceneError> {
        let wrong = |limit: String| SceneError::value(name, value, limit.replace('\n', " "));
        let mut whole = Table::try_from(&*self).map_err(|error| wrong(error.to_string()))?;
        let (tables, field) = name.rsplit_once('.').map_or((Vec::new(), name), |(t, f)| (t.split('.').collect(), f));
        let mut table = &mut whole;
        for name in tables {
            let below = table.entry(name).or_insert_with(|| Table::new().into());
            table = below.as_table_mut().ok_or_else(|| wrong(format!("{name} has no fields of its own")))?;
        }
        match value {
            "" => drop(table.remove(field)),
            _ => {
                let value = parse_value(value);
                setting(name).map_or(Ok(()), |setting| setting.check(name, &value))?;
                table.insert(field.into(), value);
            }
        }
        *self = whole.try_into().map_err(|error| wrong(reason(&error)))?;
        Ok(())
    }

    /// All fields of the scene file, with their names for [`Scene::set_field`].
    pub fn fields(&self) -> Vec<(String, Value)> {
        let whole = Table::try_from(self).expect("a scene holds nothing that TOML cannot hold");
        let mut fields = Vec::new();
        flatten("", whole, &mut fields);
        fields
    }

    /// Fingerprint of the scene that ignores colors and the magnitude of numbers other than 0.
    pub fn shape(&self) -> String {
        let part = |(name, value): (String, Value)| match (float(&value), &value) {
            (Some(number), _) => format!("{name} {}\n", number != 0.0),
            (None, Value::Array(many)) if many.iter().all(|value| float(value).is_some()) => format!("{name}\n"),
            (None, Value::String(text)) if text.starts_with('#') => format!("{name}\n"),
            (None, value) => format!("{name} {value}\n"),
        };
        self.fields().into_iter().map(part).collect()
    }

    /// Fields that differ from `base`, with their values; `None` for a missing field.
    pub fn difference(&self, base: &Scene) -> Vec<(String, Option<Value>)> {
        let (before, after) = (base.fields(), self.fields());
        let [had, has] = [&before, &after]
            .map(|fields| fields.iter().map(|(name, value)| (name.as_str(), value)).collect::<BTreeMap<_, _>>());
        let gone =
            before.iter().filter(|(name, _)| !has.contains_key(name.as_str())).map(|(name, _)| (name.clone(), None));
        let new = after.iter().filter(|(name, value)| had.get(name.as_str()) != Some(&value));
        gone.chain(new.map(|(name, value)| (name.clone(), Some(value.clone())))).collect()
    }

    /// Stages of the renderer to rebuild if `base` is prepared. Values of parameters only change the picture.
    pub fn changes(&self, base: &Scene) -> Vec<Changes> {
        let of = |name: &str| match setting(name) {
            Some(setting) => setting.changes,
            None if name.split('.').rev().nth(1) == Some("parameters") => Changes::Picture,
            None => Changes::Images,
        };
        self.difference(base).iter().map(|(name, _)| of(name)).collect()
    }
}

/// Parses a value of a scene file; anything else is a text.
pub fn parse_value(text: &str) -> Value {
    let parsed = toml::from_str::<Table>(&format!("value = {text}")).ok().filter(|table| table.len() == 1);
    parsed.and_then(|mut table| table.remove("value")).unwrap_or_else(|| text.into())
}

pub(super) fn flatten(prefix: &str, table: Table, fields: &mut Vec<(String, Value)>) {
    for (name, value) in table {
        let name = if prefix.is_empty() { name } else { format!("{prefix}.{name}") };
        match value {
            Value::Table(below) => flatten(&name, below, fields),
            value => fields.push((name, value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{Color, preset};

    #[test]
    fn a_field_is_set_by_name_and_goes_back_to_its_default() {
        let mut scene = preset("fur").unwrap();
        scene.set_field("light.color", "#ff8000").unwrap();
        scene.set_field("effect.dmf", "['fur', 'biased']").unwrap();
        scene.set_field("parts.b.transform.at", "[1, 2, 0.5]").unwrap();
        scene.set_field("combine", "main - b").unwrap();
        scene.set_field("camera.clip", "[1, 0, 0, 0]").unwrap();
        assert_eq!((scene.light.color, scene.parts["b"].transform.at), (Color([255, 128, 0]), [1.0, 2.0, 0.5]));
        assert_eq!((scene.effect.dmf.len(), scene.combine.as_deref()), (2, Some("main - b")));
        for field in ["camera.clip", "combine", "parts.b", "quality.samples"] {
            scene.set_field(field, "").unwrap();
        }
        assert!(scene.camera.clip.is_none() && scene.combine.is_none() && scene.parts.is_empty());
        assert_eq!(scene.quality.samples, 256);
    }

    #[test]
    fn the_shape_of_a_scene_is_what_it_is_made_of() {
        let scene = preset("fur").unwrap();
        let with = |field: &str, value: &str| {
            let mut other = scene.clone();
            other.set_field(field, value).unwrap();
            other.shape() == scene.shape()
        };
        for (field, value) in [
            ("light.color", "#123456"),
            ("camera.azimuth", "12"),
            ("quality.samples", "17"),
            ("light.position", "[1, 2, 3]"),
        ] {
            assert!(with(field, value), "{field}");
        }
        let other = (!scene.light.shadows).to_string();
        for (field, value) in
            [("light.shadows", other.as_str()), ("effect.noise", "procedural"), ("light.intensity", "0")]
        {
            assert!(!with(field, value), "{field}");
        }
    }

    #[test]
    fn an_unknown_field_is_refused_and_changes_nothing() {
        let mut scene = preset("fur").unwrap();
        let before = scene.clone();
        for (field, value) in [("quality.sample", "3"), ("quality.samples", "many"), ("about.x", "1")] {
            let error = scene.set_field(field, value).unwrap_err().to_string();
            assert!(error.starts_with(&format!("{field} = {value}: ")) && !error.contains('\n'), "{error}");
        }
        assert_eq!(scene, before);
    }
}
