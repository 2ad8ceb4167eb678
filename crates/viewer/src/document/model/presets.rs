//! Presets, with or without their object and view, and default values of parameters.

use super::state::Model;
use hypertexture::scene::{self, Axis, Color, Object, ParameterValue, Scene};
use hypertexture::shader::{Parameter, ParameterKind};
use std::path::Path;
use std::sync::LazyLock;

/// The preset that colors overhangs and thin walls.
const PRINTABLE: &str = "printable";

static PRESETS: LazyLock<Vec<(&str, Scene)>> =
    LazyLock::new(|| scene::names().filter_map(|name| Some((name, scene::preset(name).ok()?))).collect());

impl Model {
    /// Takes a preset. With `on_object`, object, camera and picture size stay; the extent of the soft region is the
    /// preset's.
    pub fn take_preset(&mut self, name: &str, on_object: bool) -> bool {
        let mut preset = match scene::preset(name) {
            Ok(preset) => preset,
            Err(error) => {
                self.say(error.to_string());
                return false;
            }
        };
        let Scene { object, camera, image, .. } = Scene::clone(&self.scene); // the window has a size of its own
        preset.image = image;
        if on_object {
            preset.replace_object(&object.input); // and what is aligned with it
            let Object { inner_iso, outer_iso, .. } = preset.object;
            (preset.object, preset.camera) = (Object { inner_iso, outer_iso, ..object }, camera);
        }
        let good = self.propose(&format!("preset {name}"), preset);
        self.end_undo_group();
        if good && !on_object {
            self.home.clone_from(&self.scene.camera);
        }
        good
    }

    /// Begins a scene of a preset with a change, in the picture size of the window.
    pub(super) fn begin_with(&mut self, what: &str, preset: &str, change: impl FnOnce(&mut Scene)) -> bool {
        let mut scene = match scene::preset(preset) {
            Ok(preset) => preset,
            Err(error) => {
                self.say(error.to_string());
                return false;
            }
        };
        change(&mut scene);
        scene.image = self.scene.image.clone();
        let good = self.propose(what, scene);
        self.end_undo_group();
        if good {
            self.set_saved(self.scene.clone());
            self.file = None;
            self.home.clone_from(&self.scene.camera);
        }
        good
    }

    /// Begins a scene of a written print, with overhangs and thin walls colored.
    pub(crate) fn look_at_print(&mut self, file: &Path, up: Axis) -> bool {
        let name = file.display().to_string();
        self.begin_with(&format!("look at {name}"), PRINTABLE, |scene| {
            scene.replace_object(&name);
            scene.object.up = up;
        })
    }

    /// Takes effect, parameters, material, transfer map and soft region of a preset for an additional object.
    pub fn take_preset_of_part(&mut self, part: &str, name: &str) -> bool {
        let preset = match scene::preset(name) {
            Ok(preset) => preset,
            Err(error) => {
                self.say(error.to_string());
                return false;
            }
        };
        let good = self.edit(&format!("preset {name} of {part}"), |scene| {
            let Some(part) = scene.parts.get_mut(part) else { return };
            let Scene { effect, parameters, material, transfer, object, .. } = preset;
            (part.effect, part.parameters, part.material, part.transfer) = (effect, parameters, material, transfer);
            (part.object.inner_iso, part.object.outer_iso) = (object.inner_iso, object.outer_iso);
        });
        self.end_undo_group();
        good
    }

    /// The preset of the scene, identified by its description.
    pub fn preset(&self) -> Option<&'static str> {
        Some(self.own_preset()?.0)
    }

    fn own_preset(&self) -> Option<&'static (&'static str, Scene)> {
        PRESETS.iter().find(|(_, preset)| preset.about == self.scene.about)
    }

    /// The value of a field in the preset of the scene, else its default; `None` for a field without one.
    pub fn field_in_preset(&self, name: &str) -> Option<toml::Value> {
        let mut base = self.own_preset().map_or_else(Scene::default, |(_, preset)| preset.clone());
        if let Some((part, _)) = name.strip_prefix("parts.").and_then(|rest| rest.split_once('.')) {
            base.parts.entry(part.into()).or_default();
        }
        base.value_named(name)
    }

    /// The value of a parameter in the preset of the scene, else the default of its module.
    pub fn parameter_in_preset(&self, part: Option<&str>, parameter: &Parameter) -> ParameterValue {
        let values = self.own_preset().and_then(|(_, preset)| match part {
            None => Some(&preset.parameters),
            Some(part) => preset.parts.get(part).map(|part| &part.parameters),
        });
        match (parameter.kind, values.and_then(|values| values.get(&parameter.name))) {
            (ParameterKind::Number(..), Some(value @ ParameterValue::Number(_)))
            | (ParameterKind::Color(_), Some(value @ ParameterValue::Color(_))) => value.clone(),
            (ParameterKind::Number(value, _), _) => ParameterValue::Number(value),
            (ParameterKind::Color(code), _) => ParameterValue::Color(Color(code)),
        }
    }
}
