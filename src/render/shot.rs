//! A picture about to be drawn.

use super::Subject;
use super::light_space::LightSpace;
use super::view::View;
use crate::render::pass::Planes;
use crate::render::variant::Variant;
use crate::scene::Scene;

/// A scene, and where all of it is.
pub(super) struct Shot<'a> {
    pub(super) scene: &'a Scene,
    pub(super) subject: &'a Subject,
    pub(super) variant: &'a Variant,
    pub(super) view: View,
    pub(super) planes: Planes,
    pub(super) space: LightSpace,
    /// The size of the picture that it stands for.
    pub(super) whole: [u32; 2],
}

impl<'a> Shot<'a> {
    /// A picture of a scene; `variant` is that of the scene, without the program of its shadow.
    pub(super) fn of(scene: &'a Scene, subject: &'a Subject, variant: &'a Variant) -> Shot<'a> {
        let view = View::of(scene, subject, variant);
        let planes = view.planes(scene.quality.samples);
        let space = LightSpace::of(scene, &view, &planes);
        Shot { scene, subject, variant, view, planes, space, whole: scene.image.size }
    }
}
