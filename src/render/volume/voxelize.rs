//! Evaluation of the voxels of a scene on the device.

use super::error::VoxelError;
use super::extinction::VoxelExtinction;
use super::fit::{SampleOfLeaves, VoxelFit};
use super::leaf::VoxelLeaf;
use super::plan::VoxelPlan;
use crate::field::Progress;
use crate::gpu::Gpu;
use crate::render::frame::VoxelProgram;
use crate::render::subject::Subject;
use crate::render::variant::{Variant, as_density, as_extinction, unlit};
use crate::shader::Library;
use crate::shape::FogLeaf;
use glam::DVec3;
use std::io;

/// Voxels along a side of a leaf.
const SIDE: u32 = FogLeaf::SIDE;
/// Share of the progress that is left for the measurement of the error.
const ERROR_SHARE: f32 = 0.1;

/// Report on evaluated voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelReport {
    /// Leaves with matter.
    pub leaves: usize,
    /// Evaluated voxels.
    pub evaluated: u64,
    /// Time on the device, milliseconds.
    pub gpu_ms: f64,
    /// Error between the voxels.
    pub fit: VoxelFit,
    /// Extinction of the voxels.
    pub extinction: VoxelExtinction,
}

/// Evaluates the voxels of a plan, which belongs to `subject`, and gives the leaves with matter to `take`, some at a time. `is_half`
/// rounds densities to 16 bits for the error, and keeps extinctions in their range. `progress` receives the finished share.
///
/// # Errors
/// No voxel holds matter, or one that is not finite; a Vulkan call fails, or `take`.
pub fn voxelize(
    gpu: &Gpu,
    library: &Library,
    plan: &VoxelPlan,
    subject: &Subject,
    is_half: bool,
    take: &mut dyn FnMut(Vec<VoxelLeaf>) -> io::Result<()>,
    progress: Progress<'_>,
) -> Result<VoxelReport, VoxelError> {
    let neutral = Variant::of(&unlit(&plan.variant.scene, library), library)?;
    let mut program = VoxelProgram::new(gpu, library, &neutral, subject, as_density)?;
    let mut extinguishing = VoxelProgram::new(gpu, library, &by_points(&neutral, library)?, subject, as_extinction)?;
    let mut extinction = VoxelExtinction::new(plan.step, is_half);
    let (mut sample, mut leaves, mut done) = (SampleOfLeaves::new(), 0, 0);
    for corners in plan.leaves.chunks(VoxelProgram::most(SIDE)) {
        let first: Vec<DVec3> = corners.iter().map(|corner| plan.place(DVec3::from(corner.map(f64::from)))).collect();
        let mut found = program.cubes(SIDE, &first, &plan.steps, |texels, of_cube| {
            let leaf = |(cube, corner): (usize, &[u32; 3])| {
                let texel = |index| texels[of_cube.index(cube, FogLeaf::at(index))];
                let voxels = (0..512).map(|index| straight(texel(index))).collect();
                VoxelLeaf { corner: *corner, voxels, extinctions: Vec::new() }
            };
            corners.iter().enumerate().map(leaf).collect::<Vec<_>>()
        })?;
        extinguishing.cubes(SIDE, &first, &plan.steps, |texels, of_cube| {
            for (cube, leaf) in found.iter_mut().enumerate() {
                let value = |index| texels[of_cube.index(cube, FogLeaf::at(index))][3];
                leaf.extinctions = (0..512).map(value).collect();
            }
        })?;
        found.iter_mut().for_each(|leaf| extinction.add(leaf, f64::from(subject.scale)));
        if let Some(at) = found.iter().find_map(VoxelLeaf::not_finite) {
            return Err(VoxelError::NotFinite(at[0], at[1], at[2]));
        }
        let found: Vec<VoxelLeaf> = found.into_iter().filter(VoxelLeaf::has_matter).collect();
        found.iter().for_each(|leaf| sample.offer(leaf, is_half));
        leaves += found.len();
        take(found)?;
        done += corners.len();
        progress((1.0 - ERROR_SHARE) * done as f32 / plan.leaves.len() as f32);
    }
    if leaves == 0 {
        return Err(VoxelError::Empty(plan.size[0], plan.size[1], plan.size[2]));
    }
    let evaluated = plan.leaves.len() as u64 * u64::from(SIDE.pow(3));
    let gpu_ms = program.gpu_ms + extinguishing.gpu_ms;
    Ok(VoxelReport { leaves, evaluated, gpu_ms, fit: sample.fit(plan)?, extinction })
}

/// The scene with the extinction at a point in place of the table of segments.
fn by_points(variant: &Variant, library: &Library) -> Result<Variant, VoxelError> {
    let mut scene = variant.scene.clone();
    if scene.effect.classify != "preintegrated" {
        return Ok(variant.clone());
    }
    scene.effect.classify = "post".into();
    Ok(Variant::of(&scene, library)?)
}

/// Color without the density that it was multiplied by.
fn straight([red, green, blue, density]: [f32; 4]) -> [f32; 4] {
    if density > 0.0 { [red / density, green / density, blue / density, density] } else { [0.0, 0.0, 0.0, density] }
}
