//! Places where the density crosses its level, on the edges of a grid.
//!
//! Source: Dowell & Jarratt 1971 (the Illinois variant of the false position).

use super::lattice::Lattice;
use super::program::Density;
use crate::eval::ExactError;
use crate::field::Progress;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Edges in a batch of a thread.
const EDGES: usize = 1024;
/// Accuracy, in lengths of an edge. Lower: coordinates of 32 bits hold no more. Higher: surfaces of one object differ.
const ACCURACY: f64 = 1.0 / (1 << 20) as f64;
/// Least part of an edge between a vertex and the ends of its edge: vertices of several edges at one place would be one.
const APART: f64 = 1.0 / (1 << 13) as f64;
/// Steps by the false position; bisection follows, which a density that jumps needs.
const FALSE_POSITIONS: u32 = 12;

/// Bracket of a crossing on an edge: 0 is its end inside, 1 that outside.
struct Bracket {
    ends: [DVec3; 2],
    /// Parts of the edge known to be inside and outside.
    inside: f64,
    outside: f64,
    /// Densities there minus the level; halved where that end stays for long.
    values: [f64; 2],
    /// The end that moved last.
    moved: Option<usize>,
    found: f64,
}

impl Bracket {
    fn next(&self, step: u32) -> f64 {
        let [high, low] = self.values;
        let part = if step < FALSE_POSITIONS { high / (high - low) } else { 0.5 };
        let width = self.outside - self.inside;
        self.inside + width * if part.is_finite() { part.clamp(1e-3, 1.0 - 1e-3) } else { 0.5 }
    }

    /// Takes over a value, and returns whether the crossing is accurate.
    fn narrow(&mut self, at: f64, value: f64) -> bool {
        let end = usize::from(value < 0.0);
        if value < 0.0 {
            self.outside = at
        } else {
            self.inside = at
        }
        self.values[end] = value;
        if self.moved.replace(end) == Some(end) {
            self.values[1 - end] *= 0.5;
        }
        let change = (at - self.found).abs();
        self.found = at;
        change < ACCURACY || self.outside - self.inside < ACCURACY
    }

    fn place(&self, part: f64) -> DVec3 {
        self.ends[0].lerp(self.ends[1], part)
    }
}

/// Finds the crossing of each edge, to 2^-20 of it and to 2^-13 at its ends, and the nearest place known to be inside, object space.
pub(crate) fn crossings(
    density: &Density<'_>,
    lattice: &Lattice,
    edges: &[[u32; 2]],
    progress: Progress<'_>,
) -> Result<Vec<[DVec3; 2]>, ExactError> {
    let (edges_in_all, done) = (edges.len() as f32, AtomicUsize::new(0));
    let chunks = edges.par_chunks(EDGES).map(|edges| {
        let found = batch(density, lattice, edges)?;
        let done = done.fetch_add(found.len(), Ordering::Relaxed) + found.len();
        progress(done as f32 / edges_in_all);
        Ok(found)
    });
    Ok(chunks.collect::<Result<Vec<_>, ExactError>>()?.concat())
}

fn batch(density: &Density<'_>, lattice: &Lattice, edges: &[[u32; 2]]) -> Result<Vec<[DVec3; 2]>, ExactError> {
    let ends: Vec<[DVec3; 2]> = edges.iter().map(|edge| edge.map(|end| lattice.place(lattice.of_index(end)))).collect();
    let values = density.at(ends.as_flattened())?;
    let mut brackets: Vec<Bracket> = (ends.iter().zip(values.as_chunks::<2>().0))
        .map(|(ends, values)| {
            let values = values.map(|value| value - density.level);
            Bracket { ends: *ends, inside: 0.0, outside: 1.0, values, moved: None, found: f64::INFINITY }
        })
        .collect();
    let mut active: Vec<usize> = (0..brackets.len()).collect();
    let mut step = 0;
    while !active.is_empty() {
        let parts: Vec<f64> = active.iter().map(|edge| brackets[*edge].next(step)).collect();
        let places: Vec<DVec3> = active.iter().zip(&parts).map(|(edge, part)| brackets[*edge].place(*part)).collect();
        let mut found = parts.iter().zip(density.at(&places)?);
        active.retain(|edge| {
            let narrowed = found.next().map(|(part, value)| brackets[*edge].narrow(*part, value - density.level));
            narrowed == Some(false)
        });
        step += 1;
    }
    let of =
        |bracket: &Bracket| [bracket.place(bracket.found.clamp(APART, 1.0 - APART)), bracket.place(bracket.inside)];
    Ok(brackets.iter().map(of).collect())
}
