//! Differences between a picture and a new rendering of its scene.

use crate::statistics::largest;
use hypertexture::output::{Encoding, Stored};
use hypertexture::render::Frame;
use hypertexture::scene::Scene;

/// Rounding of another device, in codes and in floats.
pub(super) const CODES: f64 = 2.0;
pub(super) const FLOATS: f64 = 1e-3;

/// Difference between a picture and a new rendering.
pub(super) struct Difference {
    pub(super) same_device: bool,
    /// Pixels that differ.
    pub(super) differs: usize,
    /// Pixels that differ and lie outside of the range of their neighbors.
    pub(super) foreign: usize,
    /// Place and size of the largest difference.
    pub(super) worst: ([u32; 2], f64),
}

pub(super) fn compare_rendering(stored: &Stored, scene: &Scene, drawn: &Frame, same_device: bool) -> Difference {
    let Stored { size, encoding, .. } = *stored;
    let codes = |at| encoding.rounded(encoding.of(drawn.pixels[index(size, at)], scene.image.background));
    let allowed = match (same_device, encoding) {
        (true, _) => 0.0,
        (_, Encoding::Codes(_)) => (CODES + 0.5) * encoding.quantum(),
        (_, Encoding::Linear) => FLOATS,
    };
    let mut found = Difference { same_device, differs: 0, foreign: 0, worst: ([0, 0], 0.0) };
    for at in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y])) {
        let own = stored.pixels[index(size, at)];
        let off = largest(difference(own, codes(at), encoding));
        if off <= allowed {
            continue;
        }
        found.differs += 1;
        let [mut low, mut high] = [codes(at); 2];
        for code in neighborhood(size, at).map(codes) {
            low = std::array::from_fn(|c| low[c].min(code[c]));
            high = std::array::from_fn(|c| high[c].max(code[c]));
        }
        let within = std::array::from_fn(|c| own[c].clamp(low[c], high[c]));
        let is_near = largest(difference(own, within, encoding)) <= allowed;
        found.foreign += usize::from(!is_near);
        found.worst = if off > found.worst.1 { (at, off) } else { found.worst };
    }
    found
}

/// A pixel and its neighbors.
pub(super) fn neighborhood(size: [u32; 2], [x, y]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    let columns = x.saturating_sub(1)..=(x + 1).min(size[0] - 1);
    (y.saturating_sub(1)..=(y + 1).min(size[1] - 1)).flat_map(move |y| columns.clone().map(move |x| [x, y]))
}

/// Difference of two encoded pixels per channel. Colors of a PNG are weighted by alpha.
pub(super) fn difference(a: [f32; 4], b: [f32; 4], encoding: Encoding) -> [f64; 4] {
    let seen = match encoding {
        Encoding::Codes(_) => f64::from(a[3].max(b[3])),
        Encoding::Linear => 1.0,
    };
    let off = |c: usize| f64::from(a[c] - b[c]).abs();
    [seen * off(0), seen * off(1), seen * off(2), off(3)]
}

pub(super) fn index(size: [u32; 2], [x, y]: [u32; 2]) -> usize {
    y as usize * size[0] as usize + x as usize
}
