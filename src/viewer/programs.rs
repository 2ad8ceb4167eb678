//! The programs of a scene, and which files are in them.

use crate::render::variant::{Variant, VariantError};
use crate::scene::Scene;
use crate::shader::Library;

/// What a scene would link: its picture, and its shadows where it casts some.
pub(super) fn programs(scene: &Scene, library: &Library) -> Result<Vec<Variant>, VariantError> {
    let picture = Variant::of(scene, library)?;
    let shadow = scene.light.shadows.then(|| picture.shadow(scene, library)).transpose()?;
    Ok([picture].into_iter().chain(shadow).collect())
}

/// Whether the file is among those that a program is linked from.
pub(super) fn reaches(variant: &Variant, library: &Library, path: &str) -> bool {
    let is_it = |file: &String| file.split('#').next() == Some(path);
    let filled = |(key, names): (&String, &Vec<String>)| {
        let slot = key.rsplit('.').next().unwrap_or_default();
        library.files(slot, names).is_ok_and(|files| files.iter().any(is_it))
    };
    variant.slots.iter().any(filled)
}
