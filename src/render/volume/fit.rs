//! Error of voxels: the density between them against the density itself.

use super::error::VoxelError;
use super::leaf::VoxelLeaf;
use super::plan::VoxelPlan;
use crate::shape::FogLeaf;
use glam::DVec3;
use half::f16;
use hypertexture_support::random::SplitMix;
use rayon::prelude::*;
use serde::Serialize;

/// Places at which the error is measured.
const PLACES: usize = 100_000;
/// Leaves that the places are in.
const LEAVES: usize = 4096;
/// Places in a batch of a thread.
const BATCH: usize = 1024;
/// Lowest order at which a finer grid is named: it would have 16 times the voxels along a side.
const LEAST_ORDER: f64 = 0.25;

/// Error of the trilinear density, at random places in the leaves that hold matter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct VoxelFit {
    /// Number of places.
    pub places: usize,
    /// Root of the mean square.
    pub rms: f64,
    /// Largest absolute value.
    pub largest: f64,
    /// Order of convergence: log2 of the RMS with every second voxel over that with all.
    pub order: f64,
    /// Voxels along the longest side at which the RMS is half, by the order; `None` where the order is too low to tell.
    pub halved_by: Option<u32>,
}

/// Random sample of leaves, each as likely as any other.
pub(super) struct SampleOfLeaves {
    random: SplitMix,
    seen: usize,
    kept: Vec<([u32; 3], Vec<f32>)>,
}

impl SampleOfLeaves {
    pub fn new() -> SampleOfLeaves {
        SampleOfLeaves { random: SplitMix(1), seen: 0, kept: Vec::new() }
    }

    /// Algorithm R of Vitter 1985. `is_half`: densities are stored in 16 bits.
    pub fn offer(&mut self, leaf: &VoxelLeaf, is_half: bool) {
        let stored = |density: f32| if is_half { f16::from_f32(density).to_f32() } else { density };
        self.seen += 1;
        let own = || (leaf.corner, leaf.voxels.iter().map(|[.., density]| stored(*density)).collect());
        if self.kept.len() < LEAVES {
            self.kept.push(own());
        } else if let Some(place) = self.kept.get_mut((self.random.unit() * self.seen as f64) as usize) {
            *place = own();
        }
    }

    /// Measures the error. Places are in the first 6^3 cells of a leaf, which have all their corners in it, with steps of one
    /// and of two voxels.
    pub fn fit(mut self, plan: &VoxelPlan) -> Result<VoxelFit, VoxelError> {
        let mut place = || {
            let leaf = (self.random.unit() * self.kept.len() as f64) as usize;
            (leaf, DVec3::from([(); 3].map(|()| 6.0 * self.random.unit())))
        };
        let places: Vec<(usize, DVec3)> = (0..PLACES).map(|_| place()).collect();
        let density = plan.program.bound(0.0)?;
        let errors = places.par_chunks(BATCH).map(|places| {
            let corner = |leaf: usize| DVec3::from(self.kept[leaf].0.map(f64::from));
            let exact =
                density.at(&places.iter().map(|(leaf, at)| plan.place(corner(*leaf) + *at)).collect::<Vec<_>>())?;
            let errors = places
                .iter()
                .zip(exact)
                .map(|((leaf, at), exact)| [1, 2].map(|step| trilinear(&self.kept[*leaf].1, *at, step) - exact));
            Ok(errors.collect())
        });
        let errors: Vec<[f64; 2]> = errors.collect::<Result<Vec<Vec<_>>, VoxelError>>()?.concat();
        let rms =
            [0, 1].map(|step| (errors.iter().map(|all| all[step] * all[step]).sum::<f64>() / PLACES as f64).sqrt());
        let largest = errors.iter().map(|[fine, _]| fine.abs()).fold(0.0, f64::max);
        let order = if rms[0] > 0.0 { (rms[1] / rms[0]).log2() } else { 0.0 };
        let grid = f64::from(plan.size.into_iter().max().unwrap_or_default());
        let halved_by = (order >= LEAST_ORDER).then(|| (grid * (1.0 / order).exp2()).ceil() as u32);
        Ok(VoxelFit { places: PLACES, rms: rms[0], largest, order, halved_by })
    }
}

/// Trilinear density at a place in a leaf, of every voxel or of every second one.
fn trilinear(voxels: &[f32], at: DVec3, step: u32) -> f64 {
    let low = (at / f64::from(step)).floor();
    let part = at / f64::from(step) - low;
    let corner = low.as_uvec3() * step;
    let value = |x: u32, y: u32, z: u32| {
        let near = |more: u32, part: f64| if more == 0 { 1.0 - part } else { part };
        let weight = near(x, part.x) * near(y, part.y) * near(z, part.z);
        weight * f64::from(voxels[FogLeaf::index([corner.x + x * step, corner.y + y * step, corner.z + z * step])])
    };
    (0..8).map(|end: u32| value(end & 1, end >> 1 & 1, end >> 2)).sum()
}
