//! Fields of a scene by name, as for `--set`.

use super::schema::{ChangeSet, float, setting};
use super::setting::Node;
use crate::scene::error::reason;
use crate::scene::{FieldId, Scene, SceneError};
use std::collections::BTreeMap;
use std::fmt;
use toml::{Table, Value};

impl FieldId {
    /// The field with a name such as `light.color` or `parts.stone.transform.at`. Tables have no identity.
    pub fn named(name: &str) -> Option<FieldId> {
        if name.ends_with('.') { None } else { Scene::find(name) }
    }
}

impl fmt::Display for FieldId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut name = String::new();
        Scene::write_name(self, &mut name);
        formatter.write_str(&name)
    }
}

impl Scene {
    /// The value of a field; `None` if it has none.
    pub fn value(&self, field: &FieldId) -> Option<Value> {
        Node::get(self, field)
    }

    /// The value of the field with a name; `None` if it has none.
    pub fn value_named(&self, name: &str) -> Option<Value> {
        self.value(&FieldId::named(name)?)
    }

    /// Sets a field, named with its tables such as `light.color` or `parts.stone.transform.at`. The value is written as in a
    /// scene file; a text needs no quotes. A length may have a unit,
    /// such as `1.2mm`: it is set once the size of the object is known, see [`Scene::set_lengths`]. An empty value restores the default.
    ///
    /// # Errors
    /// The field does not exist, or does not take the value. [`Scene::check`] checks it against other fields.
    pub fn set_field(&mut self, name: &str, value: &str) -> Result<(), SceneError> {
        if self.take_length(name, value)? {
            return Ok(());
        }
        let parsed = (!value.is_empty()).then(|| parse_value(value));
        if let (Some(setting), Some(parsed)) = (setting(name), &parsed) {
            setting.check(name, parsed)?;
        }
        self.insert(name, parsed).map_err(|limit| SceneError::value(name, value, limit.replace('\n', " ")))
    }

    /// Sets a field or a table by its name, without a check of the value against its setting.
    pub(in crate::scene) fn insert(&mut self, name: &str, value: Option<Value>) -> Result<(), String> {
        match FieldId::named(name) {
            Some(field) if !matches!(value, Some(Value::Table(_))) => {
                self.set(&field, value.as_ref(), Scene::default).map_err(|error| reason(&error))
            }
            _ => self.insert_in_table(name, value),
        }
    }

    /// Sets a table by its name. The reader of scene files checks it, and says which fields there are.
    fn insert_in_table(&mut self, name: &str, value: Option<Value>) -> Result<(), String> {
        let mut whole = Table::try_from(&*self).map_err(|error| error.to_string())?;
        let (tables, field) = name.rsplit_once('.').map_or((Vec::new(), name), |(t, f)| (t.split('.').collect(), f));
        let mut table = &mut whole;
        for name in tables {
            let below = table.entry(name).or_insert_with(|| Table::new().into());
            table = below.as_table_mut().ok_or_else(|| format!("{name} has no fields of its own"))?;
        }
        match value {
            Some(value) => drop(table.insert(field.into(), value)),
            None => drop(table.remove(field)),
        }
        *self = whole.try_into().map_err(|error| reason(&error))?;
        Ok(())
    }

    /// All fields with a value, by name.
    fn by_name(&self) -> BTreeMap<String, FieldId> {
        let mut fields = BTreeMap::new();
        self.each(&mut |field| drop(fields.insert(field.to_string(), field)));
        fields
    }

    /// All fields with a value, in the order of their names for [`Scene::set_field`].
    pub fn fields(&self) -> Vec<(String, Value)> {
        self.by_name().into_iter().filter_map(|(name, field)| Some((name, self.value(&field)?))).collect()
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
        let (before, after) = (base.by_name(), self.by_name());
        let gone = before.into_keys().filter(|name| !after.contains_key(name)).map(|name| (name, None));
        let new = after.iter().filter_map(|(name, field)| {
            let value = self.value(field);
            (value != base.value(field)).then(|| (name.clone(), value))
        });
        gone.chain(new).collect()
    }

    /// Stages of the renderer that the differences from another scene concern. Values of parameters only change the picture.
    pub fn changes(&self, other: &Scene) -> ChangeSet {
        Node::changes(self, other, None)
    }
}

/// Parses a value of a scene file; anything else is a text.
pub fn parse_value(text: &str) -> Value {
    let parsed = toml::from_str::<Table>(&format!("value = {text}")).ok().filter(|table| table.len() == 1);
    parsed.and_then(|mut table| table.remove("value")).unwrap_or_else(|| text.into())
}

pub(in crate::scene) fn flatten(prefix: &str, table: Table, fields: &mut Vec<(String, Value)>) {
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
    use super::*;
    use crate::scene::schema::Changes;
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
    fn typed_fields_are_those_of_the_file() {
        let mut scene = preset("fur").unwrap();
        scene.set_field("parts.b.transform.at", "[1, 2, 0.5]").unwrap();
        scene.set_field("animation.camera.pan", "['time', '0']").unwrap();
        scene.set_field("modules.dmf/own", "own.glsl").unwrap();
        scene.set_field("parts.b.parameters.fineness", "3").unwrap();
        let mut read = Vec::new();
        flatten("", Table::try_from(&scene).unwrap(), &mut read);
        assert_eq!(scene.fields(), read);
        let mut other = Scene::default();
        for (name, value) in scene.fields() {
            let field = FieldId::named(&name).unwrap();
            assert_eq!((field.to_string(), scene.value(&field)), (name.clone(), Some(value.clone())));
            other.insert(&name, Some(value)).unwrap();
        }
        assert_eq!(other, scene);
        assert!(
            ["camera", "camera.", "camera.x", "parts.b", "parts.b.camera.zoom", "animation.about", ""]
                .into_iter()
                .all(|name| FieldId::named(name).is_none())
        );
    }

    #[test]
    fn changes_are_those_of_the_settings() {
        let scene = preset("fur").unwrap();
        for (field, value, expected) in [
            ("object.resolution", "17", &[Changes::Field][..]),
            ("effect.octaves", "3", &[Changes::Images]),
            ("quality.target", "unorm8", &[Changes::Targets]),
            ("image.size", "[3, 4]", &[Changes::Size]),
            ("camera.azimuth", "3", &[Changes::View]),
            ("parameters.fineness", "3", &[Changes::Picture]),
            ("modules.dmf/own", "own.glsl", &[Changes::Images]),
            ("parts.b.hidden", "true", &[Changes::Field, Changes::Images, Changes::Picture]),
            ("camera.azimuth", "30", &[]),
        ] {
            let mut other = scene.clone();
            (other.camera.azimuth, other.object.resolution) = (30.0, 16);
            let base = other.clone();
            other.set_field(field, value).unwrap();
            assert_eq!(other.changes(&base), ChangeSet::of(expected), "{field}");
            assert_eq!(base.changes(&other), ChangeSet::of(expected), "{field}");
        }
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
