//! The scenes that ship with the program.

use super::{Scene, SceneError, file};

/// Names of the six effects of MJ Fig. 7, in its order.
pub const EFFECTS: [&str; 6] = ["lit", "solid", "bump", "fur", "melting", "fire"];

/// Every preset: name and text.
pub(super) const PRESETS: &[(&str, &str)] = &[
    ("lit", include_str!("../../presets/lit.toml")),
    ("solid", include_str!("../../presets/solid.toml")),
    ("bump", include_str!("../../presets/bump.toml")),
    ("fur", include_str!("../../presets/fur.toml")),
    ("melting", include_str!("../../presets/melting.toml")),
    ("fire", include_str!("../../presets/fire.toml")),
    ("shells", include_str!("../../presets/shells.toml")),
    ("blue_glass", include_str!("../../presets/blue_glass.toml")),
];

/// Names of all presets.
pub fn names() -> impl Iterator<Item = &'static str> {
    PRESETS.iter().map(|(name, _)| *name)
}

/// The preset of that name.
///
/// # Errors
/// [`SceneError::Name`] with the nearest name and all of them.
pub fn preset(name: &str) -> Result<Scene, SceneError> {
    file::parse(text(name)?, &format!("preset {name}"))
}

/// Text of the preset of that name.
pub(super) fn text(name: &str) -> Result<&'static str, SceneError> {
    let found = PRESETS.iter().find(|(known, _)| *known == name);
    found.map(|(_, text)| *text).ok_or_else(|| {
        let known: Vec<_> = PRESETS.iter().map(|(known, _)| *known).collect();
        SceneError::unknown("effect", name, &known)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glsl;

    #[test]
    fn m53_every_preset_is_a_valid_scene_about_something() {
        for (name, _) in PRESETS {
            let scene = preset(name).unwrap();
            scene.check(&glsl::shipped()).unwrap();
            assert!(!scene.about.is_empty(), "{name}");
        }
        assert!(EFFECTS.iter().all(|effect| preset(effect).is_ok()));
    }

    #[test]
    fn an_unknown_preset_suggests_the_nearest() {
        let error = preset("meltin").unwrap_err().to_string();
        assert!(error.starts_with("no effect `meltin` (did you mean `melting`?); choose one of: lit, "), "{error}");
    }
}
