//! Baked blocks of lattice noise.
//!
//! Role: samples noise or turbulence on a tiling grid. Texels lie at the same offsets in every cell, so the corners of a cell
//! are summed axis by axis: along x for each lattice line, along y for each lattice plane, and along z with four products
//! per texel and octave. Invariant: a block equals `Lattice` at its texel centers up to f32 rounding.

use super::knots::direction;
use super::weights::Weights;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Planes of texels per task, and rows computed together, whose partial sums fit into the cache of a core.
const PLANES: usize = 16;
const ROWS: usize = 16;

/// Description of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bake {
    /// Interpolation weights.
    pub weights: Weights,
    /// Texels per side, a power of two. Texel i is centered at `(i + 0.5) / size`.
    pub size: u32,
    /// Lattice cells of the first octave per side, a power of two.
    pub cells: u32,
    /// Octaves summed.
    pub octaves: u32,
    /// Whether absolute values are summed (turbulence).
    pub absolute: bool,
}

/// Baked values, and gradients if requested, x fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// The sum at each texel.
    pub values: Vec<f32>,
    /// Gradient by axis, per cell of the first octave; empty if not requested.
    pub gradient: [Vec<f32>; 3],
}

/// Per texel offset in a cell, for near and far side: the weight, the weight times the distance from the side, and the slopes
/// of both.
struct Places {
    weight: [Vec<f32>; 2],
    moment: [Vec<f32>; 2],
    weight_slope: [Vec<f32>; 2],
    moment_slope: [Vec<f32>; 2],
}

impl Places {
    fn new(weights: Weights, texels: usize) -> Places {
        let at = |value: &dyn Fn(f64, f64, f64) -> f64, far: f64| {
            let place = |index: usize| {
                let t = (index as f64 + 0.5) / texels as f64;
                let (fade, slope) = weights.fade(t);
                let (weight, slope) = if far > 0.0 { (fade, slope) } else { (1.0 - fade, -slope) };
                value(weight, slope, t - far) as f32
            };
            (0..texels).map(place).collect::<Vec<f32>>()
        };
        let both = |value: &dyn Fn(f64, f64, f64) -> f64| [at(value, 0.0), at(value, 1.0)];
        Places {
            weight: both(&|weight, _, _| weight),
            moment: both(&|weight, _, from| weight * from),
            weight_slope: both(&|_, slope, _| slope),
            moment_slope: both(&|weight, slope, from| weight + slope * from),
        }
    }

    /// Factors of near and far side for the constant and the linear part along the axis.
    #[inline(always)]
    fn factors(&self, place: usize) -> [f32; 4] {
        [self.weight[0][place], self.weight[1][place], self.moment[0][place], self.moment[1][place]]
    }

    #[inline(always)]
    fn slopes(&self, place: usize) -> [f32; 4] {
        [
            self.weight_slope[0][place],
            self.weight_slope[1][place],
            self.moment_slope[0][place],
            self.moment_slope[1][place],
        ]
    }
}

/// Sums on a lattice plane for the rows of a task: constant and linear part along z, of the noise and of its slopes along x and y.
struct Plane {
    fields: [Vec<f32>; 6],
}

impl Plane {
    fn new(length: usize) -> Plane {
        Plane { fields: std::array::from_fn(|_| vec![0.0; length]) }
    }
}

/// A task: planes of a block, with their output.
struct Task<'a, const GRADIENT: bool> {
    bake: &'a Bake,
    places: &'a [Places],
    planes: std::ops::Range<usize>,
    out: [&'a mut [f32]; 4],
}

impl<const GRADIENT: bool> pulp::NullaryFnOnce for Task<'_, GRADIENT> {
    type Output = ();

    #[inline(always)] // with all its callees, to be compiled for the vectors of this processor
    fn call(mut self) {
        let side = self.bake.size as usize;
        for rows in (0..side).step_by(ROWS.min(side)) {
            for (octave, places) in (0..).zip(self.places) {
                self.bake.add::<GRADIENT>(octave, places, self.planes.clone(), rows, &mut self.out);
            }
        }
    }
}

impl Bake {
    /// Octaves out of `wanted` whose cells are at least two texels wide (PH 3.1).
    pub fn held(size: u32, cells: u32, wanted: u32) -> u32 {
        (0..wanted).take_while(|octave| (cells << octave) * 2 <= size).count() as u32
    }

    /// Bakes values only, a third of the work. `progress` receives the fraction done, from any thread.
    pub fn values(&self, progress: &(dyn Fn(f32) + Sync)) -> Block {
        self.bake::<false>(progress)
    }

    /// Bakes values and gradients. `progress` receives the fraction done, from any thread.
    pub fn values_and_gradients(&self, progress: &(dyn Fn(f32) + Sync)) -> Block {
        self.bake::<true>(progress)
    }

    fn bake<const GRADIENT: bool>(&self, progress: &(dyn Fn(f32) + Sync)) -> Block {
        let side = self.size as usize;
        let texels = side.pow(3);
        let slopes = if GRADIENT { texels } else { 0 };
        let mut values = vec![0.0; texels];
        let mut gradient: [Vec<f32>; 3] = std::array::from_fn(|_| vec![0.0; slopes]);
        let planes = PLANES.min(side);
        let length = planes * side * side;
        let places: Vec<Places> =
            (0..self.octaves).map(|octave| Places::new(self.weights, side / (self.cells << octave) as usize)).collect();
        let [x, y, z] = &mut gradient;
        let slope_length = if GRADIENT { length } else { 1 };
        let mut parts: Vec<[&mut [f32]; 4]> = Vec::new();
        let mut slopes = x.chunks_mut(slope_length).zip(y.chunks_mut(slope_length)).zip(z.chunks_mut(slope_length));
        for values in values.chunks_mut(length) {
            let ((x, y), z) = slopes.next().unwrap_or_default();
            parts.push([values, x, y, z]);
        }
        let (arch, done, all) = (pulp::Arch::new(), AtomicUsize::new(0), side / planes);
        parts.into_par_iter().enumerate().for_each(|(index, out)| {
            arch.dispatch(Task::<GRADIENT> {
                bake: self,
                places: &places,
                planes: index * planes..(index + 1) * planes,
                out,
            });
            progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f32 / all as f32);
        });
        Block { values, gradient }
    }

    /// Adds an octave to some rows of some planes.
    #[inline(always)]
    fn add<const GRADIENT: bool>(
        &self,
        octave: u32,
        places: &Places,
        planes: std::ops::Range<usize>,
        first_row: usize,
        out: &mut [&mut [f32]; 4],
    ) {
        let side = self.size as usize;
        let rows = ROWS.min(side);
        let texels = side / (self.cells << octave) as usize;
        let (mut near, mut far) = (Plane::new(rows * side), Plane::new(rows * side));
        let amplitude = 1.0 / (1u32 << octave) as f32;
        let mut lines = Lines::new(side, rows.div_ceil(texels) + 2);
        let mut cell = usize::MAX;
        for (plane, z) in planes.enumerate() {
            if z / texels != cell {
                if cell.wrapping_add(1) == z / texels && plane > 0 {
                    std::mem::swap(&mut near, &mut far);
                } else {
                    self.plane::<GRADIENT>(octave, places, z / texels, first_row, &mut lines, &mut near);
                }
                self.plane::<GRADIENT>(octave, places, z / texels + 1, first_row, &mut lines, &mut far);
                cell = z / texels;
            }
            let (factors, slopes) = (places.factors(z % texels), places.slopes(z % texels));
            let range = (plane * side + first_row) * side..(plane * side + first_row + rows) * side;
            let [values, x, y, zs] = out;
            let field = |index: usize| {
                [&near.fields[index][..], &far.fields[index], &near.fields[index + 1], &far.fields[index + 1]]
            };
            let values = &mut values[range.clone()];
            if GRADIENT {
                let out = [values, &mut x[range.clone()], &mut y[range.clone()], &mut zs[range]];
                add_gradients(out, [field(0), field(2), field(4)], factors, slopes, amplitude, self.absolute);
            } else {
                add_values(values, field(0), factors, amplitude, self.absolute);
            }
        }
    }

    /// Sums a lattice plane of an octave along x and y for some rows.
    #[inline(always)]
    fn plane<const GRADIENT: bool>(
        &self,
        octave: u32,
        places: &Places,
        plane: usize,
        first_row: usize,
        lines: &mut Lines,
        out: &mut Plane,
    ) {
        let (side, period) = (self.size as usize, self.cells << octave);
        let texels = side / period as usize;
        let rows = out.fields[0].len() / side;
        let first = first_row / texels;
        let count = (first_row + rows - 1) / texels - first + 2;
        for line in 0..count {
            lines
                .sum::<GRADIENT>(line, places, texels, |x| direction([x, (first + line) as u32, plane as u32], period));
        }
        for row in 0..rows {
            let (line, place) = ((first_row + row) / texels - first, (first_row + row) % texels);
            let (factors, slopes) = (places.factors(place), places.slopes(place));
            let at = |field: usize, far: usize| {
                let from = (line + far) * side;
                &lines.fields[field][from..from + side]
            };
            let four = |field: usize, grows: usize| [at(field, 0), at(field, 1), at(grows, 0), at(grows, 1)];
            let range = row * side..(row + 1) * side;
            mix_four(&mut out.fields[0][range.clone()], four(0, 1), factors);
            mix_two(&mut out.fields[1][range.clone()], [at(2, 0), at(2, 1)], factors);
            if GRADIENT {
                mix_four(&mut out.fields[2][range.clone()], four(3, 4), factors);
                mix_two(&mut out.fields[3][range.clone()], [at(5, 0), at(5, 1)], factors);
                mix_four(&mut out.fields[4][range.clone()], four(0, 1), slopes);
                mix_two(&mut out.fields[5][range], [at(2, 0), at(2, 1)], slopes);
            }
        }
    }
}

/// Lattice lines summed along x: the x part, and the factors of the y and z offsets; then the slopes of these along x.
struct Lines {
    side: usize,
    fields: [Vec<f32>; 6],
}

impl Lines {
    fn new(side: usize, lines: usize) -> Lines {
        Lines { side, fields: std::array::from_fn(|_| vec![0.0; lines * side]) }
    }

    /// Sums a line whose lattice points at x have `direction(x)`.
    #[inline(always)]
    fn sum<const GRADIENT: bool>(
        &mut self,
        line: usize,
        places: &Places,
        texels: usize,
        direction: impl Fn(u32) -> [f64; 3],
    ) {
        let side = self.side;
        let [u, y, z, ux, yx, zx] = &mut self.fields;
        let mut left = direction(0).map(|c| c as f32);
        for cell in 0..side / texels {
            let right = direction(cell as u32 + 1).map(|c| c as f32);
            for place in 0..texels {
                let (w, s) = (places.factors(place), places.slopes(place));
                let at = line * side + cell * texels + place;
                u[at] = left[0] * w[2] + right[0] * w[3];
                y[at] = left[1] * w[0] + right[1] * w[1];
                z[at] = left[2] * w[0] + right[2] * w[1];
                if GRADIENT {
                    ux[at] = left[0] * s[2] + right[0] * s[3];
                    yx[at] = left[1] * s[0] + right[1] * s[1];
                    zx[at] = left[2] * s[0] + right[2] * s[1];
                }
            }
            left = right;
        }
    }
}

/// `out = a w0 + b w1 + c w2 + d w3`.
#[inline(always)]
fn mix_four(out: &mut [f32], [a, b, c, d]: [&[f32]; 4], w: [f32; 4]) {
    for ((((out, a), b), c), d) in out.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        *out = a * w[0] + b * w[1] + c * w[2] + d * w[3];
    }
}

#[inline(always)]
fn mix_two(out: &mut [f32], [a, b]: [&[f32]; 2], w: [f32; 4]) {
    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
        *out = a * w[0] + b * w[1];
    }
}

/// Adds an octave to rows from its constant and linear part, near and far.
#[inline(always)]
fn add_values(out: &mut [f32], [a, b, c, d]: [&[f32]; 4], w: [f32; 4], amplitude: f32, absolute: bool) {
    let values = out.iter_mut().zip(a).zip(b).zip(c).zip(d);
    if absolute {
        for ((((out, a), b), c), d) in values {
            *out += amplitude * (a * w[0] + b * w[1] + c * w[2] + d * w[3]).abs();
        }
    } else {
        for ((((out, a), b), c), d) in values {
            *out += amplitude * (a * w[0] + b * w[1] + c * w[2] + d * w[3]);
        }
    }
}

/// Adds an octave with its gradient to rows, from the noise and its slopes along x and y, and the factors of z and their slopes.
/// The slope of an absolute value has the sign of the value. The chain rule's 2^i and the amplitude cancel.
#[inline(always)]
fn add_gradients(
    [values, xs, ys, zs]: [&mut [f32]; 4],
    [n, nx, ny]: [[&[f32]; 4]; 3],
    w: [f32; 4],
    s: [f32; 4],
    amplitude: f32,
    absolute: bool,
) {
    let length = values.len();
    let mix =
        |f: &[&[f32]; 4], w: &[f32; 4], i: usize| f[0][i] * w[0] + f[1][i] * w[1] + f[2][i] * w[2] + f[3][i] * w[3];
    let [n, nx, ny] = [n, nx, ny].map(|fields| fields.map(|field| &field[..length]));
    let (xs, ys, zs) = (&mut xs[..length], &mut ys[..length], &mut zs[..length]);
    let keep = if absolute { 0x8000_0000 } else { 0 };
    for i in 0..length {
        let value = mix(&n, &w, i);
        let sign = value.to_bits() & keep;
        let turned = |slope: f32| f32::from_bits(slope.to_bits() ^ sign);
        values[i] += amplitude * turned(value);
        xs[i] += turned(mix(&nx, &w, i));
        ys[i] += turned(mix(&ny, &w, i));
        zs[i] += turned(mix(&n, &s, i));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Lattice, Period};

    #[test]
    fn m34_a_block_is_the_noise_at_its_texel_centers() {
        for (size, cells, octaves, absolute, weights) in [
            (16, 4, 1, false, Weights::Quintic),
            (16, 4, 2, true, Weights::Cubic),
            (64, 4, 4, true, Weights::Quintic),
            (64, 16, 1, false, Weights::Quintic),
            (32, 1, 3, true, Weights::Quintic),
        ] {
            let bake = Bake { weights, size, cells, octaves, absolute };
            let (block, values) = (bake.values_and_gradients(&|_| ()), bake.values(&|_| ()).values);
            assert_eq!(block.values, values);
            let lattice = Lattice { weights };
            let (mut off, mut slope_off) = (0.0f64, 0.0f64);
            for (index, value) in block.values.iter().enumerate() {
                let side = size as usize;
                let at = [index % side, index / side % side, index / side / side];
                let p = at.map(|i| (i as f64 + 0.5) / f64::from(size) * f64::from(cells));
                let (gradient, truth) = if absolute {
                    lattice.turbulence(p, Period::growing(cells), octaves)
                } else {
                    lattice.sample(p, cells)
                };
                off = off.max((f64::from(*value) - truth).abs());
                for (slopes, slope) in block.gradient.iter().zip(gradient) {
                    slope_off = slope_off.max((f64::from(slopes[index]) - slope).abs());
                }
            }
            println!("{bake:?}: {off:.1e}, gradient {slope_off:.1e}");
            assert!(off <= 1e-6 && slope_off <= 5e-6, "{bake:?}: {off:e}, gradient {slope_off:e}");
        }
    }

    #[test]
    fn octaves_that_a_block_cannot_hold_are_left_out() {
        assert_eq!(Bake::held(16, 2, 8), 3);
        assert_eq!(Bake::held(32, 2, 8), 4);
        assert_eq!(Bake::held(16, 2, 2), 2);
    }
}
