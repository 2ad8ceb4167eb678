//! A scene with its matrices, planes and light space.

use super::light_space::LightSpace;
use super::planes::SlicePlanes;
use super::view::View;
use crate::render::subject::Subject;
use crate::render::variant::Variant;
use crate::scene::Scene;

pub(crate) struct FrameContext<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) subject: &'a Subject,
    pub(crate) variant: &'a Variant,
    pub(crate) view: View,
    pub(crate) planes: SlicePlanes,
    pub(crate) space: LightSpace,
    /// Size of the full picture of which this one is a preview.
    pub(crate) whole: [u32; 2],
}

impl<'a> FrameContext<'a> {
    /// Computes the context; `variant` is the picture's, not the shadow's.
    pub(crate) fn of(scene: &'a Scene, subject: &'a Subject, variant: &'a Variant) -> FrameContext<'a> {
        let view = View::of(scene, subject, variant);
        let planes = view.planes(scene.quality.samples);
        let space = LightSpace::of(scene, &view, &planes);
        FrameContext { scene, subject, variant, view, planes, space, whole: scene.image.size }
    }
}
