//! Where the samples of a volume are, and the memory for them.
//!
//! Role: a place in the world for a grid, and room for its values. Invariant: samples that 32-bit coordinates cannot tell
//! apart, and memory that is not there, are refused before a value is read.

use super::error::{Location, ShapeError};
use super::source::check_positions;
use super::{MAX_COORDINATE, MAX_VOXELS};
use crate::support::memory;
use glam::{DMat3, DVec3, Vec3};

/// Farther away, f32 rounding moves a sample by more than the 1/100 voxel that `Volume::sample` allows for.
const MAX_VOXELS_FROM_ORIGIN: f64 = 131_072.0;
/// Least volume of a voxel, as a part of that of a box with the same edges: below, its axes lie in a plane.
const MIN_UPRIGHT: f64 = 1e-6;

/// The world position of the first sample and the distance between samples, where `steps` are the ways from a sample to the
/// next one on each axis.
pub(super) fn place(file: &str, size: [u32; 3], origin: DVec3, steps: DMat3) -> Result<(Vec3, Vec3), ShapeError> {
    let refused = |what, found, remedy| ShapeError::Unsupported {
        file: file.into(),
        place: Location::Header,
        what,
        found,
        remedy,
    };
    let lengths = DVec3::from([0, 1, 2].map(|axis| steps.col(axis).length()));
    let range = DVec3::splat(f64::from(f32::MIN_POSITIVE))..=DVec3::splat(f64::from(MAX_COORDINATE));
    let is_long = lengths.cmpge(*range.start()) & lengths.cmple(*range.end()); // not so for NaN
    let upright = steps.determinant().abs() / lengths.element_product();
    if !is_long.all() || upright < MIN_UPRIGHT {
        let found = format!("{} {} {}", shown(steps.x_axis), shown(steps.y_axis), shown(steps.z_axis));
        let remedy = "three directions of a length from 1.2e-38 to 1e18 that are not in a plane are read";
        return Err(refused("steps between samples of", found, remedy));
    }
    let last = origin + steps * DVec3::from(size.map(|n| f64::from(n) - 1.0));
    check_positions(file, "volume corners", &[origin.as_vec3(), last.as_vec3()])?;
    let back = steps.inverse();
    let voxels_away = (back * origin).abs().max((back * last).abs()).max_element();
    if voxels_away > MAX_VOXELS_FROM_ORIGIN {
        let remedy = "move it nearer, 32-bit coordinates cannot tell its samples apart (the limit is 131072 voxels)";
        return Err(refused("a volume", format!("{voxels_away:.0} voxels from the origin"), remedy));
    }
    let spacing = DVec3::new(steps.x_axis.x, steps.y_axis.y, steps.z_axis.z);
    if steps != DMat3::from_diagonal(spacing) || spacing.min_element() <= 0.0 {
        let found = format!("{} {} {}", shown(steps.x_axis), shown(steps.y_axis), shown(steps.z_axis));
        let remedy = "the axes must not be oblique, exchanged or mirrored: resample onto the axes";
        return Err(refused("steps between samples of", found, remedy));
    }
    Ok((origin.as_vec3(), spacing.as_vec3()))
}

/// A vector for a message; short where it is large, too.
pub(super) fn shown(vector: DVec3) -> String {
    let [x, y, z] = vector.to_array();
    format!("({x:?},{y:?},{z:?})")
}

/// `size` as it is kept, where it is of at most `most` voxels and [`MAX_VOXELS`]; `what` says which voxels.
pub(super) fn check_size(file: &str, what: &'static str, size: [u64; 3], most: u64) -> Result<[u32; 3], ShapeError> {
    let limit = most.min(MAX_VOXELS);
    let voxels = size.iter().try_fold(1_u64, |product, &n| product.checked_mul(n));
    if voxels.is_none_or(|voxels| voxels > limit) {
        let found = size.map(|n| n.to_string()).join(" x ");
        return Err(ShapeError::TooLarge { file: file.into(), what, found, limit });
    }
    Ok(size.map(|n| n as u32)) // each is at most the product
}

/// Room for the values of a volume, all `value`.
pub(super) fn filled(file: &str, size: [u32; 3], value: f32) -> Result<Vec<f32>, ShapeError> {
    let voxels: u64 = size.iter().map(|&n| u64::from(n)).product();
    let bytes = 4 * voxels;
    let refused = || ShapeError::OutOfMemory { file: file.into(), bytes };
    // What is asked for is given by some systems, and taken back together with the process when it is used.
    if memory::available().is_some_and(|left| bytes > left) {
        return Err(refused());
    }
    let mut values = Vec::new();
    values.try_reserve_exact(voxels as usize).map_err(|_| refused())?;
    values.resize(voxels as usize, value);
    Ok(values)
}

/// An error where a value is NaN or infinite.
pub(super) fn check_finite(file: &str, values: &[f32]) -> Result<(), ShapeError> {
    let Some(first) = values.iter().position(|value| !value.is_finite()) else { return Ok(()) };
    let count = values.iter().filter(|value| !value.is_finite()).count();
    Err(ShapeError::NotFinite { file: file.into(), what: "voxels", count, total: values.len(), first })
}
