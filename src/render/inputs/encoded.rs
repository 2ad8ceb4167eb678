//! Images and samplers as the device takes them.

use crate::gpu::{Address, Dimension, Format};
use crate::scene::{Quality, Wrap};
use serde::{Deserialize, Serialize};

/// An image that a program reads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ImageInfo {
    /// What it holds.
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

/// An image, encoded.
pub(crate) struct Encoded {
    pub(crate) name: &'static str,
    pub(crate) dimension: Dimension,
    pub(crate) format: Format,
    pub(crate) content: Content,
}

/// Texels as they were made, x fastest.
pub(crate) enum Content {
    Bytes(Vec<u8>),
    Codes(Vec<u16>),
    Floats(Vec<f32>),
}

impl Encoded {
    /// The texels as the device takes them.
    pub(crate) fn bytes(&self) -> &[u8] {
        match &self.content {
            Content::Bytes(bytes) => bytes,
            Content::Codes(codes) => bytemuck::cast_slice(codes),
            Content::Floats(floats) => bytemuck::cast_slice(floats),
        }
    }
}

/// A sampler: what it returns outside [0, 1], and its anisotropy, 1 for none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Filter {
    pub(crate) address: Address,
    pub(crate) anisotropy: f32,
}

impl Filter {
    /// The sampler of a name in `interface.glsl`. Only that of volumes is anisotropic: a driver may end by an anisotropic
    /// sampler of an image of one dimension (lavapipe of Mesa 22.3), a table is never seen at a slant, and blocks are
    /// read at a level of their own.
    pub(crate) fn of(name: &str, quality: &Quality) -> Filter {
        let (address, anisotropy) = match name {
            "table_sampler" => (Address::Clamp, 1.0),
            "repeat_sampler" => (Address::Repeat, 1.0),
            "block_sampler" if quality.wrap == Wrap::Mirror => (Address::Mirror, 1.0),
            "block_sampler" => (Address::Repeat, 1.0),
            _ => (Address::Clamp, quality.anisotropy),
        };
        Filter { address, anisotropy }
    }
}
