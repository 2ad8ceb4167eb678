//! Volumes in bricks: which of them a scene can reach, and what that saves.

use super::object_inputs::ObjectInputs;
use crate::render::camera::SlicePlanes;
use crate::render::texture::{Bricks, Texels};
use crate::scene::{Integration, RayPath};
use serde::{Deserialize, Serialize};

/// A volume of which the device has bricks alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sparse {
    /// Bricks that are stored.
    pub stored: usize,
    /// Bricks of the whole volume.
    pub bricks: usize,
    /// Bytes of the texels of the bricks that are stored, and of their index.
    pub bytes: u64,
    /// Bytes of the texels of the whole volume.
    pub dense_bytes: u64,
}

impl Sparse {
    /// Leaves the bricks that are stored of a volume, and counts what that saves.
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
    /// The bricks of the volume that the scene can reach.
    ///
    /// A distance is looked up wherever a warp says, but only what is below the outer iso-value is matter, and a gradient
    /// looks a voxel further; the end of a segment may lie anywhere outside. Of what is opaque the first sample is seen,
    /// which is no deeper than a step along the most slanted ray, and what a warp moves lookups apart; any may be seen of matter
    /// that lets light through, or that a DMF may have made so.
    pub(crate) fn bricks(&self, looked_for: f32, texels: &Texels, planes: &SlicePlanes) -> Option<Bricks> {
        const MOST_SLANTED: f32 = 4.0; // three quarters of a right angle off the axis of view
        let (scene, field) = (&self.scene, self.subject.field.as_ref()?);
        let voxels = 2.0 * field.grid.spacing.max_element() * self.subject.scale;
        let outer = match scene.quality.integration {
            Integration::Point => self.own.outer_iso + voxels + looked_for,
            Integration::Segment => self.reach(),
        };
        let effect = &scene.effect;
        let straight = effect.ray_path == RayPath::Straight; // one that bends may go through clear matter
        let opaque =
            straight && (effect.classify == "surface" || (effect.dmf.is_empty() && effect.opacity == "perlin"));
        let step = planes.step / glam::Vec3::from(scene.object.stretch).min_element();
        let depth = MOST_SLANTED * step + self.own.spread.moves.span() + voxels;
        let inner = if opaque { scene.object.inner_iso - depth } else { f32::NEG_INFINITY };
        Some(Bricks::of(field, [inner, outer].map(|d| d / self.subject.scale), |number| texels.channels(number)))
    }
}
