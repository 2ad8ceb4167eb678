//! Noise and turbulence blocks, and noise tables: images that depend on no object.
//!
//! Invariant: an image depends on its [`Recipe`] and bit depth alone, under which the disk cache keeps a block.

use super::encoded::Encoded;
use crate::field::Progress;
use crate::gpu::{Dimension, Format};
use crate::noise::{Bake, Block, Noise, SEED, Weights, blue_noise, random_block, random_mean as mean_of_random};
use crate::render::texture::{self, Depth};
use crate::render::variant::NoiseImage;
use crate::scene::{BlockFormat, Scene};
use hypertexture_support::disk_cache::{self, CacheKind};
use std::iter;
use std::sync::{Mutex, OnceLock, PoisonError};

/// Side of the tile of jitter phases, a power of two. Higher: slower to compute. Lower: visibly periodic.
const PHASES: usize = 64;
/// Increment when a recipe gives other bytes.
const VERSION: u32 = 1;
/// Lowest side of blocks in the disk cache; smaller ones are computed faster than read.
const KEPT_FROM: u32 = 64;
/// Lower: two blocks of 256^3 texels evict each other. Higher: the cache fills the disk.
const KIND: CacheKind = CacheKind { ends: &["block"], limit: 1 << 30 };

/// Content of a block. Equal recipes give equal bytes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Recipe {
    Values(Bake),
    Gradients(Bake),
    /// Four octaves of noise, starting at this one.
    Channels(Bake),
    /// Random texels: seed, side and blur.
    Random(u64, u32, f32),
    /// Row of the tables of noise.
    Row(usize, Weights),
    /// Jitter phases of a tile of pixels.
    Phases,
}

impl Recipe {
    pub(super) fn channels(&self) -> u32 {
        if matches!(self, Recipe::Values(_) | Recipe::Phases) { 1 } else { 4 }
    }

    /// Lattice noise of a block; `None` for random texels and tables.
    pub(super) fn bake(&self) -> Option<&Bake> {
        match self {
            Recipe::Values(bake) | Recipe::Gradients(bake) | Recipe::Channels(bake) => Some(bake),
            _ => None,
        }
    }

    /// Mip level without the `faded` last octaves, at half the resolution for each; and the difference of its mean from
    /// the block's: that of the faded octaves and of the stronger blur of the others.
    pub(super) fn level(&self, faded: u32) -> (Recipe, f32) {
        let mean = |bake: &Bake| -> f32 {
            let octave =
                |octave| bake.weights.mean_of_block(bake.size / (bake.cells << octave)) / (1u32 << octave) as f32;
            (0..bake.octaves).map(octave).sum()
        };
        let coarser = |bake: &Bake| {
            let level = Bake { size: (bake.size >> faded).max(1), octaves: bake.octaves - faded, ..*bake };
            (level, mean(bake) - mean(&level))
        };
        match self {
            Recipe::Values(bake) => (Recipe::Values(coarser(bake).0), coarser(bake).1),
            Recipe::Gradients(bake) => (Recipe::Gradients(coarser(bake).0), coarser(bake).1),
            other => (*other, 0.0),
        }
    }

    fn make(&self, mean: f32, depth: Depth, progress: Progress<'_>) -> Vec<u8> {
        let lifted = |mut block: Block| {
            block.values.iter_mut().for_each(|value| *value += mean);
            block
        };
        match self {
            Recipe::Values(bake) => texture::block_values(&lifted(bake.values(progress)), bake.absolute, depth),
            Recipe::Gradients(bake) => {
                texture::block_gradients(&lifted(bake.values_and_gradients(progress)), bake.absolute, depth)
            }
            Recipe::Channels(bake) => {
                let octave = |index: u8| {
                    let part = |done| progress((f32::from(index) + done) / 4.0);
                    Bake { cells: bake.cells << index, ..*bake }.values(&part)
                };
                texture::block_channels(&[0, 1, 2, 3].map(octave), depth)
            }
            Recipe::Random(seed, size, blur) => texture::texels_of(&random_block(*seed, *size, *blur), depth),
            Recipe::Row(index, weights) => {
                bytemuck::cast_slice(&texture::table_rows(&Noise::new(SEED, *weights))[*index]).to_vec()
            }
            Recipe::Phases => {
                static TILE: OnceLock<Vec<f32>> = OnceLock::new();
                bytemuck::cast_slice(TILE.get_or_init(|| blue_noise(PHASES))).to_vec()
            }
        }
    }

    /// Bytes of all levels down to the one without `faded` octaves.
    fn levels(&self, size: u32, faded: u32, depth: Depth, progress: Progress<'_>) -> Vec<u8> {
        let mut bytes = self.bytes(size, depth, progress);
        for faded in 1..=faded {
            let (level, mean) = self.level(faded);
            bytes.extend(level.make(mean, depth, &|_| ()));
        }
        bytes
    }

    /// Bytes of the block, from the disk cache or computed.
    fn bytes(&self, size: u32, depth: Depth, progress: Progress<'_>) -> Vec<u8> {
        if size < KEPT_FROM || matches!(self, Recipe::Row(..) | Recipe::Phases) {
            return self.make(0.0, depth, progress);
        }
        let key = blake3::hash(format!("{VERSION} {self:?} {depth:?}").as_bytes());
        disk_cache::load(KIND, key).unwrap_or_else(|| {
            let bytes = self.make(0.0, depth, progress);
            disk_cache::save(KIND, key, &bytes);
            bytes
        })
    }
}

/// A noise block or table of a scene.
#[derive(Debug)]
pub(crate) struct NoiseTexels {
    pub(super) image: NoiseImage,
    pub(super) recipe: Recipe,
    pub(super) depth: Depth,
    /// Number of further levels, each without another octave.
    pub(super) faded: u32,
    pub(super) size: u32,
}

impl NoiseTexels {
    /// Encodes the image. `progress` receives the finished share of a block, from any thread.
    pub(crate) fn encode(&self, progress: Progress<'_>) -> Encoded {
        let NoiseTexels { image, recipe, depth, faded, size } = *self;
        let dimension = match recipe {
            Recipe::Row(..) => Dimension::Line(size),
            Recipe::Phases => Dimension::Plane(size, size),
            _ => Dimension::Volume(size, size, size),
        };
        Encoded {
            image: image.into(),
            dimension,
            format: self.format(),
            bytes: recipe.levels(size, faded, depth, progress),
        }
    }

    pub(super) fn format(&self) -> Format {
        match (self.recipe.channels(), self.depth) {
            (1, Depth::Eight) => Format::R8Unorm,
            (1, Depth::Sixteen) => Format::R16Unorm,
            (1, Depth::Float) => Format::R32Float,
            (_, Depth::Eight) => Format::Rgba8Unorm,
            (_, Depth::Sixteen) => Format::Rgba16Unorm,
            (_, Depth::Float) => Format::Rgba32Float,
        }
    }

    /// The noise block or table of a scene.
    pub(crate) fn of(scene: &Scene, image: NoiseImage) -> NoiseTexels {
        let size = scene.quality.block_size;
        let weights = weights(scene);
        let [noise_cells, turbulence_cells, channel_cells] = scene.block_cells();
        let [held, low] = scene.block_octaves();
        let noise = Bake { weights, size, cells: noise_cells, octaves: 1, absolute: false };
        let turbulence = |octaves| Bake { weights, size, cells: turbulence_cells, octaves, absolute: true };
        let recipe = match image {
            NoiseImage::Noise => Recipe::Gradients(noise),
            NoiseImage::NoiseValues => Recipe::Values(noise),
            NoiseImage::Turbulence => Recipe::Gradients(turbulence(held)),
            NoiseImage::TurbulenceValues => Recipe::Values(turbulence(held)),
            NoiseImage::LowOctaves => Recipe::Values(turbulence(low)),
            NoiseImage::Channels => Recipe::Channels(Bake { cells: channel_cells, ..noise }),
            NoiseImage::Permutation => Recipe::Row(0, weights),
            NoiseImage::Gradients => Recipe::Row(1, weights),
            NoiseImage::Phases => Recipe::Phases,
            NoiseImage::Random => Recipe::Random(SEED, size, scene.quality.block_blur),
        };
        let (size, depth) = match (recipe, scene.quality.block_format, recipe.channels()) {
            (Recipe::Row(..), ..) => (256, Depth::Float),
            (Recipe::Phases, ..) => (PHASES as u32, Depth::Float),
            (_, BlockFormat::Unorm8, _) => (size, Depth::Eight),
            (_, BlockFormat::Unorm16, _) | (_, BlockFormat::Auto, 4) => (size, Depth::Sixteen),
            (_, BlockFormat::Float32 | BlockFormat::Auto, _) => (size, Depth::Float),
        };
        // Sums of octaves fade by levels: see glsl/octave_levels.glsl.
        let fades = scene.effect.bandlimit != "none";
        let faded = match recipe {
            Recipe::Values(bake) | Recipe::Gradients(bake) if bake.absolute && fades => bake.octaves,
            _ => 0,
        };
        NoiseTexels { image, recipe, depth, faded, size }
    }
}

/// Mean of |noise| of the block of random texels, which replaces faded octaves; 0 if no octaves are summed.
pub(crate) fn random_mean(scene: &Scene) -> f32 {
    static LAST: Mutex<Option<((u32, f32), f32)>> = Mutex::new(None);
    let mut effects = iter::once(&scene.effect).chain(scene.parts.values().map(|part| &part.effect));
    if !effects.any(|effect| effect.noise == "random" && effect.turbulence == "octaves") {
        return 0.0;
    }
    let key @ (size, blur) = (scene.quality.block_size, scene.quality.block_blur);
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    match *last {
        Some((known, mean)) if known == key => mean,
        _ => last.insert((key, mean_of_random(&random_block(SEED, size, blur), size))).1,
    }
}

fn weights(scene: &Scene) -> Weights {
    if scene.effect.weights == "cubic" { Weights::Cubic } else { Weights::Quintic }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_block_is_its_recipe_and_tells_how_far_it_is() {
        let mut scene = Scene::default();
        for size in [16, 64] {
            scene.quality.block_size = size;
            let images = [NoiseImage::Noise, NoiseImage::TurbulenceValues, NoiseImage::Channels, NoiseImage::Random];
            for image in images {
                let told = Mutex::new(vec![]);
                let [first, second] = [0, 1].map(|_| {
                    let own = NoiseTexels::of(&scene, image);
                    let block = own.encode(&|done| told.lock().unwrap().push(done));
                    assert_eq!(block.dimension, Dimension::Volume(size, size, size));
                    block.bytes
                });
                assert_eq!(first, second, "{image:?}: made, and made again or read");
                let told = told.into_inner().unwrap();
                assert!(told.iter().all(|done| (0.0..=1.0).contains(done)), "{image:?}: {told:?}");
                if size < KEPT_FROM && image != NoiseImage::Random {
                    assert_eq!(told.iter().copied().fold(0.0, f32::max), 1.0, "{image:?}");
                }
            }
        }
    }
}
