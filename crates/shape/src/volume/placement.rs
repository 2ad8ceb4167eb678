//! Placement of a grid of samples in the world.
//!
//! Role: checks of the declared geometry; reordering of samples along the world axes where possible. Invariant: every sample
//! stays where its file says.

use super::space::Space;
use crate::error::{Location, ShapeError};
use crate::shape::axes::{Axes, directions, lengths};
use crate::shape::{Content, MAX_COORDINATE, MAX_VOXELS, Volume};
use crate::source::{Source, check_positions};
use glam::{BVec3, DMat3, DVec3};
use hypertexture_support::memory;
use std::collections::TryReserveError;

/// Higher: f32 rounding moves a sample by more than the 1/100 voxel that `Volume::sample` tolerates. Lower: micro-CT scans in
/// scanner coordinates are refused.
const MAX_VOXELS_FROM_ORIGIN: f64 = 131_072.0;
/// Least determinant of the unit vectors along the axes. Lower: f32 does not resolve positions in the grid.
const MIN_DETERMINANT: f64 = 1e-6;
/// Relative size of a step component that is taken for the rounding of a quarter turn: the precision of f32; over 1000 samples
/// it adds up to 1/10000 voxel.
const ROUNDING: f64 = 1e-7;

/// Condition of [`are_lengths`], for messages.
pub(crate) const STEPS: &str = "distances between samples from 1.2e-38 to 1e18";

/// Grid of samples, x fastest, with their meaning.
pub(super) struct Placement {
    /// Samples per axis, at least 1; their product is at most [`MAX_VOXELS`].
    pub size: [u32; 3],
    /// World position of the first sample.
    pub origin: DVec3,
    /// Steps to the next sample, one column per axis, of lengths that [`are_lengths`] accepts.
    pub steps: DMat3,
    pub content: Content,
}

/// Whether f32 represents the lengths of steps as normal numbers.
pub(super) fn are_lengths(lengths: DVec3) -> bool {
    let tiny = DVec3::splat(f64::from(f32::MIN_POSITIVE));
    (lengths.cmpge(tiny) & lengths.cmple(DVec3::splat(f64::from(MAX_COORDINATE)))).all()
}

/// Samples per axis, checked against [`MAX_VOXELS`].
pub(crate) fn checked(file: &str, size: [u64; 3]) -> Result<[u32; 3], ShapeError> {
    at_most(file, "voxels", size, MAX_VOXELS)
}

/// Samples per axis, checked against a `limit`; `what` is the noun of the error.
pub(super) fn at_most(file: &str, what: &'static str, size: [u64; 3], limit: u64) -> Result<[u32; 3], ShapeError> {
    let limit = limit.min(MAX_VOXELS);
    let voxels = size.iter().try_fold(1_u64, |product, &n| product.checked_mul(n));
    if voxels.is_none_or(|voxels| voxels > limit) {
        let found = size.map(|n| n.to_string()).join(" x ");
        return Err(ShapeError::TooLarge { file: file.to_owned(), what, found, limit });
    }
    Ok(size.map(|n| n as u32)) // each is at most the product
}

impl Placement {
    /// The samples of a file whose coordinates are of `space`: the only place where volumes are brought into the world.
    pub fn new(space: Space, size: [u32; 3], (origin, steps): (DVec3, DMat3), content: Content) -> Placement {
        Placement { size, origin: space.position(origin), steps: space.steps(&steps), content }
    }

    /// Number of samples.
    pub fn voxels(&self) -> u64 {
        self.size.iter().map(|&n| u64::from(n)).product()
    }

    /// Checks that f32 resolves the samples, and that signed distances are on world axes.
    pub fn check(&self, file: &str) -> Result<(), ShapeError> {
        let unsupported =
            |what, found, remedy| Err(ShapeError::unsupported(file, Location::Header, what, found, remedy));
        let determinant = directions(&self.steps).determinant();
        if determinant.abs() <= MIN_DETERMINANT {
            let found = format!("whose unit axes have the determinant {determinant:.1e} (the limit is 1e-6)");
            return unsupported("a grid", found, "its axes lie in a plane: correct its directions");
        }
        let last = DVec3::from(self.size.map(|n| f64::from(n) - 1.0));
        let corner = |i: u32| DVec3::select(BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), last, DVec3::ZERO);
        let corners: [DVec3; 8] = std::array::from_fn(|i| self.origin + self.steps * corner(i as u32));
        check_positions(file, "volume corners", &corners.map(DVec3::as_vec3))?;
        let axes = Axes::new(DVec3::ZERO, self.steps);
        let voxels_away = corners.iter().map(|&corner| axes.sensitivity(corner).max_element()).fold(0.0, f64::max);
        if voxels_away > MAX_VOXELS_FROM_ORIGIN {
            let found = format!("{voxels_away:.0} voxels from the origin");
            let remedy =
                "move it nearer, 32-bit coordinates cannot tell its samples apart (the limit is 131072 voxels)";
            return unsupported("a volume", found, remedy);
        }
        if self.content == Content::SignedDistance && order(&self.straight()).is_none() {
            let found = "on a grid that is not along the axes of the world".into();
            let remedy = "resample it onto these axes, or save it as a scalar volume";
            return unsupported("a signed distance", found, remedy);
        }
        Ok(())
    }

    /// Values of a volume, all `value`.
    pub fn filled(&self, file: &str, value: f32) -> Result<Vec<f32>, ShapeError> {
        let bytes = 4 * self.voxels();
        let refused = || ShapeError::OutOfMemory { file: file.to_owned(), bytes };
        // Systems that overcommit memory grant the allocation and kill the process when it is used.
        if memory::available().is_some_and(|left| bytes > left) {
            return Err(refused());
        }
        let mut values = Vec::new();
        values.try_reserve_exact(self.voxels() as usize).map_err(|_| refused())?;
        values.resize(self.voxels() as usize, value);
        Ok(values)
    }

    /// Volume of values in the order of the file. Unknown values count as outside of the object.
    pub fn volume(self, source: &Source, mut values: Vec<f32>) -> Result<Volume, ShapeError> {
        let file = &source.file;
        if let Some(first) = values.iter().position(|value| !value.is_finite()) {
            self.fill_unknown(source, &mut values, first)?;
        }
        let bytes = 4 * self.voxels();
        let mut steps = self.straight();
        let Placement { mut size, mut origin, content, .. } = self;
        if let Some(order) = order(&steps) {
            let mut block = 1;
            for (axis, n) in size.map(|n| n as usize).into_iter().enumerate() {
                if steps.col(axis).to_array().iter().any(|part| *part < 0.0) {
                    reverse(&mut values, block, n);
                    origin += steps.col(axis) * (n as f64 - 1.0);
                }
                block *= n;
            }
            if order != [0, 1, 2] {
                let refused = |_| ShapeError::OutOfMemory { file: file.clone(), bytes };
                values = exchanged(&values, size, order).map_err(refused)?;
                size = order.map(|axis| size[axis]);
            }
            steps = DMat3::from_diagonal(DVec3::from(std::array::from_fn(|row| steps.row(row).abs().max_element())));
        }
        Ok(Volume { size, origin: origin.as_vec3(), steps: steps.as_mat3(), values, content })
    }

    /// Replaces unknown voxels (NaN, or infinitely far outside) by the most outside value. `first` is the index of the first
    /// voxel that is not finite.
    fn fill_unknown(&self, source: &Source, values: &mut [f32], first: usize) -> Result<(), ShapeError> {
        let is_scalar = self.content == Content::Scalar;
        let far = if is_scalar { f32::NEG_INFINITY } else { f32::INFINITY };
        let is_unknown = |value: &f32| value.is_nan() || *value == far;
        let count = values.iter().filter(|value| !value.is_finite()).count();
        let (unknown, total) = (values.iter().filter(|value| is_unknown(value)).count(), values.len());
        if unknown < count || count == total {
            return Err(ShapeError::NotFinite { file: source.file.clone(), what: "voxels", count, total, first });
        }
        let known = values.iter().copied().filter(|value| value.is_finite());
        let outside = if is_scalar {
            known.fold(f32::INFINITY, f32::min)
        } else {
            known.fold(lengths(&self.steps).max_element() as f32, f32::max)
        };
        values.iter_mut().filter(|value| is_unknown(value)).for_each(|value| *value = outside);
        source
            .note(format!("{count} of {total} voxels are NaN or infinite: they are outside of the object, {outside}"));
        Ok(())
    }

    /// Steps with rounding residues of quarter turns set to 0.
    fn straight(&self) -> DMat3 {
        let lengths = lengths(&self.steps).to_array();
        let column = |axis: usize| {
            let step = self.steps.col(axis);
            DVec3::select(step.abs().cmplt(DVec3::splat(ROUNDING * lengths[axis])), DVec3::ZERO, step)
        };
        DMat3::from_cols(column(0), column(1), column(2))
    }
}

/// Grid axis along each world axis, if the grid is aligned up to order and sign.
fn order(steps: &DMat3) -> Option<[usize; 3]> {
    let along = |row: usize| {
        let mut axes = (0..3).filter(|&axis| steps.col(axis)[row] != 0.0);
        axes.next().filter(|_| axes.next().is_none())
    };
    Some([along(0)?, along(1)?, along(2)?])
}

/// Reverses an axis of `count` blocks.
fn reverse(values: &mut [f32], block: usize, count: usize) {
    for axis in values.chunks_exact_mut(block * count) {
        for i in 0..count / 2 {
            let (front, back) = axis.split_at_mut((count - 1 - i) * block);
            front[i * block..][..block].swap_with_slice(&mut back[..block]);
        }
    }
}

/// Values with permuted axes.
fn exchanged(values: &[f32], size: [u32; 3], order: [usize; 3]) -> Result<Vec<f32>, TryReserveError> {
    let [nx, ny, nz] = size.map(|n| n as usize);
    let [sx, sy, sz] = order.map(|axis| [1, nx, nx * ny][axis]);
    let [nx, ny, nz] = order.map(|axis| [nx, ny, nz][axis]);
    let mut exchanged = Vec::new();
    exchanged.try_reserve_exact(values.len())?;
    for row in (0..nz).flat_map(|z| (0..ny).map(move |y| z * sz + y * sy)) {
        exchanged.extend((0..nx).map(|x| values[row + x * sx]));
    }
    Ok(exchanged)
}
