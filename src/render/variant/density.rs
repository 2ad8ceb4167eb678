//! Programs of matter itself: the opacity is the density, and the color that of the matter.

use super::scene_variant::Variant;
use crate::scene::{Color, Scene};
use crate::shader::{Library, find_word, tokens};
use std::sync::Arc;

/// Opacity module that returns the density, whatever the path.
const DENSITY: &str = "// The density in place of the opacity of a path.
float opacity(float density, float amount) { return density; }
float segment_opacity(float d0, float d1, float amount) { return 0.5 * (d0 + d1); }
";

/// Extinction where the density is 1, which is infinite.
const OPAQUE: f32 = 1e30;

/// A program of a scene with the density in place of the opacity, and its library.
pub(crate) fn as_density(library: &Library, variant: &Variant) -> (Library, Variant) {
    with_opacity(library, variant, "density", DENSITY)
}

/// A program of a scene with the extinction per object unit in place of the opacity, and its library: above 1e29 where it is
/// infinite.
pub(crate) fn as_extinction(library: &Library, variant: &Variant) -> (Library, Variant) {
    let own = variant.module("opacity").and_then(|name| library.source(&format!("opacity/{name}.glsl")));
    let own: String =
        tokens(own.unwrap_or_default()).map(|word| if word == "opacity" { "opacity_of_path" } else { word }).collect();
    // Of a short path of the scene's own opacity: its logarithm cancels nothing, and it never rounds to 1 below a density of 1.
    let module = format!(
        "{own}\n#include \"exponential.glsl\"\n\
         float opacity(float density, float amount) {{\n    \
         float alpha = opacity_of_path(density, 0.01);\n    \
         return alpha >= 1.0 ? {OPAQUE:e} : -100.0 * log_one_minus(alpha) * (amount / step_size);\n}}\n"
    );
    with_opacity(library, variant, "extinction", &module)
}

fn with_opacity(library: &Library, variant: &Variant, name: &str, module: &str) -> (Library, Variant) {
    let mut variant = variant.clone();
    Arc::make_mut(&mut variant.slots).entry("opacity".into()).and_modify(|names| *names = vec![name.into()]);
    (library.clone().with_module("opacity", name, module), variant)
}

/// The scene in white ambient light alone. A medium that reads the light but no ambient light keeps the scene's own.
pub(crate) fn unlit(scene: &Scene, library: &Library) -> Scene {
    let mut scene = scene.clone();
    scene.light.shadows = false;
    let has_own_light = |name: &str| {
        let text = library.source(&format!("medium/{}.glsl", name.trim())).unwrap_or_default();
        let names = |member: &str| find_word(text, |word| word == member).is_some();
        names("light_color") && !names("ambient_color")
    };
    if !scene.effect.medium.split('+').any(has_own_light) {
        (scene.light.intensity, scene.light.ambient) = (0.0, Color([255; 3]));
    }
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::preset;
    use crate::shader;

    #[test]
    fn media_with_a_light_of_their_own_keep_it() {
        let unlit = |text: &str| {
            let mut scene = preset("fire").unwrap();
            scene.effect.medium = "mine".into();
            unlit(&scene, &shader::shipped().with_module("medium", "mine", text)).light.intensity == 0.0
        };
        let lit = "vec3 medium(Sample s, float density) { return light_color.rgb; }";
        assert!(!unlit(lit) && !unlit(&format!("// ambient_color is not read\n{lit}")));
        assert!(unlit("vec3 medium(Sample s, float density) { return vec3(1.0); } // no light_color"));
        assert!(unlit(&lit.replace("light_color", "(light_color + ambient_color)")));
    }
}
