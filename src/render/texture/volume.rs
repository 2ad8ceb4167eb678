//! Volume texels of a distance field.
//!
//! Invariant: `distance` is positive outside everywhere in the crate, and only the *stored* texel grows inward, in [0,
//! 1]. [`encode`] is the only encoder, and [`Texels::decode`] parameterizes the only decoder in GLSL. Source: MJ 3.1
//! (gradient normal in RGB, density in A, at most 16 bits).

use super::codes::{code8, code16};
use crate::field::{ClosestPoints, DistanceField};
use glam::Vec3;
use rayon::prelude::*;

/// Texel format of a distance field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Normal and distance, 4 x 16 bits.
    Normals16,
    /// Normal and distance, 4 x 8 bits.
    Normals8,
    /// Distance alone, 16 bits.
    Distance16,
    /// Distance alone, 32-bit float.
    Distance32,
}

/// An encoded distance field.
#[derive(Clone, Debug, PartialEq)]
pub struct Texels {
    /// Texels per axis.
    pub size: [u32; 3],
    /// Texel format.
    pub encoding: Encoding,
    /// Texels, x fastest, then y, then z.
    pub bytes: Vec<u8>,
    /// The signed distance of a stored value s is `decode[0] + decode[1] * s`, in units of the field.
    pub decode: [f32; 2],
    /// Largest error of a stored distance within the stored range, in units of the field.
    pub quantization: f32,
}

impl Texels {
    /// Channels of a texel as a program reads them; missing channels are 0.
    pub fn channels(&self, number: usize) -> [f32; 4] {
        let texels: usize = self.size.iter().map(|side| *side as usize).product();
        let bytes = self.bytes.len() / texels;
        let texel = &self.bytes[number * bytes..][..bytes];
        let code16 =
            |channel: usize| f32::from(u16::from_ne_bytes([texel[2 * channel], texel[2 * channel + 1]])) / 65535.0;
        match self.encoding {
            Encoding::Normals16 => [0, 1, 2, 3].map(code16),
            Encoding::Normals8 => [0, 1, 2, 3].map(|channel| f32::from(texel[channel]) / 255.0),
            Encoding::Distance16 => [code16(0), 0.0, 0.0, 0.0],
            Encoding::Distance32 => [f32::from_ne_bytes([texel[0], texel[1], texel[2], texel[3]]), 0.0, 0.0, 0.0],
        }
    }
}

/// Encodes a field. Clamps distances to `range` (lowest, highest; units of the field).
///
/// The normal is the normalized gradient by central differences, each component c stored as `0.5 + 0.5 c`; 0 where the
/// gradient is 0.
pub fn encode(field: &DistanceField, encoding: Encoding, range: [f32; 2]) -> Texels {
    let (lowest, highest) = field.range();
    let low = range[0].max(lowest);
    let high = range[1].min(highest).max(low + (f32::EPSILON * low.abs()).max(f32::MIN_POSITIVE));
    let stored = |distance: f32| ((high - distance) / (high - low)).clamp(0.0, 1.0);
    let (bytes_per_texel, codes) = match encoding {
        Encoding::Normals16 => (8, 65535.0),
        Encoding::Normals8 => (4, 255.0),
        Encoding::Distance16 => (2, 65535.0),
        Encoding::Distance32 => (4, f32::INFINITY),
    };
    let [nx, ny, _] = field.grid.size.map(|side| side as usize);
    let mut bytes = vec![0; field.values.len() * bytes_per_texel];
    let arch = pulp::Arch::new();
    bytes.par_chunks_mut(nx * bytes_per_texel).enumerate().for_each(|(row, out)| {
        let values = &field.values[row * nx..][..nx];
        let gradients = || field.gradients((row % ny) as u32, (row / ny) as u32);
        arch.dispatch(
            #[inline(always)] // inlined into code for the vector units of this processor
            || match encoding {
                Encoding::Distance32 => fill(out, values.iter().map(|value| stored(*value).to_ne_bytes())),
                Encoding::Distance16 => fill(out, values.iter().map(|value| code16(stored(*value)).to_ne_bytes())),
                Encoding::Normals16 => {
                    let parts = normal_parts(gradients());
                    let codes = (0..nx).map(|i| [parts[0][i], parts[1][i], parts[2][i], stored(values[i])].map(code16));
                    fill::<8>(out, codes.map(bytemuck::cast));
                }
                Encoding::Normals8 => {
                    let parts = normal_parts(gradients());
                    fill(out, (0..nx).map(|i| [parts[0][i], parts[1][i], parts[2][i], stored(values[i])].map(code8)));
                }
            },
        );
    });
    let rounding = f32::EPSILON * low.abs().max(high.abs());
    let quantization = (high - low) * 0.5 / codes + rounding;
    Texels { size: field.grid.size, encoding, bytes, decode: [high, low - high], quantization }
}

/// Offset from every sample of a field to the closest point of its level `iso`, as RGBA, 16 bits each, A unused: a
/// component c, in units of the field, is stored as `0.5 + 0.5 c / range`. Returns the bytes and the range.
///
/// Moves the closest point of the surface along the normal, which is exact on the level's side of the surface up to the
/// medial axis. Quantization: `range / 65535` for each component.
pub(crate) fn encode_closest(closest: &ClosestPoints, field: &DistanceField, iso: f32) -> (Vec<u8>, f32) {
    let [nx, ny, _] = closest.grid.size;
    // Squares of tiny lengths underflow f32; scaling by a power of two is exact.
    let handy = (-closest.grid.spacing.max_element().log2().floor()).exp2();
    let way = |index: usize| {
        let at = [index as u32 % nx, index as u32 / nx % ny, index as u32 / (nx * ny)];
        let to_surface = closest.points[index] - closest.grid.position(at[0], at[1], at[2]);
        if iso == 0.0 {
            return to_surface;
        }
        let along = (handy * to_surface).normalize_or_zero();
        let outward = if field.values[index] < 0.0 { along } else { -along };
        let gradient = || field.gradient(at[0], at[1], at[2]).normalize_or_zero();
        to_surface + iso * if outward == Vec3::ZERO { gradient() } else { outward }
    };
    let samples = 0..closest.points.len();
    let range =
        samples.into_par_iter().map(|index| way(index).abs().max_element()).reduce(|| f32::MIN_POSITIVE, f32::max);
    let mut bytes = vec![0; closest.points.len() * 8];
    bytes.par_chunks_mut(8 * nx as usize).enumerate().for_each(|(row, out)| {
        let ways = (0..nx as usize).map(|i| way(row * nx as usize + i));
        let codes = ways.map(|way| (0.5 + 0.5 * way / range).extend(0.0).to_array().map(code16));
        fill::<8>(out, codes.map(bytemuck::cast));
    });
    (bytes, range)
}

/// Encoded normals of a row of gradients, component by component: `0.5 + 0.5 c`, and 0.5 for a gradient of 0.
#[inline(always)]
fn normal_parts([mut x, mut y, mut z]: [Vec<f32>; 3]) -> [Vec<f32>; 3] {
    for ((x, y), z) in x.iter_mut().zip(&mut y).zip(&mut z) {
        [*x, *y, *z] = (0.5 + 0.5 * Vec3::new(*x, *y, *z).normalize_or_zero()).to_array();
    }
    [x, y, z]
}

/// Writes consecutive texels.
#[inline(always)]
fn fill<const BYTES: usize>(out: &mut [u8], texels: impl Iterator<Item = [u8; BYTES]>) {
    for (out, texel) in out.as_chunks_mut::<BYTES>().0.iter_mut().zip(texels) {
        *out = texel;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Grid, Request, transform_with_closest};

    fn sphere(side: u32) -> DistanceField {
        let spacing = 3.0 / (side - 1) as f32;
        let grid = Grid { size: [side; 3], origin: Vec3::splat(-1.5), spacing: Vec3::splat(spacing) };
        let at = |i: u32| -1.5 + spacing * i as f32;
        let points = (0..side.pow(3)).map(|i| Vec3::new(at(i % side), at(i / side % side), at(i / side / side)));
        DistanceField { grid, values: points.map(|p| p.length() - 1.0).collect() }
    }

    fn decode(texels: &Texels, stored: f32) -> f32 {
        texels.decode[0] + texels.decode[1] * stored
    }

    #[test]
    fn m21_a_stored_distance_is_right_to_the_quantization_stated() {
        let field = sphere(17);
        for (encoding, expected) in [(Encoding::Distance16, 5e-5), (Encoding::Normals8, 1e-2)] {
            let texels = encode(&field, encoding, [-10.0, 10.0]);
            assert!(texels.quantization < expected);
            for (index, &distance) in field.values.iter().enumerate() {
                let stored = match encoding {
                    Encoding::Distance16 => {
                        f32::from(u16::from_ne_bytes([texels.bytes[2 * index], texels.bytes[2 * index + 1]])) / 65535.0
                    }
                    _ => f32::from(texels.bytes[4 * index + 3]) / 255.0,
                };
                assert!((decode(&texels, stored) - distance).abs() <= texels.quantization * 1.001);
            }
        }
    }

    #[test]
    fn the_texels_of_an_object_do_not_depend_on_its_scale() {
        let of = |scale: f32| {
            let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32);
            let vertex = |[x, y, z]: [f32; 3]| format!("v {} {} {}\n", 2.0 * scale * x, scale * y, 0.5 * scale * z);
            let vertices: String = (0..8).map(corner).map(vertex).collect();
            let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
            let shape = crate::shape::read("box.obj", (vertices + faces).as_bytes()).unwrap();
            let lengths = Request { resolution: 24, margin: 0.25 * scale, band: 0.25 * scale, iso: 0.0, shell: 0.0 };
            transform_with_closest(&shape, &lengths, &|_| ()).unwrap()
        };
        let (field, points, _) = of(1.0);
        let expected = encode(&field, Encoding::Normals16, [-0.5, 0.125]);
        let (ways, range) = encode_closest(&points, &field, 0.125);
        // Powers of two are exact: 8.9e-16 to 1.1e15.
        for scale in [-50, -20, 20, 50].map(|power: i16| f32::from(power).exp2()) {
            let (field, points, _) = of(scale);
            let texels = encode(&field, Encoding::Normals16, [-0.5 * scale, 0.125 * scale]);
            assert!(texels.bytes == expected.bytes, "{scale}");
            assert_eq!(texels.decode, expected.decode.map(|value| value * scale));
            assert_eq!(texels.quantization, expected.quantization * scale);
            let (found, found_range) = encode_closest(&points, &field, 0.125 * scale);
            assert!(found == ways && found_range == range * scale, "{scale}");
        }
    }

    #[test]
    fn g14_eight_bits_keep_what_blocks_of_bc4_lose() {
        // A block of BC4: 4 x 4 texels, each one of eight levels between two ends.
        let field = sphere(65);
        let side = field.grid.size[0] as usize;
        let mut worst = 0.0f32;
        for corner in (0..side * side * side).filter(|at| at.is_multiple_of(4) && (at / side).is_multiple_of(4)) {
            let [x, y] = [corner % side, corner / side % side];
            if x + 4 > side || y + 4 > side {
                continue;
            }
            let block: Vec<f32> = (0..16).map(|at| field.values[corner + at % 4 + at / 4 * side]).collect();
            let low = block.iter().copied().fold(f32::INFINITY, f32::min);
            let level = (block.iter().copied().fold(f32::NEG_INFINITY, f32::max) - low) / 7.0;
            let off = |value: f32| (value - low - level * ((value - low) / level).round()).abs();
            worst = block.into_iter().filter(|value| value.abs() < field.grid.spacing.x).map(off).fold(worst, f32::max);
        }
        // The soft region of the presets is 0.15 wide.
        let eight = encode(&field, Encoding::Normals8, [-0.1, 0.25]).quantization;
        let [bc4, eight] = [worst, eight].map(|off| off / field.grid.spacing.x);
        println!("beside the surface BC4 is off by {bc4:.3} voxels, 8 bits by {eight:.3}");
        assert!(bc4 > 0.2 && eight < 0.02, "{bc4}, {eight}");
    }

    #[test]
    fn the_stored_value_grows_inward_from_0_to_1() {
        let field = sphere(17);
        let texels = encode(&field, Encoding::Distance32, [-0.5, 0.5]);
        let stored = |index: usize| f32::from_ne_bytes(texels.bytes[4 * index..][..4].try_into().unwrap());
        assert_eq!(stored(0), 0.0);
        assert_eq!(stored(8 + 17 * (8 + 17 * 8)), 1.0);
    }

    #[test]
    fn m22_normals_point_outward_to_half_a_code() {
        let field = sphere(33);
        let texels = encode(&field, Encoding::Normals16, [-10.0, 10.0]);
        let index = 30 + 33 * (16 + 33 * 16);
        let channel = |c: usize| {
            f32::from(u16::from_ne_bytes([texels.bytes[8 * index + 2 * c], texels.bytes[8 * index + 2 * c + 1]]))
                / 65535.0
                * 2.0
                - 1.0
        };
        assert!((channel(0) - 1.0).abs() < 1e-3 && channel(1).abs() < 1e-3 && channel(2).abs() < 1e-3);
    }

    #[test]
    fn p55_stored_ways_lead_to_the_level() {
        let grid = Grid { size: [21; 3], origin: Vec3::splat(-1.0), spacing: Vec3::splat(0.1) };
        let place = |i: usize| grid.position(i as u32 % 21, i as u32 / 21 % 21, i as u32 / 441);
        // Two parallel planes, at y = -0.53 and y = 0.53; the middle between them is their medial axis.
        let values = (0..9261).map(|i| 0.53 - place(i).y.abs()).collect();
        let side = |p: Vec3| if p.y > -0.05 { 1.0 } else { -1.0 };
        let foot = |p: Vec3| Vec3::new(p.x, 0.53 * side(p), p.z);
        let field = DistanceField { grid, values };
        let closest = ClosestPoints { grid, points: (0..9261).map(|i| foot(place(i))).collect() };
        for iso in [0.07, 0.0] {
            let (bytes, range) = encode_closest(&closest, &field, iso);
            for (index, texel) in bytes.as_chunks::<8>().0.iter().enumerate() {
                let p = place(index);
                let way = |c: usize| {
                    (f32::from(u16::from_ne_bytes([texel[2 * c], texel[2 * c + 1]])) / 65535.0 * 2.0 - 1.0) * range
                };
                let level = p + Vec3::new(way(0), way(1), way(2));
                let expected = Vec3::new(p.x, (0.53 - iso) * side(p), p.z);
                assert!(level.distance(expected) < 1e-4, "{p} leads to {level}, iso {iso}");
            }
        }
    }
}
