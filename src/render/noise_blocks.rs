//! Blocks of noise and turbulence, and the tables of noise: the images of a scene that depend on no object.
//!
//! Invariant: a block is made of its [`Recipe`] alone, so that the same one is not made again in the next run.

use super::inputs::{Content, Encoded};
use crate::field::Progress;
use crate::gpu::{Dimension, Format};
use crate::kept::{self, Kind};
use crate::noise::{Bake, Noise, Weights, random_block};
use crate::scene::{BlockFormat, Scene};
use crate::texture::{self, Depth};

/// Seed of Perlin's tables and of random texels: changing it changes every picture that is made of them.
const SEED: u64 = 1989;
/// Raise it when a recipe gives other bytes.
const VERSION: u32 = 1;
/// Blocks of fewer texels along a side are made faster than they are read.
const KEPT_FROM: u32 = 64;
/// Less: two blocks of 256^3 texels push each other out. More: a person finds a full disk.
const KIND: Kind = Kind { end: "block", limit: 1 << 30 };

/// What a block holds. Equal recipes make equal bytes.
#[derive(Clone, Copy, Debug)]
enum Recipe {
    Values(Bake),
    Gradients(Bake),
    /// Four octaves of noise, from this one on.
    Channels(Bake),
    /// Random texels, their seed, side and blur.
    Random(u64, u32, f32),
}

impl Recipe {
    fn channels(&self) -> u32 {
        if matches!(self, Recipe::Values(_)) { 1 } else { 4 }
    }

    fn make(&self, depth: Depth, progress: Progress<'_>) -> Vec<u8> {
        match self {
            Recipe::Values(bake) => texture::block_values(&bake.values(progress), bake.absolute, depth),
            Recipe::Gradients(bake) => {
                texture::block_gradients(&bake.values_and_gradients(progress), bake.absolute, depth)
            }
            Recipe::Channels(bake) => {
                let octave = |index: u8| {
                    let part = |done| progress((f32::from(index) + done) / 4.0);
                    Bake { cells: bake.cells << index, ..*bake }.values(&part)
                };
                texture::block_channels(&[0, 1, 2, 3].map(octave), depth)
            }
            Recipe::Random(seed, size, blur) => texture::texels_of(&random_block(*seed, *size, *blur), depth),
        }
    }

    /// The bytes, made or read.
    fn bytes(&self, size: u32, depth: Depth, progress: Progress<'_>) -> Vec<u8> {
        if size < KEPT_FROM {
            return self.make(depth, progress);
        }
        let key = blake3::hash(format!("{VERSION} {self:?} {depth:?}").as_bytes());
        kept::load(KIND, key).unwrap_or_else(|| {
            let bytes = self.make(depth, progress);
            kept::save(KIND, key, &bytes);
            bytes
        })
    }
}

/// The block or table of a name in `interface.glsl`; `None` for names of other images. `progress` is called with the part
/// of a block that is done, from any thread.
pub(super) fn block(scene: &Scene, name: &str, progress: Progress<'_>) -> Option<Encoded> {
    let size = scene.quality.block_size;
    let weights = if scene.effect.weights == "cubic" { Weights::Cubic } else { Weights::Quintic };
    let [noise_cells, turbulence_cells, channel_cells] = scene.block_cells();
    let [held, low] = scene.block_octaves();
    let noise = Bake { weights, size, cells: noise_cells, octaves: 1, absolute: false };
    let turbulence = |octaves| Bake { weights, size, cells: turbulence_cells, octaves, absolute: true };
    let row = |name, index: usize| {
        let texels = texture::table_rows(&Noise::new(SEED, weights))[index].clone();
        let (dimension, format) = (Dimension::Line(256), Format::Rgba32Float);
        Encoded { name, dimension, format, content: Content::Floats(texels) }
    };
    let (name, recipe) = match name {
        "noise_image" => ("noise block", Recipe::Gradients(noise)),
        "noise_value_image" => ("noise values", Recipe::Values(noise)),
        "turbulence_image" => ("turbulence block", Recipe::Gradients(turbulence(held))),
        "turbulence_value_image" => ("turbulence values", Recipe::Values(turbulence(held))),
        "low_octaves_image" => ("low octaves", Recipe::Values(turbulence(low))),
        "channel_image" => ("four octaves", Recipe::Channels(Bake { cells: channel_cells, ..noise })),
        "random_image" => ("random texels", Recipe::Random(SEED, size, scene.quality.block_blur)),
        "permutation_image" => return Some(row("permutation", 0)),
        "gradient_image" => return Some(row("table of gradients", 1)),
        _ => return None,
    };
    let channels = recipe.channels();
    let depth = match (scene.quality.block_format, channels) {
        (BlockFormat::Unorm8, _) => Depth::Eight,
        (BlockFormat::Unorm16, _) | (BlockFormat::Auto, 4) => Depth::Sixteen,
        (BlockFormat::Float32 | BlockFormat::Auto, _) => Depth::Float,
    };
    let format = match (channels, depth) {
        (1, Depth::Eight) => Format::R8Unorm,
        (1, Depth::Sixteen) => Format::R16Unorm,
        (1, Depth::Float) => Format::R32Float,
        (_, Depth::Eight) => Format::Rgba8Unorm,
        (_, Depth::Sixteen) => Format::Rgba16Unorm,
        (_, Depth::Float) => Format::Rgba32Float,
    };
    let content = Content::Bytes(recipe.bytes(size, depth, progress));
    Some(Encoded { name, dimension: Dimension::Volume(size, size, size), format, content })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn every_block_is_its_recipe_and_tells_how_far_it_is() {
        let mut scene = Scene::default();
        for size in [16, 64] {
            scene.quality.block_size = size;
            for name in ["noise_image", "turbulence_value_image", "channel_image", "random_image"] {
                let told = Mutex::new(vec![]);
                let [first, second] = [0, 1].map(|_| {
                    let block = block(&scene, name, &|done| told.lock().unwrap().push(done)).unwrap();
                    assert_eq!(block.dimension, Dimension::Volume(size, size, size));
                    block.bytes().to_vec()
                });
                assert_eq!(first, second, "{name}: made, and made again or read");
                let told = told.into_inner().unwrap();
                assert!(told.iter().all(|done| (0.0..=1.0).contains(done)), "{name}: {told:?}");
                if size < KEPT_FROM && name != "random_image" {
                    assert_eq!(told.iter().copied().fold(0.0, f32::max), 1.0, "{name}");
                }
            }
        }
        assert!(block(&scene, "transfer_image", &|_| ()).is_none());
    }
}
