//! The variant that draws a scene: filters, stage and phases by the device and its trials.

use super::filters::suited;
use super::renderer::Renderer;
use crate::render::error::RenderError;
use crate::render::variant::{Checkable, Variant};
use crate::scene::{RayPath, ShaderStage};
use std::borrow::Cow;

impl Renderer {
    /// The variant of a scene by filters that the device has.
    pub(super) fn suited<'a>(&self, variant: Cow<'a, Variant>) -> Cow<'a, Variant> {
        suited(self.gpu.info(), variant)
    }

    /// The variant that draws a scene.
    pub(super) fn variant(&self, scene: &impl Checkable) -> Result<Variant, RenderError> {
        let own = self.suited(scene.checked_after(&self.library, self.checked.as_deref())?);
        Ok(self.in_way(&own).into_owned())
    }

    /// The variant that draws that of a scene: [`Renderer::plain`], or in the way that a trial chose.
    pub(super) fn in_way<'a>(&self, own: &'a Variant) -> Cow<'a, Variant> {
        let in_compute = || self.plain(own).in_compute(&self.library).ok();
        let way = match own.scene.quality.stage {
            ShaderStage::Compute if self.gpu.info().computes => in_compute(),
            ShaderStage::Fragment | ShaderStage::Compute => None,
            ShaderStage::Auto if self.bends_in_compute(own) => in_compute(),
            ShaderStage::Auto if self.is_cut(own) => None,
            ShaderStage::Auto => self.ways.applied(own, &self.library),
        };
        way.map_or_else(|| self.plain(own), Cow::Owned)
    }

    /// The variant that draws that of a scene by fragment shaders: in one phase where the device has cut two-phase rays
    /// short, else as suits most devices of its kind.
    pub(super) fn plain<'a>(&self, own: &'a Variant) -> Cow<'a, Variant> {
        if self.is_cut(own) { Cow::Owned(own.without_two_phase()) } else { own.for_device(self.gpu.info().cpu) }
    }

    /// Whether compute shaders bend the rays of a scene, since the derivatives of fragment shaders are wrong.
    pub(super) fn bends_in_compute(&self, own: &Variant) -> bool {
        let info = self.gpu.info();
        info.misses_neighbors() && info.computes && own.scene.effect.ray_path == RayPath::Refracted
    }

    pub(super) fn is_cut(&self, own: &Variant) -> bool {
        let samples = own.scene.quality.samples;
        self.cut_short.iter().any(|(slots, cut)| *slots == own.slots && *cut <= samples)
    }
}
