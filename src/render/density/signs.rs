//! Sides of the samples of a grid, where bounds leave them open.
//!
//! Invariant: a cube of cells that is left out has no surface within it, which bounds of the density prove; all samples of
//! the others are evaluated, border samples excepted, which are outside.

use super::error::PolygonizeError;
use super::lattice::Lattice;
use super::program::Density;
use crate::eval::ExactError;
use crate::field::{BLOCK, Progress, SignBlock};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Cells along a side of the largest cubes with common bounds. Lower: more bounds. Higher: looser bounds.
const LARGEST: u32 = 32;
/// Cubes in a batch of a thread.
const BATCH: usize = 64;
/// Bytes of memory at the peak for each cube whose samples are evaluated: about 80 triangles.
const BYTES: u64 = 16 << 10;
/// Cubes of half the side that bounds leave open, in each one left open: those on a surface, and some near it.
const LEFT_OPEN: u64 = 5;

/// The open cubes of a grid.
pub(crate) struct Signs {
    /// Cubes with samples on both sides, by their places.
    pub blocks: Vec<SignBlock>,
    /// Evaluated samples.
    samples: Samples,
}

/// Samples of cubes of 4^3: sorted numbers of cubes, the evaluated samples of each, and which of those are inside.
struct Samples {
    cubes: [u32; 3],
    of: Vec<(u32, u64, u64)>,
}

impl Samples {
    fn number(&self, [x, y, z]: [u32; 3]) -> u32 {
        (z * self.cubes[1] + y) * self.cubes[0] + x
    }

    fn first_sample(&self, number: u32) -> [u32; 3] {
        let [x, y, _] = self.cubes;
        [number % x, number / x % y, number / x / y].map(|at| at * BLOCK)
    }

    /// Bit of a sample in its cube.
    fn bit(at: [u32; 3]) -> u32 {
        let [x, y, z] = at.map(|at| at % BLOCK);
        x + BLOCK * (y + BLOCK * z)
    }

    fn inside(&self, number: u32) -> u64 {
        self.of.binary_search_by_key(&number, |(number, ..)| *number).map_or(0, |found| self.of[found].2)
    }
}

/// First cells of cubes, of one size.
type Cubes = Vec<[u32; 3]>;

impl Signs {
    /// Evaluates a grid of at most 2^32 samples. Memory grows as the surface; more than `most` bytes are refused before they
    /// are used.
    ///
    /// # Errors
    /// [`PolygonizeError::Memory`] and those of the evaluation.
    pub fn of(
        density: &Density<'_>,
        lattice: &Lattice,
        most: u64,
        progress: Progress<'_>,
    ) -> Result<Signs, PolygonizeError> {
        let (cubes, is_full) = open_cubes(density, lattice, most, &|done| progress(0.5 * done))?;
        let mut samples = Samples { cubes: lattice.size.map(|side| side.div_ceil(BLOCK) + 1), of: Vec::new() };
        samples.of = needed(&samples, &cubes);
        let (all, done) = (samples.of.len() as f32, AtomicUsize::new(0));
        let first_samples: Vec<[u32; 3]> =
            samples.of.iter().map(|(number, ..)| samples.first_sample(*number)).collect();
        let evaluated = samples.of.par_chunks_mut(BATCH).zip(first_samples.par_chunks(BATCH)).map(|(of, firsts)| {
            let mut places = Vec::new();
            for ((_, wanted, _), first) in of.iter_mut().zip(firsts) {
                *wanted =
                    each(*first, *wanted).filter(|at| lattice.is_within(*at)).map(|at| 1 << Samples::bit(at)).sum();
                places.extend(each(*first, *wanted).map(|at| lattice.place(at)));
            }
            let densities = density.at(&places)?;
            let mut values = densities.iter();
            for ((_, wanted, inside), first) in of.iter_mut().zip(firsts) {
                let dense = each(*first, *wanted).zip(&mut values).filter(|(_, value)| **value >= density.level);
                *inside = dense.map(|(at, _)| 1 << Samples::bit(at)).sum();
            }
            let done = done.fetch_add(of.len(), Ordering::Relaxed) + of.len();
            progress(0.5 + 0.5 * done as f32 / all);
            Ok(densities.into_iter().fold(0.0, f64::max))
        });
        let largest = evaluated.collect::<Result<Vec<f64>, ExactError>>()?.into_iter().fold(0.0, f64::max);
        if !is_full && samples.of.iter().all(|(.., inside)| *inside == 0) {
            return Err(PolygonizeError::NoSurface { level: density.level, largest });
        }
        let block = |low: &[u32; 3]| SignBlock { low: *low, inside: gathered(&samples, *low) };
        Ok(Signs { blocks: cubes.par_iter().map(block).collect(), samples })
    }

    /// The evaluated samples, with whether each is inside.
    pub fn samples(&self) -> impl ParallelIterator<Item = ([u32; 3], bool)> + '_ {
        self.samples.of.par_iter().flat_map_iter(|(number, wanted, inside)| {
            each(self.samples.first_sample(*number), *wanted).map(move |at| (at, inside >> Samples::bit(at) & 1 == 1))
        })
    }
}

/// The samples of a cube whose bits are set.
fn each(first: [u32; 3], bits: u64) -> impl Iterator<Item = [u32; 3]> {
    let of = move |bit: u32| [bit % BLOCK, bit / BLOCK % BLOCK, bit / BLOCK / BLOCK];
    let set = (0..BLOCK.pow(3)).filter(move |bit| bits >> bit & 1 == 1);
    set.map(move |bit| [0, 1, 2].map(|axis| first[axis] + of(bit)[axis]))
}

/// Cubes of [`BLOCK`] cells a side that bounds leave open, and whether a cube is proven to be inside.
fn open_cubes(
    density: &Density<'_>,
    lattice: &Lattice,
    most: u64,
    progress: Progress<'_>,
) -> Result<(Cubes, bool), PolygonizeError> {
    let mut side = LARGEST;
    let steps = |axis: usize| (0..lattice.size[axis] - 1).step_by(LARGEST as usize);
    let mut open: Cubes = steps(2).flat_map(|z| steps(1).flat_map(move |y| steps(0).map(move |x| [x, y, z]))).collect();
    let mut is_full = false;
    loop {
        let corners = |first: &[u32; 3]| -> [DVec3; 2] {
            let last = [0, 1, 2].map(|axis| (first[axis] + side).min(lattice.size[axis] - 1));
            [*first, last].map(|at| lattice.place(at))
        };
        let sides = open.par_chunks(BATCH).map(|cubes| density.sides(&cubes.iter().map(corners).collect::<Vec<_>>()));
        let sides: Vec<Option<bool>> = sides.collect::<Result<Vec<_>, ExactError>>()?.concat();
        is_full |= sides.contains(&Some(true));
        open = open.into_iter().zip(sides).filter(|(_, side)| side.is_none()).map(|(cube, _)| cube).collect();
        progress(1.0 - (side / BLOCK).ilog2() as f32 / (LARGEST / BLOCK).ilog2() as f32);
        let levels = (side / BLOCK).ilog2();
        let needed = open.len() as u64 * LEFT_OPEN.pow(levels) * BYTES;
        if levels <= 1 && needed > most {
            return Err(PolygonizeError::Memory { needed, most });
        }
        if levels == 0 {
            open.sort_unstable_by_key(|[x, y, z]| [*z, *y, *x]);
            return Ok((open, is_full));
        }
        side /= 2;
        let halves = open
            .iter()
            .flat_map(|first| (0..8).map(|half| [0, 1, 2].map(|axis| first[axis] + side * (half >> axis & 1))));
        open = halves.filter(|first| (0..3).all(|axis| first[axis] + 1 < lattice.size[axis])).collect();
    }
}

/// The samples that cubes need: their own, and the first ones of the cubes after them on each axis.
fn needed(samples: &Samples, cubes: &Cubes) -> Vec<(u32, u64, u64)> {
    let mut masks = [0_u64; 8];
    for (neighbor, mask) in masks.iter_mut().enumerate() {
        let is_needed = |at: &[u32; 3]| (0..3).all(|axis| neighbor >> axis & 1 == 0 || at[axis] == 0);
        *mask = each([0; 3], u64::MAX).filter(is_needed).map(|at| 1 << Samples::bit(at)).sum();
    }
    let mut of: Vec<(u32, u64, u64)> = cubes
        .par_iter()
        .flat_map_iter(|low| {
            let own = low.map(|at| at / BLOCK);
            (0..8).map(move |neighbor| {
                let cube = [0, 1, 2].map(|axis| own[axis] + (neighbor >> axis & 1));
                (samples.number(cube), masks[neighbor as usize], 0)
            })
        })
        .collect();
    of.par_sort_unstable();
    of.dedup_by(|next, kept| {
        let is_same = next.0 == kept.0;
        kept.1 |= if is_same { next.1 } else { 0 };
        is_same
    });
    of
}

/// The 5^3 sides of a cube of cells.
fn gathered(samples: &Samples, low: [u32; 3]) -> u128 {
    let own = low.map(|at| at / BLOCK);
    let inside: [u64; 8] = std::array::from_fn(|neighbor| {
        samples.inside(samples.number([0, 1, 2].map(|axis| own[axis] + (neighbor as u32 >> axis & 1))))
    });
    let mut bits = 0;
    for at in 0..(BLOCK + 1).pow(3) {
        let at = [at % (BLOCK + 1), at / (BLOCK + 1) % (BLOCK + 1), at / (BLOCK + 1).pow(2)];
        let neighbor = (0..3).map(|axis| (at[axis] / BLOCK) << axis).sum::<u32>();
        if inside[neighbor as usize] >> Samples::bit(at) & 1 == 1 {
            bits |= SignBlock::bit(at);
        }
    }
    bits
}
