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
    ("noisy_sphere", include_str!("../../presets/noisy_sphere.toml")),
    ("high_frequency_sphere", include_str!("../../presets/high_frequency_sphere.toml")),
    ("high_amplitude_sphere", include_str!("../../presets/high_amplitude_sphere.toml")),
    ("fractal_sphere", include_str!("../../presets/fractal_sphere.toml")),
    ("dripping_sphere", include_str!("../../presets/dripping_sphere.toml")),
    ("fire_ball", include_str!("../../presets/fire_ball.toml")),
    ("furry_donut", include_str!("../../presets/furry_donut.toml")),
    ("tribble", include_str!("../../presets/tribble.toml")),
    ("furry_teapot", include_str!("../../presets/furry_teapot.toml")),
    ("burning_head", include_str!("../../presets/burning_head.toml")),
    ("smoke", include_str!("../../presets/smoke.toml")),
    ("clouds", include_str!("../../presets/clouds.toml")),
    ("woven", include_str!("../../presets/woven.toml")),
    ("flow", include_str!("../../presets/flow.toml")),
    ("glow", include_str!("../../presets/glow.toml")),
    ("nebula", include_str!("../../presets/nebula.toml")),
    ("eroded_cube", include_str!("../../presets/eroded_cube.toml")),
    ("weathered", include_str!("../../presets/weathered.toml")),
    ("tank", include_str!("../../presets/tank.toml")),
    ("burning_bush", include_str!("../../presets/burning_bush.toml")),
    ("ensemble", include_str!("../../presets/ensemble.toml")),
    ("blue_glass", include_str!("../../presets/blue_glass.toml")),
    ("wax", include_str!("../../presets/wax.toml")),
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
    }

    #[test]
    fn an_unknown_preset_suggests_the_nearest() {
        let error = preset("meltin").unwrap_err().to_string();
        assert!(error.starts_with("no effect `meltin` (did you mean `melting`?); choose one of: lit, "), "{error}");
    }
}
