//! Grids of a scene's fog volume, by the names that other programs expect.

use super::leaf::VoxelLeaf;
use crate::render::subject::Subject;
use crate::render::variant::Variant;
use crate::scene::ParameterValue;
use crate::shape::{Fog, FogGrid, FogLeaf};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::io;

/// Relative difference between colors of one flat color, by rounding.
const FLAT_DIFFERENCE: f32 = 1e-5;

/// Grids of a scene: `density`; `extinction`, per world unit; `color`, linear RGB, unless all matter has one color; `temperature`, the luminance of a single object's
/// colors of a transfer map; and `vel`, world units per second, where the matter rises at a constant speed.
pub struct VoxelGrids {
    shines: bool,
    velocity: Option<[f32; 3]>,
    /// Lowest and highest color.
    colors: Option<[Vec3; 2]>,
}

impl VoxelGrids {
    /// Largest number of values of a voxel, except for a constant velocity, which compresses to nothing.
    pub const CHANNELS: u64 = 6;

    /// Grids of a scene.
    pub fn of(variant: &Variant, subject: &Subject) -> VoxelGrids {
        let has_map = variant.reads("transfer") || variant.scene.effect.classify == "pre";
        let shines = has_map && variant.parts.is_empty();
        let velocity = rising(variant, subject).map(|velocity| velocity.as_vec3().to_array());
        VoxelGrids { shines, velocity, colors: None }
    }

    /// The grids in the order of the values of a leaf.
    pub fn list(&self) -> Vec<FogGrid> {
        let grid = |name, channels| FogGrid { name, channels };
        let mut all = vec![grid("density", 1), grid("extinction", 1), grid("color", 3)];
        all.extend(self.shines.then_some(grid("temperature", 1)));
        all.extend(self.velocity.map(|_| grid("vel", 3)));
        all
    }

    /// Compresses leaves into a volume with these grids.
    ///
    /// # Errors
    /// Errors of the compression.
    pub fn add(&mut self, leaves: &[VoxelLeaf], fog: &mut Fog) -> io::Result<()> {
        for [red, green, blue, _] in leaves.iter().flat_map(|leaf| &leaf.voxels).filter(|voxel| is_matter(voxel)) {
            let color = Vec3::new(*red, *green, *blue);
            let [low, high] = self.colors.unwrap_or([color; 2]);
            self.colors = Some([low.min(color), high.max(color)]);
        }
        let is_half = fog.is_half;
        let encoded: Vec<FogLeaf> =
            leaves.par_iter().map(|leaf| self.encoded(leaf, is_half)).collect::<io::Result<_>>()?;
        fog.leaves.extend(encoded);
        Ok(())
    }

    /// The color of all matter, linear RGB, if it has only one.
    pub fn flat_color(&self) -> Option<[f32; 3]> {
        let [low, high] = self.colors?;
        (high - low).cmple(FLAT_DIFFERENCE * high.abs()).all().then(|| high.to_array())
    }

    /// Whether a grid is worth writing: a flat color is not.
    pub fn keeps(&self, grid: &FogGrid) -> bool {
        grid.name != "color" || self.flat_color().is_none()
    }

    fn encoded(&self, leaf: &VoxelLeaf, is_half: bool) -> io::Result<FogLeaf> {
        let active: Vec<bool> = leaf.voxels.iter().map(is_matter).collect();
        let matter = || leaf.voxels.iter().filter(|voxel| is_matter(voxel));
        let extinctions = leaf.extinctions.iter().zip(&active).filter(|(_, is_active)| **is_active);
        let mut values: Vec<Vec<f32>> = vec![
            matter().map(|[.., density]| *density).collect(),
            extinctions.map(|(extinction, _)| *extinction).collect(),
            matter().flat_map(|[red, green, blue, _]| [*red, *green, *blue]).collect(),
        ];
        // Luminance of Rec. 709.
        let brightness = |[red, green, blue, _]: &[f32; 4]| 0.2126 * red + 0.7152 * green + 0.0722 * blue;
        values.extend(self.shines.then(|| matter().map(brightness).collect()));
        values.extend(self.velocity.map(|velocity| matter().flat_map(|_| velocity).collect()));
        FogLeaf::new(leaf.corner, &active, &values, is_half)
    }
}

fn is_matter([.., density]: &[f32; 4]) -> bool {
    *density > 0.0
}

/// Velocity of matter whose pattern rises at a constant speed, world units per second in the axes of the object's file; `None`
/// if the scene has several such motions or objects, or none.
fn rising(variant: &Variant, subject: &Subject) -> Option<DVec3> {
    const SPEEDS: [&str; 3] = ["rise", "turbulence_rise", "turbulence_speed"];
    let speeds = variant.parameters.iter().filter_map(|(parameter, value)| match value {
        ParameterValue::Number(speed) if SPEEDS.contains(&parameter.name.as_str()) && *speed != 0.0 => Some(*speed),
        _ => None,
    });
    let object = &variant.scene.object;
    let [speed] = speeds.collect::<Vec<_>>()[..] else { return None };
    let up = DVec3::Y * f64::from(speed) * Vec3::from(object.stretch).as_dvec3() / f64::from(subject.scale);
    variant.parts.is_empty().then(|| object.up.turned_back(up))
}
