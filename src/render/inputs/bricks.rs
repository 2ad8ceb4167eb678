//! Bricks of volumes that a scene can reach, and the memory that they save.

use super::object_inputs::ObjectInputs;
use super::uniforms::search_distance;
use crate::render::camera::FrameContext;
use crate::render::texture::{Bricks, Texels};
use crate::scene::{Integration, RayPath};
use serde::{Deserialize, Serialize};

/// Memory of a volume of which only some bricks are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sparse {
    /// Number of stored bricks.
    pub stored: usize,
    /// Bricks of the whole volume.
    pub bricks: usize,
    /// Bytes of the stored bricks and of their index.
    pub bytes: u64,
    /// Bytes of the whole volume.
    pub dense_bytes: u64,
}

impl Sparse {
    /// Replaces a volume by its stored bricks, and counts the savings.
    pub(crate) fn add(&mut self, volume: &mut Texels, bricks: &Bricks) {
        let voxels: usize = volume.size.iter().map(|side| *side as usize).product();
        self.dense_bytes += volume.bytes.len() as u64;
        volume.bytes = bricks.gather(&volume.bytes, volume.bytes.len() / voxels);
        volume.size = bricks.atlas;
        if self.bricks == 0 {
            self.bytes += 16 * bricks.index.len() as u64;
        }
        self.bytes += volume.bytes.len() as u64;
        (self.stored, self.bricks) = (bricks.stored(), bricks.index.len());
    }
}

impl ObjectInputs<'_> {
    /// Bricks of the volume that the scene can reach.
    ///
    /// Warps look distances up anywhere, but only those below the outer iso-value are matter, and a gradient looks a
    /// voxel further; the end of a segment may lie anywhere outside. Of opaque matter only the first sample is seen:
    /// its depth is at most a step along the most slanted ray, plus the displacement by warps. Of translucent or
    /// modulated matter any sample may be seen.
    pub(crate) fn bricks(&self, frame: &FrameContext, texels: &Texels) -> Option<Bricks> {
        const MOST_SLANTED: f32 = 4.0; // 22 degrees from the slice plane
        let (scene, field) = (&self.scene, self.subject.field.as_ref()?);
        let voxels = 2.0 * field.grid.spacing.max_element() * self.subject.scale;
        let outer = match scene.quality.integration {
            Integration::Point => self.own.outer_iso + voxels + search_distance(frame),
            Integration::Segment => self.reach(),
        };
        let effect = &scene.effect;
        let straight = effect.ray_path == RayPath::Straight; // bent rays may pass through clear matter
        let opaque =
            straight && (effect.classify == "surface" || (effect.dmf.is_empty() && effect.opacity == "perlin"));
        let step = frame.planes.step / glam::Vec3::from(scene.object.stretch).min_element();
        let depth = MOST_SLANTED * step + self.own.spread.moves.span() + voxels;
        let inner = if opaque { scene.object.inner_iso - depth } else { f32::NEG_INFINITY };
        Some(Bricks::of(field, [inner, outer].map(|d| d / self.subject.scale), |number| texels.channels(number)))
    }
}
