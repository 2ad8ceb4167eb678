//! Texel formats.

use ash::vk;

/// Texel formats that the renderer uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// One channel, 8 bits, [0, 1].
    R8Unorm,
    /// One channel, 16 bits, [0, 1].
    R16Unorm,
    /// One channel, 32-bit float.
    R32Float,
    /// Four channels, 8 bits, [0, 1].
    Rgba8Unorm,
    /// Four channels, 16 bits, [0, 1].
    Rgba16Unorm,
    /// Four channels, 16-bit float.
    Rgba16Float,
    /// Four channels, 32-bit float.
    Rgba32Float,
    /// Four channels, 8 bits, colors encoded as sRGB.
    Rgba8Srgb,
    /// [`Format::Rgba8Unorm`] in the order BGRA.
    Bgra8Unorm,
    /// [`Format::Rgba8Srgb`] in the order BGRA.
    Bgra8Srgb,
    /// Depth, 16 bits, [0, 1].
    Depth16,
}

impl Format {
    /// Formats of images that compute shaders write.
    pub(super) const STORED: [Format; 3] = [Format::R32Float, Format::Rgba8Unorm, Format::Rgba32Float];

    /// Formats that shaders may filter linearly.
    pub const SAMPLED: [Format; 7] = [
        Format::R8Unorm,
        Format::R16Unorm,
        Format::R32Float,
        Format::Rgba8Unorm,
        Format::Rgba16Unorm,
        Format::Rgba16Float,
        Format::Rgba32Float,
    ];

    /// The format of floats that holds the texels of one of 16-bit codes, which devices need not support.
    pub(super) fn widened(self) -> Option<Format> {
        match self {
            Format::R16Unorm => Some(Format::R32Float),
            Format::Rgba16Unorm => Some(Format::Rgba32Float),
            _ => None,
        }
    }

    /// Texels in the widened format.
    pub(super) fn widen(self, texels: &[u8]) -> Vec<u8> {
        let channels = self.channels() as usize;
        let floats = self.decode(texels).into_iter().flat_map(|texel| texel.into_iter().take(channels));
        floats.flat_map(f32::to_ne_bytes).collect()
    }

    /// Bytes of one texel.
    pub fn bytes(self) -> u64 {
        match self {
            Format::R8Unorm => 1,
            Format::R16Unorm | Format::Depth16 => 2,
            Format::R32Float | Format::Rgba8Unorm | Format::Rgba8Srgb => 4,
            Format::Bgra8Unorm | Format::Bgra8Srgb => 4,
            Format::Rgba16Unorm | Format::Rgba16Float => 8,
            Format::Rgba32Float => 16,
        }
    }

    /// Channels of one texel.
    pub fn channels(self) -> u32 {
        match self {
            Format::R8Unorm | Format::R16Unorm | Format::R32Float | Format::Depth16 => 1,
            _ => 4,
        }
    }

    pub(super) fn vk(self) -> vk::Format {
        match self {
            Format::R8Unorm => vk::Format::R8_UNORM,
            Format::R16Unorm => vk::Format::R16_UNORM,
            Format::R32Float => vk::Format::R32_SFLOAT,
            Format::Rgba8Unorm => vk::Format::R8G8B8A8_UNORM,
            Format::Rgba16Unorm => vk::Format::R16G16B16A16_UNORM,
            Format::Rgba16Float => vk::Format::R16G16B16A16_SFLOAT,
            Format::Rgba32Float => vk::Format::R32G32B32A32_SFLOAT,
            Format::Rgba8Srgb => vk::Format::R8G8B8A8_SRGB,
            Format::Bgra8Unorm => vk::Format::B8G8R8A8_UNORM,
            Format::Bgra8Srgb => vk::Format::B8G8R8A8_SRGB,
            Format::Depth16 => vk::Format::D16_UNORM,
        }
    }

    /// Subresource range of a whole image.
    pub(super) fn range(self) -> vk::ImageSubresourceRange {
        let aspect_mask = match self {
            Format::Depth16 => vk::ImageAspectFlags::DEPTH,
            _ => vk::ImageAspectFlags::COLOR,
        };
        vk::ImageSubresourceRange { aspect_mask, ..COLOR }
    }

    /// Decodes texels as the device reads them: missing channels are 0, and alpha is 1.
    pub fn decode(self, bytes: &[u8]) -> Vec<[f32; 4]> {
        let code8 = |code: u8| f32::from(code) / 255.0;
        let code16 = |code: &[u8; 2]| f32::from(u16::from_ne_bytes(*code)) / 65535.0;
        let half = |float: &[u8; 2]| half::f16::from_ne_bytes(*float).to_f32();
        let linear = |[r, g, b, a]: [f32; 4]| {
            let line = |c: f32| if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
            [line(r), line(g), line(b), a]
        };
        let swapped = |[b, g, r, a]: [f32; 4]| [r, g, b, a];
        let one = |value: f32| [value, 0.0, 0.0, 1.0];
        match self {
            Format::R8Unorm => bytes.iter().map(|code| one(code8(*code))).collect(),
            Format::R16Unorm | Format::Depth16 => bytes.as_chunks().0.iter().map(|code| one(code16(code))).collect(),
            Format::R32Float => bytes.as_chunks().0.iter().map(|float| one(f32::from_ne_bytes(*float))).collect(),
            Format::Rgba8Unorm => bytes.as_chunks::<4>().0.iter().map(|texel| texel.map(code8)).collect(),
            Format::Rgba8Srgb => Format::Rgba8Unorm.decode(bytes).into_iter().map(linear).collect(),
            Format::Bgra8Unorm => Format::Rgba8Unorm.decode(bytes).into_iter().map(swapped).collect(),
            Format::Bgra8Srgb => Format::Rgba8Srgb.decode(bytes).into_iter().map(swapped).collect(),
            Format::Rgba16Unorm => fours(bytes, code16),
            Format::Rgba16Float => fours(bytes, half),
            Format::Rgba32Float => bytemuck::pod_collect_to_vec(&bytes[..bytes.len() / 16 * 16]),
        }
    }
}

/// Subresource range of a color image with one layer.
pub(super) const COLOR: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: vk::REMAINING_MIP_LEVELS,
    base_array_layer: 0,
    layer_count: 1,
};

/// Decodes texels of four channels of `N` bytes each.
fn fours<const N: usize>(bytes: &[u8], channel: impl Fn(&[u8; N]) -> f32) -> Vec<[f32; 4]> {
    let texels = bytes.as_chunks::<N>().0.as_chunks::<4>().0.iter();
    texels.map(|texel| texel.each_ref().map(&channel)).collect()
}
