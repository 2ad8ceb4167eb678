//! Presets.

use super::preset_texts::{names, text};
use super::{Scene, SceneError, parse};
use std::collections::BTreeMap;
use std::sync::{LazyLock, OnceLock};

/// The six effects of MJ Fig. 7, in its order.
pub const EFFECTS: [&str; 6] = ["lit", "solid", "bump", "fur", "melting", "fire"];

/// The preset of that name.
///
/// # Errors
/// [`SceneError::Name`] with the nearest name and all of them.
pub fn preset(name: &str) -> Result<Scene, SceneError> {
    static PARSED: LazyLock<BTreeMap<&str, OnceLock<Scene>>> =
        LazyLock::new(|| names().map(|name| (name, OnceLock::new())).collect());
    let (text, parsed) = (text(name)?, &PARSED[name]);
    if let Some(scene) = parsed.get() {
        return Ok(scene.clone());
    }
    let scene = parse(text, &format!("preset {name}"))?;
    Ok(parsed.get_or_init(|| scene).clone())
}

/// The preset with the fewest differences from a scene, with the input and additional objects of the scene. The base for
/// lists of changed settings.
pub fn nearest_preset(scene: &Scene) -> Scene {
    let over = |name: &str| -> Option<Scene> {
        let mut base = preset(name).ok()?;
        base.replace_object(&scene.object.input);
        base.parts.clone_from(&scene.parts);
        base.combine.clone_from(&scene.combine);
        Some(base)
    };
    let differ = |base: &Scene| scene.difference(base).iter().filter(|(_, value)| value.is_some()).count();
    names().filter_map(over).min_by_key(differ).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ParameterValue;
    use crate::shader;

    #[test]
    fn m53_every_preset_is_a_valid_scene_about_something() {
        for name in names() {
            let scene = preset(name).unwrap();
            scene.check(&shader::shipped()).unwrap();
            assert!(!scene.about.is_empty(), "{name}");
        }
        assert!(EFFECTS.iter().all(|effect| preset(effect).is_ok()));
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/presets");
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let scenes = files.filter(|path| path.extension().is_some_and(|extension| extension == "toml")).count();
        assert_eq!(scenes, names().count(), "a file that is no preset yet");
    }

    #[test]
    fn skin_under_fur_is_dark_and_has_no_highlight() {
        let mut furry = 0;
        for name in names() {
            let scene = preset(name).unwrap();
            let Some(ParameterValue::Color(root)) = scene.parameters.get("root_color") else { continue };
            if scene.effect.dmf.iter().any(|dmf| dmf.contains('@')) {
                continue; // elsewhere it is bare
            }
            let light = |color: crate::scene::Color| color.linear().iter().sum::<f32>();
            assert_eq!(scene.material.specular, 0.0, "{name}");
            assert!(light(scene.material.color) <= light(*root), "{name}");
            furry += 1;
        }
        assert!(furry >= 6, "{furry} presets");
    }

    #[test]
    fn an_unknown_preset_suggests_the_nearest() {
        let error = preset("meltin").unwrap_err().to_string();
        assert!(error.starts_with("no effect `meltin` (did you mean `melting`?); choose one of: lit, "), "{error}");
    }
}
