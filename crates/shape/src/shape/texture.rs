//! Textures: texels in linear light.

use super::looks::linear;
use half::f16;

/// Most texels along a side; a voxel of a groom is larger than a texel still. Pixels of larger pictures are averaged.
const MAX_TEXELS: usize = 1024;

/// Texels beyond the edges of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Wrap {
    #[default]
    Repeat,
    Mirror,
    Clamp,
}

impl Wrap {
    /// The texel for a coordinate, which is below `count`.
    fn texel(self, at: i64, count: usize) -> usize {
        let count = count as i64;
        (match self {
            Wrap::Repeat => at.rem_euclid(count),
            Wrap::Mirror => {
                let both = at.rem_euclid(2 * count);
                both.min(2 * count - 1 - both)
            }
            Wrap::Clamp => at.clamp(0, count - 1),
        }) as usize
    }
}

/// A picture over texture coordinates of 0 to 1, its first row at v = 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Texture {
    size: [usize; 2],
    texels: Vec<[f16; 3]>,
}

impl Texture {
    /// Pixels of one byte in each of their samples, averaged to at most [`MAX_TEXELS`] a side.
    pub fn reduced([width, height]: [usize; 2], pixels: &[u8], samples: usize, is_gray: bool) -> Texture {
        let light: [f32; 256] = std::array::from_fn(|code| linear(code as f64 / 255.0));
        let size = [width, height].map(|side| side.min(MAX_TEXELS));
        let mut sums = vec![[0.0_f32; 4]; size[0] * size[1]];
        for (y, row) in pixels.chunks_exact(width * samples).take(height).enumerate() {
            let first = y * size[1] / height * size[0];
            for (x, pixel) in row.chunks_exact(samples).enumerate() {
                let rgb = if is_gray { [pixel[0]; 3] } else { [pixel[0], pixel[1], pixel[2]] };
                let [r, g, b] = rgb.map(|code| light[usize::from(code)]);
                sums[first + x * size[0] / width].iter_mut().zip([r, g, b, 1.0]).for_each(|(sum, part)| *sum += part);
            }
        }
        let texels = sums.into_iter().map(|[r, g, b, count]| [r, g, b].map(|sum| f16::from_f32(sum / count)));
        Texture { size, texels: texels.collect() }
    }

    /// Linear RGB at texture coordinates, interpolated between four texels.
    pub fn sample(&self, uv: [f32; 2], wraps: [Wrap; 2]) -> [f32; 3] {
        let axes: [_; 2] = std::array::from_fn(|axis| {
            let at = f64::from(uv[axis]) * self.size[axis] as f64 - 0.5;
            let below = at.floor();
            let texel = |at: i64| wraps[axis].texel(at, self.size[axis]);
            [(texel(below as i64), 1.0 - (at - below)), (texel((below as i64).saturating_add(1)), at - below)]
        });
        let mut rgb = [0.0; 3];
        for (y, own) in axes[1] {
            for (x, part) in axes[0] {
                let texel = self.texels[y * self.size[0] + x].map(f16::to_f32);
                rgb.iter_mut().zip(texel).for_each(|(sum, value)| *sum += (own * part) as f32 * value);
            }
        }
        rgb
    }
}
