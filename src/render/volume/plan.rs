//! The grid of voxels of a scene, and its leaves that may hold matter.
//!
//! Invariant: the grid is cubic and aligned with the world of the object's file; the leaves left out are proven to be empty.

use super::error::VoxelError;
use crate::field::Progress;
use crate::render::density::DensityProgram;
use crate::render::subject::Subject;
use crate::render::variant::{Checkable, Variant};
use crate::shader::Library;
use crate::shape::FogLeaf;
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

/// Sides of the boxes that are proven to be empty one after another, in voxels.
const BOXES: [u32; 3] = [64, 16, FogLeaf::SIDE];
/// Boxes that a thread evaluates at a time.
const BATCH: usize = 128;
/// Largest number of voxels along a side.
const MAX_SIDE: u32 = 2048;

/// Voxels of a scene at its first moment, before their evaluation.
pub struct VoxelPlan {
    /// Voxels along each axis of the world.
    pub size: [u32; 3],
    /// Position of the first voxel in the world of the object's file.
    pub origin: DVec3,
    /// Side of a voxel, world units.
    pub step: f64,
    /// First voxels of the leaves of 8^3 voxels that may hold matter, after [`VoxelPlan::prove`].
    pub leaves: Vec<[u32; 3]>,
    /// First voxel, and steps between voxels, object space.
    pub(super) first: DVec3,
    pub(super) steps: DMat3,
    pub(super) program: DensityProgram,
    pub(super) variant: Variant,
}

impl VoxelPlan {
    /// Grid with `grid` voxels along the longest side of the box around the soft region, one of them outside at each end.
    ///
    /// # Errors
    /// The scene has no program, or one that [`eval`](crate::eval) does not cover; or the grid is not in 8 to 2048.
    pub fn of(
        library: &Library,
        scene: &impl Checkable,
        subject: &Subject,
        grid: u32,
    ) -> Result<VoxelPlan, VoxelError> {
        if !(8..=MAX_SIDE).contains(&grid) {
            return Err(VoxelError::Grid(grid));
        }
        let variant = scene.checked(library)?.into_owned();
        let program = DensityProgram::of(library, &variant, subject)?;
        let (object, scale) = (&variant.scene.object, f64::from(subject.scale));
        let stretch = Vec3::from(object.stretch).as_dvec3() / scale;
        let world = |place: DVec3| object.up.turned_back(subject.center.as_dvec3() + place * stretch);
        let ends = [program.view.box_min, program.view.box_max].map(|end| world(end.as_dvec3()));
        let (low, extent) = (ends[0].min(ends[1]), (ends[1] - ends[0]).abs());
        let step = extent.max_element() / f64::from(grid - 3);
        let size = extent.to_array().map(|side| (side / step - 1e-9).ceil().max(1.0) as u32 + 3);
        let spare = DVec3::from_array(size.map(|side| f64::from(side - 1))) * step - extent;
        let origin = low - 0.5 * spare;
        let object_axis = |axis: DVec3| object.up.turned(axis * step) / stretch;
        let steps = DMat3::from_cols(object_axis(DVec3::X), object_axis(DVec3::Y), object_axis(DVec3::Z));
        let first = (object.up.turned(origin) - subject.center.as_dvec3()) / stretch;
        let origin = origin + subject.offset;
        Ok(VoxelPlan { size, origin, step, leaves: vec![[0; 3]], first, steps, program, variant })
    }

    /// Number of voxels.
    pub fn voxels(&self) -> u64 {
        self.size.iter().map(|side| u64::from(*side)).product()
    }

    /// Position of a voxel in object space.
    pub(super) fn place(&self, at: DVec3) -> DVec3 {
        self.first + self.steps * at
    }

    /// Finds the leaves that may hold matter, in ever smaller boxes; once, before the evaluation.
    ///
    /// # Errors
    /// [`eval`](crate::eval) does not cover the program.
    pub fn prove(&mut self, progress: Progress<'_>) -> Result<(), VoxelError> {
        let density = self.program.bound(f64::MIN_POSITIVE)?;
        let mut side = MAX_SIDE.next_multiple_of(BOXES[0]);
        for (number, within) in BOXES.into_iter().enumerate() {
            let boxes: Vec<[u32; 3]> =
                self.leaves.iter().flat_map(|corner| self.parts(*corner, side, within)).collect();
            let open = boxes.par_chunks(BATCH).map(|boxes| {
                let ends = |corner: &[u32; 3]| {
                    let at = |more: f64| self.place(DVec3::from(corner.map(f64::from)) + more);
                    let [a, b] = [at(0.0), at(f64::from(within - 1))];
                    [a.min(b), a.max(b)]
                };
                let sides = density.sides(&boxes.iter().map(ends).collect::<Vec<_>>())?;
                let open = boxes.iter().zip(sides).filter(|(_, side)| *side != Some(false));
                Ok(open.map(|(corner, _)| *corner).collect())
            });
            let open: Vec<Vec<[u32; 3]>> = open.collect::<Result<_, VoxelError>>()?;
            self.leaves = open.concat();
            side = within;
            progress((number + 1) as f32 / BOXES.len() as f32);
        }
        Ok(())
    }

    /// First voxels of the boxes of side `within` in one of side `side` that overlap the grid.
    fn parts(&self, corner: [u32; 3], side: u32, within: u32) -> impl Iterator<Item = [u32; 3]> + use<> {
        let along =
            [0, 1, 2].map(|axis| (corner[axis]..self.size[axis].min(corner[axis] + side)).step_by(within as usize));
        let [xs, ys, zs] = along;
        xs.flat_map(move |x| {
            let zs = zs.clone();
            ys.clone().flat_map(move |y| zs.clone().map(move |z| [x, y, z]))
        })
    }
}
