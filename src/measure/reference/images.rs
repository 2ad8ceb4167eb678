//! What a program reads, as [`exact`] takes it.

use crate::exact;
use crate::gpu::{Address, Dimension};
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
    exact::Texture { size, texels: image.format.decode(image.bytes()) }
}

fn wrap(address: Address) -> exact::Wrap {
    match address {
        Address::Clamp => exact::Wrap::Clamp,
        Address::Repeat => exact::Wrap::Repeat,
        Address::Mirror => exact::Wrap::Mirror,
    }
}
