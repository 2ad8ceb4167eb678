//! Images and samplers encoded for the device.

use crate::gpu::{Address, Dimension, Format};
use crate::render::variant::{BLOCK_SAMPLER, ImageInput, ObjectImage};
use crate::scene::{self, Quality, Wrap};
use bytemuck::NoUninit;
use serde::{Deserialize, Serialize};

/// Description of an image that a program reads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ImageInfo {
    /// Name in words.
    pub name: String,
    /// Texels along each axis.
    pub size: [u32; 3],
    /// Channels of a texel.
    pub channels: u32,
    /// Bits of a channel.
    pub bits: u32,
    /// Bytes on the device.
    pub bytes: u64,
}

/// An encoded image: texels x fastest.
pub(crate) struct Encoded {
    pub(crate) image: ImageInput,
    pub(crate) dimension: Dimension,
    pub(crate) format: Format,
    pub(crate) bytes: Vec<u8>,
}

impl Encoded {
    pub(crate) fn new<T: NoUninit>(image: ObjectImage, dimension: Dimension, format: Format, texels: &[T]) -> Encoded {
        Encoded { image: image.into(), dimension, format, bytes: bytemuck::cast_slice(texels).to_vec() }
    }
}

/// A sampler: its address mode, its anisotropy (1 for none), and its use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Filter {
    pub(crate) address: Address,
    pub(crate) anisotropy: f32,
    /// Whether programs read the centers of texels alone.
    pub(crate) reads_centers: bool,
}

impl Filter {
    /// Sampler of a binding name in `interface.glsl`. Only the volume sampler is anisotropic: lavapipe of Mesa 22.3
    /// crashes with an anisotropic sampler of a 1D image, tables are never seen at a slant, and blocks are read at an
    /// explicit level.
    pub(crate) fn of(name: &str, quality: &Quality) -> Filter {
        let (address, anisotropy) = match name {
            "table_sampler" => (Address::Clamp, 1.0),
            "repeat_sampler" => (Address::Repeat, 1.0),
            BLOCK_SAMPLER if quality.wrap == Wrap::Mirror => (Address::Mirror, 1.0),
            BLOCK_SAMPLER => (Address::Repeat, 1.0),
            _ => (Address::Clamp, quality.anisotropy),
        };
        let reads_centers = name == "repeat_sampler" || (quality.filter == scene::Filter::Exact && anisotropy == 1.0);
        Filter { address, anisotropy, reads_centers }
    }
}
