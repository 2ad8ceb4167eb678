//! Programs linked before they are asked for.

use crate::measure::compare::candidates::Candidate;
use crate::render::variant::{Variant, VariantError};
use crate::scene::{Integration, Pass, Scene};
use crate::shader::{Library, Linker};
use std::sync::Once;

/// Links the programs of curves that are surely drawn, while those before them are: the worker finds them on the disk.
pub(super) fn link_ahead(families: &[Candidate], library: &Library, links: &[Once]) {
    let Some(own) = families.first().map(|first| &first.strategy) else { return };
    for (Candidate { scene, strategy, .. }, once) in families.iter().zip(links) {
        let method = (scene.quality.pass, scene.quality.integration);
        let is_sure = method == (Pass::March, Integration::Point)
            || strategy == own && method != (Pass::Slices, Integration::Segment);
        if is_sure {
            once.call_once(|| link(scene, library));
        }
    }
}

/// Links what a scene is drawn with; what cannot be linked is said where it is drawn.
pub(super) fn link(scene: &Scene, library: &Library) {
    let link = || -> Result<(), VariantError> {
        let variant = Variant::of(scene, library)?;
        let program = variant.program(library, Linker::new)?;
        for (image, other) in [("shadow_image", Variant::shadow as fn(&_, &_, &_) -> _), ("cell_image", Variant::cells)]
        {
            if program.reads(image) {
                other(&variant, scene, library)?.program(library, Linker::new)?;
            }
        }
        Ok(())
    };
    let _ = link();
}
