//! Surfaces buried in a solid: where solids overlap, the parts of each inside another are not boundary.
//!
//! Invariant: a removed piece has, at its samples, the inside on both of its sides.

use super::tetra::Triangle;
use super::winding::{POINTS, Winding, inside};
use glam::Vec3;
use rayon::prelude::*;

/// Distance of the two sides that are compared, in voxels. Smaller: the solid angle of the triangle itself loses its
/// sign to rounding. Larger: thin walls are looked through.
const SIDE: f32 = 0.02;
/// A triangle that is partly buried is divided until its edges are this short, in voxels. Smaller: costs more.
/// Larger: the seam where two solids meet reaches visibly into the solid.
const SEAM: f32 = 0.5;
/// A triangle with longer edges is divided even where its samples agree, so that a rod through it is seen.
const COARSE: f32 = 8.0;

/// The triangles that bound the solid, cut where they dive into another.
pub(super) fn boundary(triangles: &[Triangle], winding: &Winding) -> Vec<Triangle> {
    let pieces = triangles.par_chunks(64).map(|chunk| {
        let mut kept = Vec::new();
        chunk.iter().for_each(|triangle| keep(triangle, winding, &mut kept));
        kept
    });
    pieces.collect::<Vec<_>>().concat()
}

fn keep(triangle: &Triangle, winding: &Winding, kept: &mut Vec<Triangle>) {
    let [a, b, c] = *triangle;
    let normal = (b - a).cross(c - a).normalize_or_zero() * SIDE;
    let center = (a + b + c) / 3.0;
    let samples = [center, center.lerp(a, 0.9), center.lerp(b, 0.9), center.lerp(c, 0.9)];
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    if longest <= COARSE {
        let sides: [Vec3; POINTS] = std::array::from_fn(|side| {
            let sample = samples[side / 2];
            if side % 2 == 0 { sample + normal } else { sample - normal }
        });
        let numbers = winding.around(&sides);
        let count = numbers.chunks(2).filter(|sides| sides.iter().all(|number| inside(*number))).count();
        if count == samples.len() {
            return;
        }
        if count == 0 || longest <= SEAM {
            kept.push(*triangle);
            return;
        }
    }
    // Halving the longest edge ends for slivers too.
    let [a, b, c] = if a.distance(b) == longest {
        [a, b, c]
    } else if b.distance(c) == longest {
        [b, c, a]
    } else {
        [c, a, b]
    };
    let middle = a.midpoint(b);
    keep(&[a, middle, c], winding, kept);
    keep(&[middle, b, c], winding, kept);
}
