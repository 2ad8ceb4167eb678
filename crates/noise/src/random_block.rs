//! Blocks of filtered white noise.

use hypertexture_support::random::SplitMix;
use rayon::prelude::*;

/// White noise in four channels of `size`^3 texels, x fastest, blurred by a Gaussian of `blur` texels (GG 39.5) and scaled to
/// [0, 1] with the mean 0.5.
pub fn random_block(seed: u64, size: u32, blur: f32) -> Vec<[f32; 4]> {
    let side = size as usize;
    let mut random = SplitMix(seed);
    let mut block: Vec<[f32; 4]> =
        (0..side.pow(3)).map(|_| std::array::from_fn(|_| random.unit() as f32 - 0.5)).collect();
    let reach = (3.0 * blur).ceil() as usize;
    let weights: Vec<f32> =
        (0..=2 * reach).map(|i| (-0.5 * ((i as f32 - reach as f32) / blur.max(1e-6)).powi(2)).exp()).collect();
    let total: f32 = weights.iter().sum();
    for stride in [1, side, side * side] {
        let before = block.clone();
        block.par_iter_mut().enumerate().for_each(|(index, out)| {
            let along = index / stride % side;
            let start = index - along * stride;
            *out = [0.0; 4];
            for (i, weight) in weights.iter().enumerate() {
                let from = before[start + (along + side * reach + i - reach) % side * stride];
                (0..4).for_each(|c| out[c] += weight / total * from[c]);
            }
        });
    }
    let largest = block.iter().flatten().fold(0.0f32, |largest, value| largest.max(value.abs()));
    block.iter().map(|texel| texel.map(|value| 0.5 + 0.5 * value / largest)).collect()
}

/// Mean of |noise| of the last channel of a random block, which stores 0.5 + 0.5 noise, read through a linear filter. Sampled
/// to about half a percent.
pub fn random_mean(block: &[[f32; 4]], size: u32) -> f32 {
    const PLACES: usize = 1 << 16;
    let side = size as usize;
    let mut random = SplitMix(1);
    let (places, stride) = (PLACES.min(block.len()), (block.len() / PLACES).max(1));
    let at = |random: &mut SplitMix, index: usize| {
        let near = [index % side, index / side % side, index / side / side];
        let part: [f32; 3] = std::array::from_fn(|_| random.unit() as f32);
        let corner = |corner: usize| {
            let far = [corner & 1, corner >> 1 & 1, corner >> 2];
            let weight: f32 = (0..3).map(|a| if far[a] == 1 { part[a] } else { 1.0 - part[a] }).product();
            let [x, y, z] = [0, 1, 2].map(|a| (near[a] + far[a]) % side);
            weight * (2.0 * block[(z * side + y) * side + x][3] - 1.0)
        };
        f64::from((0..8).map(corner).sum::<f32>().abs())
    };
    ((0..places).map(|index| at(&mut random, index * stride)).sum::<f64>() / places as f64) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_random_texels_is_that_of_filtered_reads() {
        let block =
            |of: &dyn Fn(usize) -> f32| (0..16usize.pow(3)).map(|at| [0.0, 0.0, 0.0, of(at)]).collect::<Vec<_>>();
        // Noise of -0.6 everywhere; and of 1 and -1 by turns along x: |1 - 2 t| between two texels.
        for (mean, block) in [(0.6, block(&|_| 0.2)), (0.5, block(&|at| (at % 2) as f32))] {
            let found = random_mean(&block, 16);
            assert!((found / mean - 1.0).abs() < 0.02, "{found} for {mean}");
        }
    }
}
