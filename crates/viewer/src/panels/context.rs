//! State that all panels share while the controls are shown.

use super::status::Status;
use super::widgets::Touch;
use crate::document::model::Model;
use crate::input::Command;
use egui::Ui;
use hypertexture::scene::{Effect, ParameterValue, Scene, Transfer};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Opacity of the controls of settings that the picture does not read.
const UNREAD: f32 = 0.45;

/// One pass over the controls.
pub(super) struct Pass<'a> {
    /// The scene with the changes of the controls.
    pub(super) draft: Scene,
    /// The scene before the pass.
    pub(super) before: Arc<Scene>,
    /// Values that controls show in place of those of the scene, by field.
    pub(super) shown: BTreeMap<String, toml::Value>,
    /// Why a value was refused.
    pub(super) refused: Option<String>,
    pub(super) touch: Touch,
    pub(super) commands: Vec<Command>,
    pub(super) model: &'a Model,
    pub(super) status: &'a Status,
    pub(super) advanced: bool,
    /// Whether controls have diamonds for keyframes.
    pub(super) keys: bool,
}

impl Pass<'_> {
    /// Shows the controls of a setting, dimmed if the picture does not read it.
    pub(super) fn dimmed(&mut self, ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui, &mut Self)) {
        // The angles stand for the rotation.
        let is_read =
            ["camera.azimuth", "camera.elevation"].contains(&name) || self.status.idle.iter().all(|idle| idle != name);
        let opacity = ui.opacity();
        ui.multiply_opacity(if is_read { 1.0 } else { UNREAD });
        add(ui, self);
        ui.set_opacity(opacity);
    }

    /// The value of a field before the pass; `None` if it has none.
    pub(super) fn value(&self, name: &str) -> Option<toml::Value> {
        self.shown.get(name).cloned().or_else(|| self.before.value_named(name))
    }

    /// Sets a field to a value in the syntax of scene files; an empty one removes the field.
    pub(super) fn set(&mut self, name: &str, value: &str) {
        match self.draft.set_field(name, value) {
            Ok(()) => self.touch = Some(name.into()),
            Err(error) => self.refused = Some(error.to_string()),
        }
    }
}

/// Fields that each object has.
pub(super) struct ObjectFields<'a> {
    pub(super) effect: &'a mut Effect,
    pub(super) parameters: &'a mut BTreeMap<String, ParameterValue>,
    pub(super) transfer: &'a mut Transfer,
}

/// Fields of the main object, or of an additional one.
pub(super) fn object_fields<'a>(scene: &'a mut Scene, part: Option<&str>) -> ObjectFields<'a> {
    match part.and_then(|part| scene.parts.get_mut(part)) {
        Some(part) => {
            ObjectFields { effect: &mut part.effect, parameters: &mut part.parameters, transfer: &mut part.transfer }
        }
        None => {
            ObjectFields { effect: &mut scene.effect, parameters: &mut scene.parameters, transfer: &mut scene.transfer }
        }
    }
}

/// Prefix of the names of these fields in a scene file.
pub(super) fn prefix(part: Option<&str>) -> String {
    part.map(|part| format!("parts.{part}.")).unwrap_or_default()
}
