//! A checked scene with its matrices, planes and light space.

use super::light_space::LightSpace;
use super::planes::SlicePlanes;
use super::view::View;
use crate::render::subject::Subject;
use crate::render::variant::{Variant, VariantError};
use crate::scene::Scene;
use crate::shader::Library;

#[derive(Clone)]
pub(crate) struct FrameContext {
    pub(crate) scene: Scene,
    pub(crate) subject: Subject,
    pub(crate) variant: Variant,
    pub(crate) view: View,
    pub(crate) planes: SlicePlanes,
    pub(crate) space: LightSpace,
    /// Size of the full picture of which this one is a preview.
    pub(crate) whole: [u32; 2],
}

impl FrameContext {
    /// Checks a scene and computes its context.
    pub(crate) fn new(scene: &Scene, subject: &Subject, library: &Library) -> Result<FrameContext, VariantError> {
        Ok(FrameContext::with_variant(scene, subject, Variant::of(scene, library)?))
    }

    /// Computes the context of a scene that is drawn with `variant`.
    pub(crate) fn with_variant(scene: &Scene, subject: &Subject, variant: Variant) -> FrameContext {
        let view = View::of(scene, subject, &variant);
        let planes = view.planes(scene.quality.samples);
        let space = LightSpace::of(scene, &view, &planes);
        let (scene, subject, whole) = (scene.clone(), subject.clone(), scene.image.size);
        FrameContext { scene, subject, variant, view, planes, space, whole }
    }
}
