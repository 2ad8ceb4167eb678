//! Accuracy against time, and how the samples of a picture are taken.

use serde::{Deserialize, Serialize};

/// Accuracy against time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Quality {
    /// How the samples are taken.
    pub pass: Pass,
    /// Slices through the sphere around the object, or samples of a ray through it.
    pub samples: u32,
    /// What a sample stands for.
    pub integration: Integration,
    /// Which samples of rays and slices are taken: all of them, or those that may not be empty.
    pub empty_space: EmptySpace,
    /// What becomes of the terms of modules that a parameter of 0 takes away.
    pub neutral: Neutral,
    /// A ray ends where less light than this would still come through, 0 to 0.5: the largest error of a pixel, in units
    /// of the brightest matter behind. Slices have no such end.
    pub early_termination: f32,
    /// Format that the slices are blended in.
    pub target: TargetFormat,
    /// Order of the slices.
    pub order: Order,
    /// Shape of the slices.
    pub proxy: Proxy,
    /// What becomes of fragments of slices that hold no matter.
    pub reject: Reject,
    /// Samples per pixel, each shaded: 1, 2, 4, 8.
    pub msaa: u32,
    /// Whether each pixel has its own phase of the steps along its ray, and where it comes from.
    pub jitter: Jitter,
    /// Which phases the pixels have, up to 16 777 215.
    pub seed: u32,
    /// Pictures of which the mean is taken, 1 to 256: each with its own place in the pixel, phase and time.
    pub supersampling: u32,
    /// Who interpolates between the texels of volumes and blocks.
    pub filter: Filter,
    /// Anisotropy of the filter of volumes, 1 (off) to 16; blocks of noise have none.
    pub anisotropy: f32,
    /// Texels along a side of the blocks of noise and turbulence: 16, 32, 64, 128 or 256.
    pub block_size: u32,
    /// Lattice cells of the first octave across the block of turbulence: 1, 2, 4, ... 64, at most half of its texels. With
    /// half as many, the block holds one octave more and repeats after half the distance.
    pub turbulence_cells: u32,
    /// What is beyond the border of a block.
    pub wrap: Wrap,
    /// How the texels of a block are stored.
    pub block_format: BlockFormat,
    /// Standard deviation of the blur of `noise = "random"`, texels, 0 to 4.
    pub block_blur: f32,
}

impl std::default::Default for Quality {
    fn default() -> Quality {
        Quality {
            pass: Pass::March,
            samples: 256,
            integration: Integration::Point,
            empty_space: EmptySpace::Skip,
            neutral: Neutral::LeaveOut,
            early_termination: 1e-4,
            target: TargetFormat::Float32,
            order: Order::FrontToBack,
            proxy: Proxy::Polygons,
            reject: Reject::Discard,
            msaa: 1,
            jitter: Jitter::None,
            seed: 0,
            supersampling: 1,
            filter: Filter::Device,
            anisotropy: 1.0,
            block_size: 64,
            turbulence_cells: 4,
            wrap: Wrap::Repeat,
            block_format: BlockFormat::Auto,
            block_blur: 0.7,
        }
    }
}

/// How the samples of a picture are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Pass {
    /// View-aligned slices, blended (MJ).
    Slices,
    /// Rays through the pixels, sampled where the slices would be (PH): the same picture, which leaves out what is empty
    /// or hidden.
    #[default]
    March,
}

/// What a sample stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Integration {
    /// For itself: first order at surfaces and where soft matter becomes opaque.
    #[default]
    Point,
    /// For half a step to either side, in which the density is linear: second order.
    Segment,
}

/// Where the phases of the pixels come from: noise in place of banding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Jitter {
    /// All have the same.
    #[default]
    None,
    /// A hash of the pixel: white noise.
    Hash,
    /// A tile of blue noise: the same error, but fine grain alone.
    Blue,
}

/// What becomes of the samples of rays and slices where there is no matter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum EmptySpace {
    /// All of them are taken.
    Sample,
    /// They are left out as far as bounds of the matter show it, and to rays the distance to the object: the same picture,
    /// sooner.
    #[default]
    Skip,
}

/// What becomes of the terms of modules that a parameter of 0 takes away; the picture is the same but for roundings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Neutral {
    /// They are computed and come to nothing: the program serves every value of the parameter.
    Keep,
    /// The program does without them and what they alone read.
    #[default]
    LeaveOut,
}

/// Format that the slices are blended in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TargetFormat {
    /// 8 bits: the paper's; loses thin matter.
    Unorm8,
    /// 16-bit float.
    Float16,
    /// 32-bit float.
    #[default]
    Float32,
}

/// Order of the slices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Nearest first.
    #[default]
    FrontToBack,
    /// Farthest first.
    BackToFront,
}

/// Shape of the slices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Proxy {
    /// Cut to the box around the soft region.
    #[default]
    Polygons,
    /// Quads that fit every rotation: the paper's.
    Quads,
}

/// What becomes of fragments of slices that hold no matter; the picture is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reject {
    /// They end at once (MJ 3.5).
    #[default]
    Discard,
    /// They are blended with alpha 0 (MJ 7: cards that do not discard).
    Keep,
}

/// Who interpolates between the texels of volumes and blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Filter {
    /// The device: one lookup, whose weights have 8 bits on most GPUs; those of lavapipe have more.
    #[default]
    Device,
    /// The shader: eight lookups, and weights of 32 bits.
    Exact,
}

impl Filter {
    /// The faster one of those that weigh by floats, on a device whose own does so or weighs by few bits.
    pub fn precise(device_has_few_bits: bool) -> Filter {
        if device_has_few_bits { Filter::Exact } else { Filter::Device }
    }
}

/// What is beyond the border of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Wrap {
    /// The block again: it has no seam.
    #[default]
    Repeat,
    /// Its mirror image: period twice as long, with creases (MJ 4.1).
    Mirror,
}

/// How the texels of a block are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum BlockFormat {
    /// Values alone as 32-bit floats, which lavapipe filters 1.5 times as fast as 16 bits; with gradients 16 bits each.
    #[default]
    Auto,
    /// 8 bits a channel.
    Unorm8,
    /// 16 bits a channel.
    Unorm16,
    /// 32-bit floats.
    Float32,
}
