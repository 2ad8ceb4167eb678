//! Texts of the presets.

use super::SceneError;

/// Presets by their names, in this order.
macro_rules! shipped {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../../presets/", $name, ".toml")))),+]
    };
}

/// Every preset: name and text.
#[rustfmt::skip] // it would give each name a line
const PRESETS: &[(&str, &str)] = shipped![
    "lit", "solid", "bump", "fur", "melting", "fire", "shells", "anatomy", "noisy_sphere", "high_frequency_sphere",
    "high_amplitude_sphere", "fractal_sphere", "dripping_sphere", "fire_ball", "furry_donut", "tribble",
    "furry_teapot", "coat", "burning_head", "smoke", "clouds", "woven", "flow", "glow", "nebula", "eroded_cube", "weathered",
    "tank", "burning_bush", "ensemble", "blue_glass", "wax",
    "stone", "bark", "knurl", "hammered", "leather", "fuzzy_skin", "printable",
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
