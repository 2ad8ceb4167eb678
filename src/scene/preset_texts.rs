//! The texts of the scenes that ship with the program.

use super::SceneError;

/// Every preset: name and text.
const PRESETS: &[(&str, &str)] = &[
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

/// Text of the preset of that name.
pub(super) fn text(name: &str) -> Result<&'static str, SceneError> {
    let found = PRESETS.iter().find(|(known, _)| *known == name);
    found.map(|(_, text)| *text).ok_or_else(|| {
        let known: Vec<_> = PRESETS.iter().map(|(known, _)| *known).collect();
        SceneError::unknown("effect", name, &known)
    })
}
