//! A checked scene with its matrices, planes and light space.

use super::light_space::LightSpace;
use super::planes::SlicePlanes;
use super::view::View;
use crate::render::subject::Subject;
use crate::render::variant::Variant;
use std::sync::Arc;

#[derive(Clone)]
pub(crate) struct FrameContext {
    pub(crate) subject: Subject,
    pub(crate) variant: Arc<Variant>,
    pub(crate) view: View,
    pub(crate) planes: SlicePlanes,
    pub(crate) space: LightSpace,
    /// Size of the full picture of which this one is a preview.
    pub(crate) whole: [u32; 2],
}

impl FrameContext {
    pub(crate) fn of(variant: impl Into<Arc<Variant>>, subject: &Subject) -> FrameContext {
        let variant = variant.into();
        let view = View::of(&variant, subject);
        let planes = view.planes(variant.scene.quality.samples);
        let (space, whole) = (LightSpace::of(&variant.scene, &view, &planes), variant.scene.image.size);
        FrameContext { subject: subject.clone(), variant, view, planes, space, whole }
    }
}
