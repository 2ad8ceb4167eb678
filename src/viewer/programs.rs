//! The programs of a scene.

use crate::render::variant::{Variant, VariantError};
use crate::scene::Scene;
use crate::shader::Library;

/// What a scene would link: its picture, and its shadows where it casts some.
pub(super) fn programs(scene: &Scene, library: &Library) -> Result<Vec<Variant>, VariantError> {
    let picture = Variant::of(scene, library)?;
    let shadow = scene.light.shadows.then(|| picture.shadow(scene, library)).transpose()?;
    Ok([picture].into_iter().chain(shadow).collect())
}
