//! What a program reads, as [`exact`] takes it.

use crate::exact;
use crate::gpu::{Address, Dimension, Format};
use crate::render::{CpuInputs, Encoded};
use std::collections::BTreeMap;

/// Images and samplers, as yet without blocks.
pub(super) fn inputs(cpu_inputs: &CpuInputs) -> exact::Inputs {
    exact::Inputs {
        blocks: BTreeMap::new(),
        images: cpu_inputs.images().iter().map(|(binding, image)| (*binding, texture(image))).collect(),
        samplers: cpu_inputs.samplers().iter().map(|(binding, filter)| (*binding, wrap(filter.address))).collect(),
    }
}

/// An image as [`exact`] samples it.
fn texture(image: &Encoded) -> exact::Texture {
    let size = match image.dimension {
        Dimension::Line(x) => [x, 1, 1],
        Dimension::Plane(x, y) => [x, y, 1],
        Dimension::Volume(x, y, z) => [x, y, z],
    };
    let code16 = |bytes: &[u8; 2]| f32::from(u16::from_ne_bytes(*bytes)) / 65535.0;
    let (bytes, one) = (image.bytes(), |value: f32| [value, 0.0, 0.0, 1.0]);
    let texels = match image.format {
        Format::R8Unorm => bytes.iter().map(|&code| one(f32::from(code) / 255.0)).collect(),
        Format::R16Unorm => bytes.as_chunks().0.iter().map(|code| one(code16(code))).collect(),
        Format::R32Float => bytes.as_chunks().0.iter().map(|float| one(f32::from_ne_bytes(*float))).collect(),
        Format::Rgba8Unorm => {
            bytes.as_chunks::<4>().0.iter().map(|texel| texel.map(|code| f32::from(code) / 255.0)).collect()
        }
        Format::Rgba16Unorm => {
            let four = |texel: &[u8; 8]| [0, 2, 4, 6].map(|at| code16(&[texel[at], texel[at + 1]]));
            bytes.as_chunks::<8>().0.iter().map(four).collect()
        }
        Format::Rgba16Float => {
            let half = |bytes: [u8; 2]| half::f16::from_ne_bytes(bytes).to_f32();
            let four = |texel: &[u8; 8]| [0, 2, 4, 6].map(|at| half([texel[at], texel[at + 1]]));
            bytes.as_chunks::<8>().0.iter().map(four).collect()
        }
        Format::Rgba32Float => {
            let four = |texel: &[u8; 16]| {
                [0, 4, 8, 12].map(|at| f32::from_ne_bytes([texel[at], texel[at + 1], texel[at + 2], texel[at + 3]]))
            };
            bytes.as_chunks::<16>().0.iter().map(four).collect()
        }
        // A host's targets, which no program reads.
        Format::Rgba8Srgb | Format::Bgra8Unorm | Format::Bgra8Srgb => Vec::new(),
    };
    exact::Texture { size, texels }
}

fn wrap(address: Address) -> exact::Wrap {
    match address {
        Address::Clamp => exact::Wrap::Clamp,
        Address::Repeat => exact::Wrap::Repeat,
        Address::Mirror => exact::Wrap::Mirror,
    }
}
