//! The scenes that ship with the program.

use super::{Scene, SceneError, file};

/// Names of the six effects of MJ Fig. 7, in its order.
pub const EFFECTS: [&str; 6] = ["lit", "solid", "bump", "fur", "melting", "fire"];

/// Presets by their names, in this order.
macro_rules! shipped {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../../presets/", $name, ".toml")))),+]
    };
}

/// Every preset: name and text.
#[rustfmt::skip] // it would give each name a line
pub(super) const PRESETS: &[(&str, &str)] = shipped![
    "lit", "solid", "bump", "fur", "melting", "fire", "shells", "noisy_sphere", "high_frequency_sphere",
    "high_amplitude_sphere", "fractal_sphere", "dripping_sphere", "fire_ball", "furry_donut", "tribble",
    "furry_teapot", "burning_head", "smoke", "clouds", "woven", "flow", "glow", "nebula", "eroded_cube", "weathered",
    "tank", "burning_bush", "ensemble", "blue_glass", "wax",
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

/// The preset that a scene differs from in the fewest fields, with its input and additional objects: what was set in it is
/// told from that.
pub fn nearest_preset(scene: &Scene) -> Scene {
    let fields = scene.fields();
    let over = |name: &str| -> Option<Scene> {
        let mut base = preset(name).ok()?;
        base.object.input.clone_from(&scene.object.input);
        base.parts.clone_from(&scene.parts);
        base.combine.clone_from(&scene.combine);
        Some(base)
    };
    let differ = |base: &Scene| {
        let own = base.fields();
        fields.iter().filter(|field| !own.contains(field)).count()
    };
    names().filter_map(over).min_by_key(differ).unwrap_or_default()
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
    use crate::shader;

    #[test]
    fn m53_every_preset_is_a_valid_scene_about_something() {
        for (name, _) in PRESETS {
            let scene = preset(name).unwrap();
            scene.check(&shader::shipped()).unwrap();
            assert!(!scene.about.is_empty(), "{name}");
        }
        assert!(EFFECTS.iter().all(|effect| preset(effect).is_ok()));
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/presets");
        assert_eq!(std::fs::read_dir(folder).unwrap().count(), PRESETS.len(), "a file that is no preset yet");
    }

    #[test]
    fn an_unknown_preset_suggests_the_nearest() {
        let error = preset("meltin").unwrap_err().to_string();
        assert!(error.starts_with("no effect `meltin` (did you mean `melting`?); choose one of: lit, "), "{error}");
    }
}
