//! The noises of PH 2.3 as sums over the eight knots around a place: w(u) w(v) w(w) times what the knot gives.

use crate::formulas::dual::{Dual, Place, dual, moved, scaled};
use crate::formulas::values::c;
use glam::DVec3;
use hypertexture::noise::{Noise, Weights};
use std::sync::LazyLock;

/// The weight of a knot at a distance in [0, 1] along one axis.
pub type Weight = fn(Dual) -> Dual;

/// PH 2.3: 2 |t|^3 - 3 t^2 + 1.
pub fn cubic(t: Dual) -> Dual {
    let t = t.abs();
    t * t * t * 2.0 - t * t * 3.0 + 1.0
}

/// Perlin 2002, the near side: 1 - (6 |t|^5 - 15 t^4 + 10 |t|^3).
pub fn quintic(t: Dual) -> Dual {
    let t = t.abs();
    let cube = t * t * t;
    dual(1.0) - (cube * t * t * 6.0 - cube * t * 15.0 + cube * 10.0)
}

/// The sum; `knot` gets the lattice point and the way from it.
pub fn sum(p: Place, weight: Weight, knot: impl Fn([i64; 3], Place) -> Dual) -> Dual {
    let base = p.map(|c| c.v.floor());
    let knots = (0..8).map(|corner: usize| {
        let point: [f64; 3] = std::array::from_fn(|axis| base[axis] + (corner >> axis & 1) as f64);
        let way = moved(p, -DVec3::from(point));
        weight(way[0]) * weight(way[1]) * weight(way[2]) * knot(point.map(|at| at as i64), way)
    });
    knots.fold(dual(0.0), |sum, knot| sum + knot)
}

fn dot(direction: [f64; 3], way: Place) -> Dual {
    way[0] * direction[0] + way[1] * direction[1] + way[2] * direction[2]
}

/// The direction of a lattice point: (a, a, c) in one of three orders, with signs of its own.
fn direction(point: [i64; 3], cells: u32) -> [f64; 3] {
    let words = [0x8da6_b343u32, 0xd816_3841, 0xcb1a_b31f];
    let mixed = (0..3).fold(0, |h, axis| {
        let cell = point[axis].rem_euclid(i64::from(cells)) as u32;
        h ^ cell.wrapping_mul(words[axis])
    });
    let mixed = mixed.wrapping_mul(0x27d4_eb2d);
    let bits = mixed ^ (mixed >> 15);
    // 2 a^2 + c^2 = 1 and 2 a^4 + c^4 = 3/5: with s = a^2, 6 s^2 - 4 s + 2/5 = 0.
    let minor = (4.0 - (16.0f64 - 9.6).sqrt()) / 12.0;
    let (minor, major) = (c(minor.sqrt()), c((1.0 - 2.0 * minor).sqrt()));
    let third = (f64::from(bits) / 4_294_967_296.0 * 3.0) as usize;
    std::array::from_fn(|axis| {
        let size = if axis == third { major } else { minor };
        if bits >> axis & 1 == 1 { -size } else { size }
    })
}

/// `noise=procedural` with weights and a period.
pub fn lattice(p: Place, weight: Weight, cells: u32) -> Dual {
    sum(p, weight, |point, way| dot(direction(point, cells), way))
}

/// `noise=procedural` without a period that shows.
pub fn noise(p: Place) -> Dual {
    lattice(p, quintic, 1 << 20)
}

/// Perlin's noise of 1989, n = 256: Gamma = G[phi(i + phi(j + phi(k)))], with gradients as they are stored.
pub fn perlin(p: Place, weight: Weight, stored: fn(f64) -> f64) -> Dual {
    static TABLES: LazyLock<Noise> = LazyLock::new(|| Noise::new(1989, Weights::Quintic));
    let (permutation, gradients) = TABLES.tables();
    let phi = |index: i64| i64::from(permutation[index.rem_euclid(256) as usize]);
    sum(p, weight, |[i, j, k], way| dot(gradients[phi(i + phi(j + phi(k))) as usize].map(stored), way))
}

/// PCG3D of Jarzynski and Olano 2020, as they print it.
pub fn pcg3d(v: [u32; 3]) -> [u32; 3] {
    let [mut x, mut y, mut z] = v.map(|v| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    for round in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(z));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        if round == 0 {
            (x, y, z) = (x ^ x >> 16, y ^ y >> 16, z ^ z >> 16);
        }
    }
    [x, y, z]
}

/// PH 2.3, footnote: a constant in place of the gradient, here in [-0.866, 0.866].
pub fn wavelet(p: Place, weight: Weight) -> Dual {
    sum(p, weight, |point, _| {
        let word = pcg3d(point.map(|at| at as i32 as u32))[0];
        dual(f64::from(word) * c(3f64.sqrt()) / 4_294_967_296.0 - c(0.75f64.sqrt()))
    })
}

/// Sum of octaves, each twice as fine and half as strong.
pub fn octaves(p: Place, count: u32, octave: impl Fn(Place, u32) -> Dual) -> Dual {
    let scales = (0..count).map(|index| (index, f64::from(1u32 << index)));
    scales.fold(dual(0.0), |sum, (index, scale)| sum + octave(scaled(p, scale), index) / scale)
}

/// PH 2.3: the turbulence of the procedural noise.
pub fn turbulence(p: Place) -> Dual {
    octaves(p, crate::formulas::harness::OCTAVES, |p, _| noise(p).abs())
}

/// PH 2.4 (tribble): [noise(p - s), noise(p), noise(p + s)].
pub fn vector_noise(p: Place) -> Place {
    let shift = DVec3::new(c(13.2), c(5.82), c(7.11));
    [noise(moved(p, -shift)), noise(p), noise(moved(p, shift))]
}
