//! Destinations of pictures.

use super::half_angle;
use crate::gpu::{Blend, Format};
use crate::scene::{Order, Pass, Quality, Scene, TargetFormat};

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
