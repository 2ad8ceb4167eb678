//! Texels of noise blocks and noise tables.

use crate::noise::{Block, NOISE_GRADIENT_BOUND, Noise, TURBULENCE_BOUND, TURBULENCE_GRADIENT_BOUND};
use rayon::prelude::*;

/// Bits of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// Codes of 8 bits.
    Eight,
    /// Codes of 16 bits.
    Sixteen,
    /// 32-bit floats.
    Float,
}

/// One channel of a block: the value v is stored as `offset + scale * v`, in [0, 1].
#[derive(Clone, Copy)]
struct Channel<'a> {
    values: &'a [f32],
    scale: f32,
    offset: f32,
}

impl<'a> Channel<'a> {
    fn value(block: &'a Block, absolute: bool) -> Channel<'a> {
        let [scale, offset, _] = block_scales(absolute);
        Channel { values: &block.values, scale, offset }
    }
}

/// Scale and offset of a stored value, and scale of a stored slope, whose offset is 1/2.
pub(crate) fn block_scales(absolute: bool) -> [f32; 3] {
    if absolute {
        [(1.0 / TURBULENCE_BOUND) as f32, 0.0, (0.5 / TURBULENCE_GRADIENT_BOUND) as f32]
    } else {
        [0.5, 0.5, (0.5 / NOISE_GRADIENT_BOUND) as f32]
    }
}

/// Single-channel values of a block: noise as `0.5 + 0.5 value`, a sum of absolute values over [`TURBULENCE_BOUND`].
pub fn block_values(block: &Block, absolute: bool, depth: Depth) -> Vec<u8> {
    interleave([Channel::value(block, absolute)], depth)
}

/// Gradients in RGB, as `0.5 + 0.5 gradient / bound`, and values in A (MJ 4.1).
pub fn block_gradients(block: &Block, absolute: bool, depth: Depth) -> Vec<u8> {
    let ([x, y, z], [_, _, scale]) = (&block.gradient, block_scales(absolute));
    let slope = |values| Channel { values, scale, offset: 0.5 };
    interleave([slope(x), slope(y), slope(z), Channel::value(block, absolute)], depth)
}

/// Four noise blocks in the channels of one.
pub fn block_channels(blocks: &[Block; 4], depth: Depth) -> Vec<u8> {
    interleave([0, 1, 2, 3].map(|c| Channel::value(&blocks[c], false)), depth)
}

/// Texels of four numbers in [0, 1].
pub(crate) fn texels_of(numbers: &[[f32; 4]], depth: Depth) -> Vec<u8> {
    let channels: [Vec<f32>; 4] = std::array::from_fn(|c| numbers.iter().map(|texel| texel[c]).collect());
    interleave([0, 1, 2, 3].map(|c| Channel { values: &channels[c], scale: 1.0, offset: 0.0 }), depth)
}

/// Tables of Perlin's noise as rows of 256 RGBA floats: an entry of the permutation with the next one in R and G; and
/// the gradients in the order of the permutation.
pub fn table_rows(noise: &Noise) -> [Vec<f32>; 2] {
    let (permutation, gradients) = noise.tables();
    let entry = |index: usize| f32::from(permutation[index % 256]);
    let pairs = (0..256).flat_map(|index| [entry(index), entry(index + 1), 0.0, 0.0]).collect();
    let pointed = (0..256).flat_map(|index| {
        let [x, y, z] = gradients[usize::from(permutation[index])].map(|c| c as f32);
        [x, y, z, 0.0]
    });
    [pairs, pointed.collect()]
}

fn interleave<const CHANNELS: usize>(channels: [Channel<'_>; CHANNELS], depth: Depth) -> Vec<u8> {
    match depth {
        Depth::Eight => pack(channels, |value| [(value * 255.0).round() as u8]),
        Depth::Sixteen => pack(channels, |value| ((value * 65535.0).round() as u16).to_ne_bytes()),
        Depth::Float => pack(channels, f32::to_ne_bytes),
    }
}

fn pack<const CHANNELS: usize, const BYTES: usize>(
    channels: [Channel<'_>; CHANNELS],
    code: impl Fn(f32) -> [u8; BYTES] + Sync,
) -> Vec<u8> {
    const TEXELS: usize = 1 << 14;
    let mut bytes = vec![0; channels[0].values.len() * CHANNELS * BYTES];
    bytes.par_chunks_mut(TEXELS * CHANNELS * BYTES).enumerate().for_each(|(chunk, out)| {
        let texels = out.as_chunks_mut::<BYTES>().0;
        let first = chunk * TEXELS;
        for (c, channel) in channels.iter().enumerate() {
            let values = &channel.values[first..first + texels.len() / CHANNELS];
            for (value, out) in values.iter().zip(texels[c..].iter_mut().step_by(CHANNELS)) {
                *out = code(channel.offset + channel.scale * value);
            }
        }
    });
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{Bake, Lattice, Period, SEED, Weights};

    #[test]
    fn m34_a_block_is_stored_to_half_a_code() {
        let bake = Bake { weights: Weights::Quintic, size: 16, cells: 4, octaves: 2, absolute: true };
        let block = bake.values_and_gradients(&|_| ());
        for (depth, codes) in [(Depth::Eight, 255.0), (Depth::Sixteen, 65535.0)] {
            let texels = block_gradients(&block, true, depth);
            for index in [0, 77, 4095] {
                let at = [index % 16, index / 16 % 16, index / 256].map(|i| (f64::from(i) + 0.5) / 16.0 * 4.0);
                let (gradient, value) = Lattice::default().turbulence(at, Period::growing(4), 2);
                let stored = |channel: usize| {
                    let texel = 4 * index as usize + channel;
                    match depth {
                        Depth::Eight => f64::from(texels[texel]) / codes,
                        _ => f64::from(u16::from_ne_bytes([texels[2 * texel], texels[2 * texel + 1]])) / codes,
                    }
                };
                assert!((TURBULENCE_BOUND * stored(3) - value).abs() <= 1.01 / codes);
                let slope = (2.0 * stored(1) - 1.0) * TURBULENCE_GRADIENT_BOUND;
                assert!((slope - gradient[1]).abs() <= 1.01 * TURBULENCE_GRADIENT_BOUND / codes);
            }
        }
    }

    #[test]
    fn m44_the_arrays_of_the_shader_are_the_tables_of_this_noise() {
        let (noise, path) = (Noise::new(SEED, Weights::Quintic), "glsl/noise_tables.glsl");
        let (permutation, gradients) = noise.tables();
        let rows = |entries: Vec<String>, each: usize| {
            entries.chunks(each).map(|row| format!("    {}", row.join(", "))).collect::<Vec<_>>().join(",\n")
        };
        let permutation = rows(permutation.iter().map(u8::to_string).collect(), 20);
        let gradient = |g: &[f64; 3]| format!("vec3({:.8}, {:.8}, {:.8})", g[0], g[1], g[2]);
        let gradients = rows(gradients.iter().map(gradient).collect(), 3);
        let text = format!(
            "// The tables of Perlin's noise of 1989: a permutation, and gradients uniform on the sphere.\n\
             // Source: PH 2.3; written by a test of src/render/texture/blocks.rs from the noise of seed 1989.\n\
             // No constants: of a constant that is indexed by a variable, glslang copies the whole for every access.\n\
             // Result: entries by index, 0 to 255.\n\
             int PERMUTATION[256] = int[256](\n{permutation});\n\
             vec3 GRADIENTS[256] = vec3[256](\n{gradients});\n"
        );
        if std::env::var("BLESS").is_ok_and(|what| what == "tables") {
            std::fs::write(path, &text).unwrap();
        }
        assert!(
            std::fs::read_to_string(path).unwrap() == text,
            "BLESS=tables cargo test --release --lib m44 writes {path}"
        );
    }
}
