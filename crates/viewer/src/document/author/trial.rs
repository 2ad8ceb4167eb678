//! Scenes in which a changed module is tested.

use hypertexture::render::variant::VariantError;
use hypertexture::scene::{Pass, Scene};
use hypertexture::shader::Library;
use hypertexture::shader::declare::declaration;
use hypertexture_measure::guard::programs;
use std::collections::BTreeSet;

/// The first scene whose programs include the module: the current one, or a similar one. `None` if no scene does.
pub(super) fn scene_with(
    scene: &Scene,
    library: &Library,
    slot: &str,
    name: &str,
) -> Result<Option<Scene>, VariantError> {
    let path = format!("{slot}/{name}.glsl");
    let mut refused = None;
    for scene in candidates(scene, library, slot, name) {
        match programs(&scene, library) {
            Ok(variants) if variants.iter().any(|variant| variant.reaches(library, &path)) => {
                return Ok(Some(scene));
            }
            Ok(_) => {}
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    refused.map_or(Ok(None), Err)
}

/// The scene, the scene with the module, and simpler scenes with the module.
fn candidates(scene: &Scene, library: &Library, slot: &str, name: &str) -> Vec<Scene> {
    let with = |mut scene: Scene| {
        use_module(&mut scene, library, slot, name);
        scene
    };
    let mut soft = Scene { object: scene.object.clone(), ..Scene::default() };
    (soft.effect.classify, soft.effect.softness, soft.effect.medium) = ("soft".into(), "linear".into(), "lit".into());
    let mut rays = soft.clone();
    rays.quality.pass = Pass::March;
    // Only refracting scenes read refraction modules.
    let glass = hypertexture::scene::preset("blue_glass").unwrap_or_default();
    [scene.clone(), with(scene.clone()), with(soft), with(rays), with(glass)].into()
}

/// Puts a module into its slot: at the end of a stack, else in place of the current one; a mask goes onto the last
/// DMF. A copy replaces its original, whose parameters and functions have the same names.
pub(super) fn use_module(scene: &mut Scene, library: &Library, slot: &str, name: &str) {
    let effect = &mut scene.effect;
    let stacked = |stack: &mut Vec<String>| {
        let names = |module: &str| declared(library.source(&format!("{slot}/{module}.glsl")).unwrap_or_default());
        let own = names(name);
        let original = |entry: &&mut String| !own.is_disjoint(&names(entry.split('@').next().unwrap_or_default()));
        match stack.iter_mut().find(original) {
            Some(entry) => {
                let mask = entry.split_once('@').map_or(String::new(), |(_, mask)| format!("@{mask}"));
                *entry = format!("{name}{mask}");
            }
            None => stack.push(name.into()),
        }
    };
    match slot {
        "warp" => stacked(&mut effect.warp),
        "dmf" => stacked(&mut effect.dmf),
        "mask" => {
            let last = effect.dmf.pop().unwrap_or_else(|| "biased".into());
            effect.dmf.push(format!("{}@{name}", last.split('@').next().unwrap_or_default()));
        }
        _ => {
            // Slots such as `clip` are not fields of the scene.
            let _ = scene.set_field(&format!("effect.{slot}"), name);
        }
    }
}

/// Names of the parameters and functions that a text declares.
fn declared(text: &str) -> BTreeSet<&str> {
    let name = |line| -> Option<&str> {
        if let Some((_, parameter)) = declaration(line).filter(|(kind, _)| ["param", "color"].contains(kind)) {
            return parameter.trim_start().split([' ', '=']).next();
        }
        let (head, _) = line.split_once('(').filter(|(head, _)| head.starts_with(|c: char| c.is_ascii_alphabetic()))?;
        let (_, name) = head.trim_end().split_once(' ')?;
        Some(name.trim())
    };
    text.lines().filter_map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::shader;

    #[test]
    fn a_copy_replaces_its_original_and_others_come_last() {
        let shipped = shader::shipped();
        let fur = shipped.source("dmf/fur.glsl").unwrap();
        let plain = "float plain(float density, Sample s) {\n    return density;\n}\n";
        let library = shipped.clone().with_module("dmf", "pelt", fur).with_module("dmf", "plain", plain);
        let stack = |name: &str| {
            let mut scene = hypertexture::scene::preset("fur").unwrap();
            scene.effect.dmf = vec!["noisy".into(), "fur@height".into()];
            use_module(&mut scene, &library, "dmf", name);
            scene.effect.dmf
        };
        assert_eq!(stack("pelt"), ["noisy", "pelt@height"]);
        assert_eq!(stack("plain"), ["noisy", "fur@height", "plain"]);
        assert_eq!(declared(plain), BTreeSet::from(["plain"]));
        assert!(declared(fur).contains("hair_length"));
    }
}
