//! All that a picture is computed from, for a processor to compute it.

use super::encoded::Encoded;
use super::images::{Inputs, SHADOW};
use super::uniforms::{Values, blocks};
use crate::eval;
use crate::gpu::Address;
use crate::render::camera::{FrameContext, LightSpace, SubFrame};
use crate::render::error::RenderError;
use crate::render::subject::Subject;
use crate::render::variant::{Program, Variant};
use crate::scene::Scene;
use crate::shader::Library;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The blocks of a program, by binding.
pub type Blocks = BTreeMap<u32, Vec<u8>>;

/// What a program reads, for every sub-frame of a picture.
pub struct CpuInputs {
    inputs: Inputs,
    moments: Vec<Values>,
    space: LightSpace,
    /// Depths between which the scene is.
    pub depths: [f64; 2],
}

impl CpuInputs {
    /// What `program`, of the same scene as `variant`, reads.
    pub fn new(
        library: &Library,
        scene: &Scene,
        subject: &Subject,
        variant: &Variant,
        program: &Program,
    ) -> Result<CpuInputs, RenderError> {
        let shot = FrameContext::of(scene, subject, variant);
        let inputs = Inputs::new(library, &shot, program, &|_| ())?;
        let values = |moment: SubFrame| inputs.stored().values(&shot, &moment);
        let moments = SubFrame::all(scene).map(values).collect();
        let (extent, space) = (shot.view.extent, shot.space);
        let near = (extent.distance - extent.radius).max(extent.near);
        let depths = [near, extent.distance + extent.radius].map(f64::from);
        Ok(CpuInputs { inputs, moments, space, depths })
    }

    /// The images but for the shadow volume, and the samplers, as [`eval`] takes them; as yet without blocks.
    pub fn exact(&self) -> eval::Inputs {
        eval::Inputs {
            blocks: BTreeMap::new(),
            until: BTreeMap::new(),
            images: self.inputs.images.par_iter().map(|(binding, image)| (*binding, texture(image))).collect(),
            samplers: self.inputs.samplers.iter().map(|(binding, filter)| (*binding, wrap(filter.address))).collect(),
            noises: BTreeMap::new(),
        }
    }

    /// The blocks of a program that reads no value which this one does not have, for each sub-frame, by binding.
    pub fn moments(&self, program: &Program) -> Result<Vec<Blocks>, RenderError> {
        let filled = |values| {
            let blocks = blocks(program, values)?;
            Ok(blocks.into_iter().map(|(resource, bytes)| (resource.binding, bytes)).collect())
        };
        self.moments.iter().map(filled).collect()
    }

    /// Binding of the shadow volume, where the program reads one.
    pub fn shadow_binding(program: &Program) -> Option<u32> {
        program.resources.iter().find(|resource| resource.name == SHADOW).map(|resource| resource.binding)
    }

    /// Size of the target that the segments of the shadow volume are drawn into.
    pub fn shadow_target(&self) -> [u32; 2] {
        self.space.target()
    }

    /// Rays along a side of a square of that target, and where each square begins, from the light on.
    pub fn shadow_squares(&self) -> (u32, impl Iterator<Item = [u32; 2]> + Clone + use<>) {
        self.space.squares()
    }

    /// Size and texels of the shadow volume, from the transmittances of its segments.
    pub fn shadow_volume(&self, segments: &[[f32; 4]]) -> ([u32; 3], Vec<f32>) {
        (self.space.texels(), self.space.products(segments, |light| light))
    }
}

/// An image as [`exact`] samples it.
pub(crate) fn texture(image: &Encoded) -> eval::Texture {
    eval::Texture { size: image.dimension.size(), texels: image.format.decode(image.bytes()) }
}

pub(crate) fn wrap(address: Address) -> eval::Wrap {
    match address {
        Address::Clamp => eval::Wrap::Clamp,
        Address::Repeat => eval::Wrap::Repeat,
        Address::Mirror => eval::Wrap::Mirror,
    }
}
