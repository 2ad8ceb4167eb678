//! Removal of surfaces buried in overlapping solids.
//!
//! Invariant: a removed piece has the inside on both sides at its samples. The work is bounded by the size of the grid; pieces
//! left by then are kept, which does not change the outside.

use super::tetra::Triangle;
use super::winding::{POINTS, Winding, inside};
use glam::Vec3;
use rayon::prelude::*;

/// Offset of the compared points from the surface, in voxels. Lower loses the sign of the triangle's own solid angle to
/// rounding; higher reaches through thin walls.
const SIDE: f32 = 0.02;
/// Edge length in voxels at which partly buried triangles stay undivided. Lower costs more; higher leaves visible seams
/// inside the solid.
const SEAM: f32 = 0.5;
/// Edge length in voxels above which triangles are divided even if their samples agree, to find thin crossings.
const COARSE: f32 = 8.0;
/// Limits of visited nodes and triangles: per sample of the grid, in total at least (about a second of processor time), and per
/// triangle (four times the need of the teapot). Lower leaves seams in scans of several solids; higher spends minutes on
/// tangles.
const VISITS: u64 = 8;
const LEAST_VISITS: u64 = 24_000_000;
const VISITS_OF_TRIANGLE: u64 = 2048;
/// Pieces processed between two checks of the limit.
const BATCH: usize = 1024;

/// Verdict on a piece.
enum Fate {
    Buried,
    Kept,
    Divided([Triangle; 2]),
}

/// The triangles that bound the solid, cut where they enter another, and whether the limit of work was reached. `samples` is the
/// size of the grid.
pub(super) fn boundary(triangles: &[Triangle], winding: &Winding, samples: u64) -> (Vec<Triangle>, bool) {
    let mut left = (VISITS * samples).max(LEAST_VISITS) + VISITS_OF_TRIANGLE * triangles.len() as u64;
    let (mut pieces, mut kept, mut is_tangled) = (triangles.to_vec(), Vec::new(), false);
    while !pieces.is_empty() {
        let mut next = Vec::new();
        for pieces in pieces.chunks(BATCH) {
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

/// The verdict on a piece, and the number of visits it took.
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
    // Halving the longest edge terminates for slivers too.
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
