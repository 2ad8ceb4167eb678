//! Which programs a changed module is tried in.

use super::compile::Job;
use crate::glsl::Library;
use crate::scene::{Pass, Scene};
use crate::variant::{Variant, VariantError};

/// The programs of the scene, if the module is in them, else those of the nearest scene that has it. None where no scene
/// can have it.
pub(super) fn job(scene: &Scene, library: &Library, slot: &str, name: &str) -> Result<Option<Job>, VariantError> {
    let path = format!("{slot}/{name}.glsl");
    let mut refused = None;
    for scene in candidates(scene, slot, name) {
        match programs(&scene, library) {
            Ok(variants) if variants.iter().any(|variant| reaches(variant, library, &path)) => {
                return Ok(Some(Job::new(library, &variants)));
            }
            Ok(_) => {}
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    refused.map_or(Ok(None), Err)
}

/// What a scene would link: its picture, and its shadows where it casts some.
pub(in crate::view) fn programs(scene: &Scene, library: &Library) -> Result<Vec<Variant>, VariantError> {
    let picture = Variant::of(scene, library)?;
    let shadow = scene.light.shadows.then(|| picture.shadow(scene, library)).transpose()?;
    Ok([picture].into_iter().chain(shadow).collect())
}

/// The scene, then with the module put in, then reduced to what needs it.
fn candidates(scene: &Scene, slot: &str, name: &str) -> Vec<Scene> {
    let with = |mut scene: Scene| {
        use_module(&mut scene, slot, name);
        scene
    };
    let mut soft = Scene { object: scene.object.clone(), ..Scene::default() };
    (soft.effect.classify, soft.effect.softness, soft.effect.medium) = ("soft".into(), "linear".into(), "lit".into());
    let mut rays = soft.clone();
    rays.quality.pass = Pass::March;
    // What bends rays is read by nothing else.
    let glass = crate::scene::preset("blue_glass").unwrap_or_default();
    [scene.clone(), with(scene.clone()), with(soft), with(rays), with(glass)].into()
}

/// Whether the file is among those that a program is linked from.
pub(in crate::view) fn reaches(variant: &Variant, library: &Library, path: &str) -> bool {
    let is_it = |file: &String| file.split('#').next() == Some(path);
    let filled = |(key, names): (&String, &Vec<String>)| {
        let slot = key.rsplit('.').next().unwrap_or_default();
        library.files(slot, names).is_ok_and(|files| files.iter().any(is_it))
    };
    variant.slots.iter().any(filled)
}

/// Puts a module into its slot: last in a stack, in place of the other elsewhere; a mask goes onto the last DMF.
pub(super) fn use_module(scene: &mut Scene, slot: &str, name: &str) {
    let effect = &mut scene.effect;
    match slot {
        "warp" => effect.warp.push(name.into()),
        "dmf" => effect.dmf.push(name.into()),
        "mask" => {
            let last = effect.dmf.pop().unwrap_or_else(|| "biased".into());
            effect.dmf.push(format!("{}@{name}", last.split('@').next().unwrap_or_default()));
        }
        _ => {
            // A slot that is no field of the scene, such as `clip`, is filled by another choice: nothing to put in.
            let _ = scene.set_field(&format!("effect.{slot}"), name);
        }
    }
}
