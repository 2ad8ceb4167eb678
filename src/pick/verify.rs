//! A way held against the f64 reference.

use super::Metric;
use crate::glsl::Library;
use crate::gpu::Gpu;
use crate::reference::{ReferenceError, TOLERANCE, reference_pixels};
use crate::render::{Subject, render};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// Part of the pixels that are looked at.
const PART: f64 = 0.05;
/// The fewest and the most of them.
const PIXELS: [usize; 2] = [256, 1024];
/// Side of a tile: neighbors share the cost of what they look at, and edges fall into whole tiles.
const TILE: u32 = 4;

/// What the reference says of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verified {
    /// Error over the pixels that were looked at.
    pub error: f64,
    /// Root mean square of what the reference says of its own error.
    pub estimate: f64,
    /// Pixels that were looked at.
    pub pixels: usize,
    /// Milliseconds of the whole picture on the device.
    pub ms: f64,
}

pub(super) fn verify(
    gpu: &Gpu,
    library: &Library,
    scene: &Scene,
    subject: &Subject,
    metric: Metric,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Verified, ReferenceError> {
    let pixels = tiles(scene.image.size);
    let reference = reference_pixels(library, scene, subject, &pixels, TOLERANCE, progress)?;
    let frame = render(gpu, library, scene, subject)?;
    let width = scene.image.size[0] as usize;
    let drawn = pixels.iter().map(|[x, y]| frame.pixels[*y as usize * width + *x as usize].map(f64::from));
    let error = metric.of(drawn.zip(reference.pixels.iter().copied()));
    let estimate = super::root_mean_square(reference.estimate.iter().copied());
    let ms = frame.measurements.gpu_ms + frame.measurements.shadow_ms.unwrap_or(0.0);
    Ok(Verified { error, estimate, pixels: pixels.len(), ms })
}

/// Pixels in tiles that are spread over a picture: one in each cell of a grid, at a place in it that changes.
fn tiles([width, height]: [u32; 2]) -> Vec<[u32; 2]> {
    let all = width as usize * height as usize;
    let wanted = ((all as f64 * PART) as usize).clamp(PIXELS[0], PIXELS[1]).min(all);
    let area = (all as f64 / wanted as f64).max(1.0) * f64::from(TILE * TILE);
    let cell = (area.sqrt() as u32).max(TILE);
    let mut pixels = Vec::new();
    for (row, top) in (0..height).step_by(cell as usize).enumerate() {
        for (column, left) in (0..width).step_by(cell as usize).enumerate() {
            let free = u64::from(cell - TILE + 1);
            let mixed =
                (row as u64 * 0x9e37_79b9 + column as u64 * 0x85eb_ca6b + 1).wrapping_mul(0x2545_f491_4f6c_dd1d);
            let [dx, dy] = [(mixed >> 40) % free, (mixed >> 20) % free];
            let (x, y) = (left + dx as u32, top + dy as u32);
            let inside = |x: &u32, y: &u32| *x < width && *y < height;
            let tile = (y..y + TILE).flat_map(|y| (x..x + TILE).map(move |x| [x, y]));
            pixels.extend(tile.filter(|[x, y]| inside(x, y)));
        }
    }
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn tiles_cover_about_a_twentieth_of_a_picture_and_no_pixel_twice() {
        for size in [[512, 512], [300, 200], [128, 128], [97, 31], [4, 4], [1, 1]] {
            let pixels = tiles(size);
            let all = size[0] as usize * size[1] as usize;
            let distinct: BTreeSet<_> = pixels.iter().collect();
            assert_eq!(distinct.len(), pixels.len(), "{size:?}");
            assert!(pixels.iter().all(|[x, y]| *x < size[0] && *y < size[1]));
            let wanted = (all / 20).clamp(256, 1024).min(all);
            assert!(pixels.len() <= 2 * wanted && 2 * pixels.len() >= wanted.min(all), "{size:?}: {}", pixels.len());
        }
    }
}
