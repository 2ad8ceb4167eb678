//! Programs of matter itself: the opacity is the density, and the color that of the matter.

use super::scene_variant::Variant;
use crate::scene::{Color, Scene};
use crate::shader::Library;

/// Opacity module that returns the density, whatever the path.
const DENSITY: &str = "// The density in place of the opacity of a path.
float opacity(float density, float amount) { return density; }
float segment_opacity(float d0, float d1, float amount) { return 0.5 * (d0 + d1); }
";

/// A program of a scene with the density in place of the opacity, and its library.
pub(crate) fn as_density(library: &Library, variant: &Variant) -> (Library, Variant) {
    let mut variant = variant.clone();
    variant.slots.entry("opacity".into()).and_modify(|names| *names = vec!["density".into()]);
    (library.clone().with_module("opacity", "density", DENSITY), variant)
}

/// The scene in white ambient light alone. A medium that reads the light but no ambient light keeps the scene's own.
pub(crate) fn unlit(scene: &Scene, library: &Library) -> Scene {
    let mut scene = scene.clone();
    scene.light.shadows = false;
    let text = |name: &str| library.source(&format!("medium/{}.glsl", name.trim())).unwrap_or_default();
    let has_own_light = |name: &str| text(name).contains("light_color") && !text(name).contains("ambient_color");
    if !scene.effect.medium.split('+').any(has_own_light) {
        (scene.light.intensity, scene.light.ambient) = (0.0, Color([255; 3]));
    }
    scene
}
