//! A picture beside what its scene gives when it is drawn again.

use crate::statistics::largest;
use hypertexture::output::{Encoding, Stored};
use hypertexture::render::Frame;
use hypertexture::scene::Scene;

/// What another device's rounding may make of a pixel: so many codes, or so much in a float.
pub(super) const CODES: f64 = 2.0;
pub(super) const FLOATS: f64 = 1e-3;

/// A picture beside what is drawn again.
pub(super) struct Redrawn {
    pub(super) same_device: bool,
    /// Pixels that differ, and those of them that nothing around them explains.
    pub(super) differs: usize,
    pub(super) foreign: usize,
    pub(super) worst: ([u32; 2], f64),
}

pub(super) fn redraw(stored: &Stored, scene: &Scene, drawn: &Frame, same_device: bool) -> Redrawn {
    let Stored { size, encoding, .. } = *stored;
    let codes = |at| encoding.rounded(encoding.of(drawn.pixels[index(size, at)], scene.image.background));
    let allowed = match (same_device, encoding) {
        (true, _) => 0.0,
        (_, Encoding::Codes(_)) => (CODES + 0.5) * encoding.quantum(),
        (_, Encoding::Linear) => FLOATS,
    };
    let mut redrawn = Redrawn { same_device, differs: 0, foreign: 0, worst: ([0, 0], 0.0) };
    for at in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y])) {
        let own = stored.pixels[index(size, at)];
        let off = largest(apart(own, codes(at), encoding));
        if off <= allowed {
            continue;
        }
        redrawn.differs += 1;
        let [mut low, mut high] = [codes(at); 2];
        for code in around(size, at).map(codes) {
            low = std::array::from_fn(|c| low[c].min(code[c]));
            high = std::array::from_fn(|c| high[c].max(code[c]));
        }
        let within = std::array::from_fn(|c| own[c].clamp(low[c], high[c]));
        let is_around = largest(apart(own, within, encoding)) <= allowed;
        redrawn.foreign += usize::from(!is_around);
        redrawn.worst = if off > redrawn.worst.1 { (at, off) } else { redrawn.worst };
    }
    redrawn
}

/// A pixel and those around it.
pub(super) fn around(size: [u32; 2], [x, y]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    let columns = x.saturating_sub(1)..=(x + 1).min(size[0] - 1);
    (y.saturating_sub(1)..=(y + 1).min(size[1] - 1)).flat_map(move |y| columns.clone().map(move |x| [x, y]))
}

/// How far two pixels in an encoding are apart, channel by channel. A color that is not seen does not count.
pub(super) fn apart(a: [f32; 4], b: [f32; 4], encoding: Encoding) -> [f64; 4] {
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
