//! The noises of `glsl/noise` in f64: what the toolkit is compared with.

#![allow(dead_code, reason = "each file of tests uses its part of this")]

use glam::DVec3;
use hypertexture::noise::Lattice;

/// Three random words for a lattice point: PCG3D.
fn hash(cell: [i64; 3]) -> [u32; 3] {
    let mut v = cell.map(|c| (c as i32 as u32).wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let mix = |v: &mut [u32; 3]| {
        for axis in 0..3 {
            v[axis] = v[axis].wrapping_add(v[(axis + 1) % 3].wrapping_mul(v[(axis + 2) % 3]));
        }
    };
    mix(&mut v);
    v = v.map(|c| c ^ (c >> 16));
    mix(&mut v);
    v
}

/// Sum over the eight knots around `p` of their quintic weight times what `knot` gives for hash and offset.
fn sum(p: DVec3, knot: impl Fn([u32; 3], DVec3) -> f64) -> f64 {
    let base = p.floor();
    let t = p - base;
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let corner = |corner: u32| {
        let side = DVec3::from([corner & 1, corner >> 1 & 1, corner >> 2].map(f64::from));
        let cell = (base + side).to_array().map(|c| c as i64);
        let weight: f64 = (0..3).map(|a| if side[a] == 1.0 { fade(t[a]) } else { 1.0 - fade(t[a]) }).product();
        weight * knot(hash(cell), t - side)
    };
    (0..8).map(corner).sum()
}

const WORDS: f64 = 4_294_967_296.0;

/// `noise=procedural`.
pub fn noise(p: DVec3) -> f64 {
    Lattice::default().sample(p.to_array(), 1 << 20).1
}

/// `noise=wavelet`.
pub fn wavelet(p: DVec3) -> f64 {
    sum(p, |bits, _| (f64::from(bits[0]) * 2.0 / WORDS - 1.0) * 0.75f64.sqrt())
}

/// Sum of octaves, each twice as fine and half as strong.
pub fn octaves(p: DVec3, count: u32, of: impl Fn(f64) -> f64) -> f64 {
    (0..count).map(|octave| f64::from(1u32 << octave)).map(|scale| of(noise(scale * p)) / scale).sum()
}
