//! Inside and outside of a mesh, by voxel.
//!
//! Invariant: neighbors whose distances add up to more than [`APART`] voxels have no surface between them.
//! The winding number is evaluated only in blocks where it is not clearly an integer (near and across a hole), at voxels that
//! the surface separates from all neighbors, and once for each remaining region, which a flood fill covers.

use super::distance::{BLOCK, Distances, corner_size};
use super::winding::{POINTS, Winding, inside};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::VecDeque;

/// Distance of a winding number from an integer above which its block is evaluated voxel by voxel. Higher risks wrong signs,
/// certain at 0.5; below 0.1 open regions cost several times more.
const UNCLEAR: f32 = 0.25;
/// Distance from 1/2 below which a block without surface, where the number varies slowly, is evaluated voxel by voxel.
const NEAR_HALF: f32 = 0.1;
/// Winding number above which solids overlap, between 1 and 2.
const OVERLAP: f32 = 1.5;

/// 1 voxel plus the rounding of two distances of up to 1024 voxels. Lower leaks signs through flat faces; higher evaluates a few
/// more winding numbers.
pub(super) const APART: f32 = 1.0 + 1.0e-3;

/// States of a voxel.
const UNKNOWN: u8 = 0;
const OUTSIDE: u8 = 1;
const INSIDE: u8 = 2;

/// Signs of a grid.
pub(super) struct Signs {
    /// Whether each voxel is inside, x fastest.
    pub inside: Vec<bool>,
    /// Whether solids overlap somewhere.
    pub overlap: bool,
}

/// Signs of all voxels; `rim` samples the edges with unbalanced winding at most a voxel apart.
pub(super) fn signs(size: [usize; 3], distances: &Distances, winding: &Winding, rim: &[Vec3]) -> Signs {
    let d = distances.values();
    let [nx, ny, nz] = size;
    let unclear = unclear_blocks(size, distances, winding, rim);
    let blocks = size.map(|n| n.div_ceil(BLOCK));
    let mut state = vec![UNKNOWN; d.len()];
    let overlaps = state.par_chunks_mut(nx * ny).enumerate().map(|(z, slice)| {
        let mut overlap = false;
        for y in 0..ny {
            let row = (z / BLOCK * blocks[1] + y / BLOCK) * blocks[0];
            let wanted = (0..nx).filter(|&x| {
                let i = (z * ny + y) * nx + x;
                let needed = unclear.as_ref().is_some_and(|unclear| unclear[row + x / BLOCK]);
                needed || neighbors([x, y, z], size).all(|j| d[i] + d[j] <= APART)
            });
            let wanted: Vec<usize> = wanted.collect();
            for group in wanted.chunks(POINTS) {
                let at = |p: usize| Vec3::new(*group.get(p).unwrap_or(&group[0]) as f32, y as f32, z as f32);
                for (&x, number) in group.iter().zip(winding.around(&std::array::from_fn(at))) {
                    slice[y * nx + x] = if inside(number) { INSIDE } else { OUTSIDE };
                    overlap |= number.abs() > OVERLAP;
                }
            }
        }
        overlap
    });
    let mut overlap = overlaps.reduce(|| false, |a, b| a | b);
    let mut queue = VecDeque::new();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let i = (z * ny + y) * nx + x;
                if state[i] != UNKNOWN {
                    continue;
                }
                let number = winding.at(Vec3::new(x as f32, y as f32, z as f32));
                overlap |= number.abs() > OVERLAP;
                let sign = if inside(number) { INSIDE } else { OUTSIDE };
                state[i] = sign;
                queue.push_back([x, y, z]);
                while let Some(at) = queue.pop_front() {
                    let i = (at[2] * ny + at[1]) * nx + at[0];
                    for j in neighbors(at, size) {
                        if state[j] == UNKNOWN && d[i] + d[j] > APART {
                            state[j] = sign;
                            queue.push_back([j % nx, j / nx % ny, j / (nx * ny)]);
                        }
                    }
                }
            }
        }
    }
    Signs { inside: state.into_par_iter().map(|s| s == INSIDE).collect(), overlap }
}

/// Whether solids overlap at a corner of a block. They may overlap elsewhere all the same.
pub(super) fn overlaps(size: [usize; 3], winding: &Winding) -> bool {
    at_corners(corner_size(size), winding).into_par_iter().any(|number| number.abs() > OVERLAP)
}

/// Winding numbers at the corners of all blocks.
fn at_corners(corners: [usize; 3], winding: &Winding) -> Vec<f32> {
    let mut numbers = vec![0.0; corners.iter().product()];
    numbers.par_chunks_mut(POINTS).enumerate().for_each(|(chunk, numbers)| {
        let at = |p: usize| {
            let i = chunk * POINTS + p.min(numbers.len() - 1);
            let at = [i % corners[0], i / corners[0] % corners[1], i / (corners[0] * corners[1])];
            Vec3::from_array(at.map(|c| (c * BLOCK) as f32))
        };
        let found = winding.around(&std::array::from_fn(at));
        numbers.copy_from_slice(&found[..numbers.len()]);
    });
    numbers
}

/// Blocks to evaluate voxel by voxel; `None` without a rim, where winding numbers are integers.
fn unclear_blocks(size: [usize; 3], distances: &Distances, winding: &Winding, rim: &[Vec3]) -> Option<Vec<bool>> {
    if rim.is_empty() {
        return None;
    }
    let corners = corner_size(size);
    let numbers = at_corners(corners, winding);
    let blocks = size.map(|n| n.div_ceil(BLOCK));
    let count: usize = blocks.iter().product();
    let mut unclear: Vec<bool> = (0..count)
        .into_par_iter()
        .map(|b| {
            let at = [b % blocks[0], b / blocks[0] % blocks[1], b / (blocks[0] * blocks[1])];
            let around: [usize; 8] = std::array::from_fn(|i| {
                let [x, y, z] = [at[0] + (i & 1), at[1] + (i >> 1 & 1), at[2] + (i >> 2)];
                (z * corners[1] + y) * corners[0] + x
            });
            // A surface in the block or in one next to it would be this near to a corner.
            let free = around.iter().all(|&c| distances.corner(c) > 2.0 * 3.0f32.sqrt() * BLOCK as f32);
            if free {
                let first = inside(numbers[around[0]]);
                around.iter().any(|&c| (numbers[c].abs() - 0.5).abs() < NEAR_HALF || inside(numbers[c]) != first)
            } else {
                around.iter().any(|&c| (numbers[c] - numbers[c].round()).abs() > UNCLEAR)
            }
        })
        .collect();
    for p in rim {
        let block = (*p / BLOCK as f32).floor().as_i64vec3();
        let range = |axis: usize| {
            let last = blocks[axis] as i64 - 1;
            (block[axis] - 1).clamp(0, last + 1)..=(block[axis] + 1).clamp(-1, last)
        };
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    unclear[(z as usize * blocks[1] + y as usize) * blocks[0] + x as usize] = true;
                }
            }
        }
    }
    Some(unclear)
}

/// Indices of the up to six neighbors of a voxel.
fn neighbors([x, y, z]: [usize; 3], size: [usize; 3]) -> impl Iterator<Item = usize> {
    let [nx, ny, nz] = size;
    let i = (z * ny + y) * nx + x;
    let list = [
        (x > 0, 1, false),
        (x + 1 < nx, 1, true),
        (y > 0, nx, false),
        (y + 1 < ny, nx, true),
        (z > 0, nx * ny, false),
        (z + 1 < nz, nx * ny, true),
    ];
    list.into_iter().filter(|n| n.0).map(move |(_, step, up)| if up { i + step } else { i - step })
}
