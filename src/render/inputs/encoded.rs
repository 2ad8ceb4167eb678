//! Images and samplers encoded for the device.

use crate::gpu::{Address, Dimension, Format};
use crate::render::variant::{ImageInput, ObjectImage, SamplerInput};
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
    /// Only the sampler of volumes is anisotropic: lavapipe of Mesa 22.3 crashes with an anisotropic sampler of a 1D image,
    /// tables are never seen at a slant, and blocks are read at an explicit level.
    pub(crate) fn of(sampler: SamplerInput, quality: &Quality) -> Filter {
        let (address, anisotropy) = match sampler {
            SamplerInput::Table => (Address::Clamp, 1.0),
            SamplerInput::Repeat => (Address::Repeat, 1.0),
            SamplerInput::Block if quality.wrap == Wrap::Mirror => (Address::Mirror, 1.0),
            SamplerInput::Block => (Address::Repeat, 1.0),
            SamplerInput::Clamp => (Address::Clamp, quality.anisotropy),
        };
        let is_exact = quality.filter == scene::Filter::Exact;
        let reads_centers = sampler == SamplerInput::Repeat || (is_exact && anisotropy == 1.0);
        Filter { address, anisotropy, reads_centers }
    }
}
