//! Surfaces buried in a solid: where solids overlap, the parts of each inside another are not boundary.
//!
//! Invariant: a removed piece has, at its samples, the inside on both of its sides. The work is bounded by the grid, however
//! often triangles cross: what is not looked at by then is kept, which leaves the outside as it is.

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
/// Nodes and triangles that are looked at for one sample of the grid, at least for all of them (about a second of a
/// processor), and for one triangle besides: four times what one of the teapot takes. Fewer: scans of several solids keep
/// parts of their seams. More: a tangle takes minutes.
const VISITS: u64 = 8;
const LEAST_VISITS: u64 = 24_000_000;
const VISITS_OF_TRIANGLE: u64 = 2048;
/// Pieces that are looked at between two looks at what has been spent.
const TOGETHER: usize = 1024;

/// What becomes of a piece.
enum Fate {
    Buried,
    Kept,
    Divided([Triangle; 2]),
}

/// The triangles that bound the solid, cut where they dive into another, on a grid of so many samples; and whether some were
/// kept that nobody looked at.
pub(super) fn boundary(triangles: &[Triangle], winding: &Winding, samples: u64) -> (Vec<Triangle>, bool) {
    let mut left = (VISITS * samples).max(LEAST_VISITS) + VISITS_OF_TRIANGLE * triangles.len() as u64;
    let (mut pieces, mut kept, mut is_tangled) = (triangles.to_vec(), Vec::new(), false);
    while !pieces.is_empty() {
        let mut next = Vec::new();
        for pieces in pieces.chunks(TOGETHER) {
            if left == 0 {
                kept.extend_from_slice(pieces);
                is_tangled = true;
                continue;
            }
            let fates: Vec<(Fate, u64)> = pieces.par_iter().map(|piece| fate(piece, winding)).collect();
            for (piece, (fate, visits)) in pieces.iter().zip(fates) {
                left = left.saturating_sub(visits);
                match fate {
                    Fate::Buried => {}
                    Fate::Kept => kept.push(*piece),
                    Fate::Divided(halves) => next.extend(halves),
                }
            }
        }
        pieces = next;
    }
    (kept, is_tangled)
}

/// What becomes of a piece, and what it took to see that.
fn fate(triangle: &Triangle, winding: &Winding) -> (Fate, u64) {
    let [a, b, c] = *triangle;
    let normal = (b - a).cross(c - a).normalize_or_zero() * SIDE;
    let center = (a + b + c) / 3.0;
    let samples = [center, center.lerp(a, 0.9), center.lerp(b, 0.9), center.lerp(c, 0.9)];
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let mut visits = 1;
    if longest <= COARSE {
        let sides: [Vec3; POINTS] = std::array::from_fn(|side| {
            let sample = samples[side / 2];
            if side % 2 == 0 { sample + normal } else { sample - normal }
        });
        let numbers;
        (numbers, visits) = winding.around_counted(&sides);
        let count = numbers.chunks(2).filter(|sides| sides.iter().all(|number| inside(*number))).count();
        if count == samples.len() {
            return (Fate::Buried, visits);
        }
        if count == 0 || longest <= SEAM {
            return (Fate::Kept, visits);
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
    (Fate::Divided([[a, middle, c], [middle, b, c]]), visits)
}
