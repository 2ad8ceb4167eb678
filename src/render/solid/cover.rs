//! Proof that a mesh stays within a distance of the surface of a density.
//!
//! Role: a distance function changes at most as fast as the place. Where the density has both sides within h of c, the
//! surface passes there too, so that each place within r of c has the surface within r + h.
//! Triangles are covered by such spheres; the corners, which lie on the surface, cover what is near them. So evaluations at
//! places, in f64, prove what holds between them.

use super::triangle::{Corners, around, normal, rotated};
use crate::eval::ExactError;
use crate::field::Progress;
use crate::render::density::Density;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Radius of the largest spheres, in the distance to prove. Lower: more spheres. Higher: their pieces of lines are short.
const LARGEST: f64 = 0.7;
/// Radius below which both sides are looked for in all directions, which creases need.
const SMALL: f64 = 0.4;
/// Radius below which a place without a proof is given up.
const SMALLEST: f64 = 0.15;
/// Triangles in a batch of a thread, and parts of them that are evaluated at a time.
const BATCH: usize = 256;
const PATCHES: usize = 1024;

/// A part of a triangle.
struct Patch {
    corners: Corners,
    /// Number of its triangle in the batch.
    of: usize,
}

/// Which triangles are proven to stay within `distance` of the surface, if their corners lie on it to `exact`.
pub(super) fn proven(
    density: &Density<'_>,
    triangles: &[Corners],
    (distance, exact): (f64, f64),
    progress: Progress<'_>,
) -> Result<Vec<bool>, ExactError> {
    let (all, done) = (triangles.len() as f32, AtomicUsize::new(0));
    let chunks = triangles.par_chunks(BATCH).map(|triangles| {
        let found = batch(density, triangles, (distance, exact))?;
        progress((done.fetch_add(found.len(), Ordering::Relaxed) + found.len()) as f32 / all);
        Ok(found)
    });
    Ok(chunks.collect::<Result<Vec<_>, ExactError>>()?.concat())
}

fn batch(density: &Density<'_>, triangles: &[Corners], (distance, exact): (f64, f64)) -> Result<Vec<bool>, ExactError> {
    let normals: Vec<DVec3> = triangles.iter().map(|corners| normal(corners).normalize_or_zero()).collect();
    let mut is_proven = vec![true; triangles.len()];
    let mut left: Vec<Patch> =
        triangles.iter().enumerate().map(|(of, corners)| Patch { corners: *corners, of }).collect();
    while !left.is_empty() {
        let (mut asked, mut next) = (Vec::new(), Vec::new());
        // The last ones first: few wait, and a triangle that fails takes its other parts with it.
        let first = left.len().saturating_sub(PATCHES);
        for patch in left.drain(first..).filter(|patch| is_proven[patch.of]) {
            let (center, radius) = around(&patch.corners);
            let nearest =
                triangles[patch.of].map(|corner| corner.distance(center)).into_iter().fold(f64::INFINITY, f64::min);
            if nearest + radius + exact <= distance {
                continue;
            }
            if radius > LARGEST * distance {
                next.extend(halves(&patch));
            } else {
                asked.push((patch, center, radius));
            }
        }
        let places: Vec<DVec3> = (asked.iter())
            .flat_map(|(patch, center, radius)| {
                let way = (distance - radius) * normals[patch.of];
                [center - way, center + way]
            })
            .collect();
        let mut open = Vec::new();
        for (asked, pair) in asked.into_iter().zip(density.at(&places)?.as_chunks::<2>().0) {
            let [below, above] = pair.map(|value| value >= density.level);
            match asked {
                _ if below != above => {}
                (patch, _, radius) if radius > SMALL * distance => next.extend(halves(&patch)),
                (patch, center, radius) => open.push((patch, center, radius, below)),
            }
        }
        let around = |center: DVec3, radius: f64| {
            let axes = DVec3::AXES.map(|axis| (distance - radius) * axis);
            axes.into_iter().flat_map(move |way| [center - way, center + way]).collect::<Vec<_>>()
        };
        let places: Vec<DVec3> = open.iter().flat_map(|(_, center, radius, _)| around(*center, *radius)).collect();
        for ((patch, _, radius, side), values) in open.into_iter().zip(density.at(&places)?.as_chunks::<6>().0) {
            if values.iter().any(|value| (*value >= density.level) != side) {
                continue;
            }
            if radius > SMALLEST * distance {
                next.extend(halves(&patch));
            } else {
                is_proven[patch.of] = false;
            }
        }
        left.append(&mut next);
    }
    Ok(is_proven)
}

/// The halves of a patch at its longest side.
fn halves(patch: &Patch) -> [Patch; 2] {
    let [a, b, c] = rotated(&patch.corners);
    let middle = 0.5 * (a + b);
    [[a, middle, c], [middle, b, c]].map(|corners| Patch { corners, of: patch.of })
}
