//! Inputs of a picture for evaluation on the CPU.

use super::encoded::Encoded;
use super::images::Inputs;
use super::uniforms::{Values, blocks};
use crate::eval;
use crate::gpu::Address;
use crate::render::camera::{FrameContext, LightSpace, SubFrame};
use crate::render::error::RenderError;
use crate::render::subject::Subject;
use crate::render::variant::{Blocks, PassImage, Program, Variant};
use crate::shader::Library;
use rayon::prelude::*;

/// Inputs of a program for every sub-frame of a picture.
pub struct CpuInputs {
    inputs: Inputs,
    moments: Vec<Values>,
    space: LightSpace,
    /// Depths that bound the scene.
    pub depths: [f64; 2],
}

impl CpuInputs {
    /// Inputs of `program`, which belongs to the scene of `variant`.
    pub fn new(
        library: &Library,
        variant: &Variant,
        subject: &Subject,
        program: &Program,
    ) -> Result<CpuInputs, RenderError> {
        let frame = FrameContext::of(variant.clone(), subject);
        let inputs = Inputs::new(library, &frame, program, &|_| ())?;
        let values = |moment: SubFrame| inputs.stored().values(&frame, &moment);
        let moments = SubFrame::all(&variant.scene).map(values).collect();
        let (extent, space) = (frame.view.extent, frame.space);
        let near = (extent.distance - extent.radius).max(extent.near);
        let depths = [near, extent.distance + extent.radius].map(f64::from);
        Ok(CpuInputs { inputs, moments, space, depths })
    }

    /// Images and samplers for [`eval`], without the shadow volume and without uniform blocks.
    pub fn exact(&self) -> eval::Inputs {
        eval::Inputs {
            images: self.inputs.images.par_iter().map(|(binding, image)| (*binding, texture(image))).collect(),
            samplers: self.inputs.samplers.iter().map(|(binding, filter)| (*binding, wrap(filter.address))).collect(),
            ..eval::Inputs::default()
        }
    }

    /// Uniform blocks of a program for each sub-frame, by binding. The program may be any that reads no further values.
    pub fn moments(&self, program: &Program) -> Result<Vec<Blocks>, RenderError> {
        self.moments.iter().map(|values| blocks(program, values)).collect()
    }

    /// Binding of the shadow volume, if the program reads one.
    pub fn shadow_binding(program: &Program) -> Option<u32> {
        program.image(PassImage::Shadow)
    }

    /// Size of the target of the shadow volume's segments.
    pub fn shadow_target(&self) -> [u32; 2] {
        self.space.target()
    }

    /// Rays along a side of a square of that target, and the corner of each square in order from the light.
    pub fn shadow_squares(&self) -> (u32, impl Iterator<Item = [u32; 2]> + Clone + use<>) {
        self.space.squares()
    }

    /// Size and texels of the shadow volume, from the transmittances of its segments.
    pub fn shadow_volume(&self, segments: &[[f32; 4]]) -> ([u32; 3], Vec<f32>) {
        (self.space.texels(), self.space.products(segments, |light| light))
    }
}

/// Decodes an image for [`eval`].
pub(crate) fn texture(image: &Encoded) -> eval::Texture {
    eval::Texture { size: image.dimension.size(), texels: image.format.decode(&image.bytes) }
}

pub(crate) fn wrap(address: Address) -> eval::Wrap {
    match address {
        Address::Clamp => eval::Wrap::Clamp,
        Address::Repeat => eval::Wrap::Repeat,
        Address::Mirror => eval::Wrap::Mirror,
    }
}
