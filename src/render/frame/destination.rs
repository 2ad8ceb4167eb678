//! Destinations of pictures.

use super::half_angle;
use crate::gpu::{Blend, Dimension, Format, Gpu, GpuError, Image, ImageUse};
use crate::scene::{Order, Pass, Quality, Scene, TargetFormat};
use std::sync::Arc;

/// Destination of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Destination {
    /// A target that is read back.
    Frame,
    /// A host's image of this format, and optionally one for the depth.
    Host { format: Format, has_depth: bool },
}

impl Destination {
    /// Whether a scene prepared for this destination serves another.
    pub(crate) fn serves(self, other: Destination) -> bool {
        match (self, other) {
            (Destination::Host { format, has_depth }, Destination::Host { format: of_other, has_depth: wanted }) => {
                format == of_other && (has_depth || !wanted)
            }
            _ => self == other,
        }
    }

    /// Format of the target.
    pub(crate) fn format(self, quality: &Quality) -> Format {
        match (self, quality.target) {
            (Destination::Host { format, .. }, _) => format,
            (_, TargetFormat::Unorm8) => Format::Rgba8Unorm,
            (_, TargetFormat::Float16) => Format::Rgba16Float,
            (_, TargetFormat::Float32) => Format::Rgba32Float,
        }
    }

    /// Blending of a scene's fragments.
    pub(crate) fn blend(self, scene: &Scene) -> Blend {
        match (scene.quality.pass, scene.quality.order) {
            _ if self != Destination::Frame => Blend::Over,
            (Pass::March, _) => Blend::Replace,
            _ if scene.is_half_angle() => half_angle::blend(scene),
            (Pass::Slices, Order::FrontToBack) => Blend::Under,
            (Pass::Slices, Order::BackToFront) => Blend::Over,
        }
    }
}

/// Allocates the render target, and its resolve target with multisampling.
pub(super) fn targets(gpu: &Gpu, scene: &Scene, format: Format) -> Result<(Arc<Image>, Option<Image>), GpuError> {
    let ([width, height], msaa) = (scene.image.size, scene.quality.msaa);
    let target =
        |name, samples| Image::new(gpu, name, Dimension::Plane(width, height), format, ImageUse::Target(samples));
    let resolved = (msaa > 1).then(|| target("resolved target", 1)).transpose()?;
    Ok((Arc::new(target("target", msaa)?), resolved))
}
