//! A picture about to be drawn.

use super::light_space::LightSpace;
use super::planes::SlicePlanes;
use super::view::View;
use crate::render::subject::Subject;
use crate::render::variant::Variant;
use crate::scene::Scene;

/// A scene, and where all of it is.
pub(crate) struct FrameContext<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) subject: &'a Subject,
    pub(crate) variant: &'a Variant,
    pub(crate) view: View,
    pub(crate) planes: SlicePlanes,
    pub(crate) space: LightSpace,
    /// The size of the picture that it stands for.
    pub(crate) whole: [u32; 2],
}

impl<'a> FrameContext<'a> {
    /// A picture of a scene; `variant` is that of the scene, without the program of its shadow.
    pub(crate) fn of(scene: &'a Scene, subject: &'a Subject, variant: &'a Variant) -> FrameContext<'a> {
        let view = View::of(scene, subject, variant);
        let planes = view.planes(scene.quality.samples);
        let space = LightSpace::of(scene, &view, &planes);
        FrameContext { scene, subject, variant, view, planes, space, whole: scene.image.size }
    }
}
