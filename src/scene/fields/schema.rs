//! All settings of a scene.
//!
//! Role: [`SETTINGS`] determines the ranges that scenes are checked by, the flags of the command line and their help, the
//! controls of the window, the commands that it copies, the stages that a change rebuilds, and `docs/settings.md`.

use crate::scene::{
    Animation, Camera, Effect, Light, Material, Object, Part, Picture, Quality, Scene, Transfer, Transform,
};
use std::sync::LazyLock;

pub use super::setting::{ChangeSet, Changes, Filled, Flag, Kind, Range, Setting, Unit, float};

/// Every setting, in the order of the window and the documentation.
pub static SETTINGS: LazyLock<Vec<Setting>> = LazyLock::new(|| {
    [
        Scene::SETTINGS,
        Part::SETTINGS,
        Object::SETTINGS,
        Transform::SETTINGS,
        Effect::SETTINGS,
        Transfer::SETTINGS,
        Material::SETTINGS,
        Light::SETTINGS,
        Camera::SETTINGS,
        Picture::SETTINGS,
        Animation::SETTINGS,
        Quality::SETTINGS,
    ]
    .concat()
});

/// The setting with this name; an additional object has those of the object of the scene.
pub fn setting(name: &str) -> Option<&'static Setting> {
    let own = name.strip_prefix("parts.").and_then(|rest| Some(rest.split_once('.')?.1)).unwrap_or(name);
    SETTINGS.iter().find(|setting| setting.name == own)
}

/// Slots whose modules a scene names.
pub fn slots() -> impl Iterator<Item = (&'static str, Filled)> {
    SETTINGS.iter().filter_map(|setting| match setting.kind {
        Kind::Module(filled) => Some((setting.field(), filled)),
        Kind::Stack => Some((setting.field(), Filled::ByObject)),
        _ => None,
    })
}

/// Whether all objects of a scene share the module of a slot.
pub fn is_shared(slot: &str) -> bool {
    slots().any(|shared| shared == (slot, Filled::ByScene))
}

#[cfg(test)]
mod tests;
