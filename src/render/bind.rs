//! What a program reads, on the device: blocks written, images uploaded.

use super::inputs::{Inputs, SHADOW, StoredObjects};
use super::shadow::LightSpace;
use super::sparse::Sparse;
use super::sub_frame::SubFrame;
use super::values::{Values, blocks};
use super::view::View;
use super::{RenderError, Subject};
use crate::gpu::{self, Buffer, BufferUse, Gpu, Image, Sampler};
use crate::render::pass::Planes;
use crate::render::variant::{Program, Resource, Use, Variant};
use crate::scene::Scene;

/// The resources of one program.
pub(super) struct BoundInputs {
    blocks: Vec<(Resource, Buffer)>,
    images: Vec<(u32, Image)>,
    samplers: Vec<(u32, Sampler)>,
    sparse: Option<Sparse>,
    stored: StoredObjects,
    /// What was written into the blocks last.
    values: Values,
}

impl BoundInputs {
    /// Everything that a program reads, but for the shadow volume, which is made with the rest of it: see
    /// [`BoundInputs::replace_shadow`].
    pub(super) fn new(gpu: &Gpu, program: &Program, inputs: &Inputs) -> Result<BoundInputs, RenderError> {
        let mut blocks = Vec::new();
        for resource in &program.resources {
            if let Use::Block(block) = &resource.holds {
                let buffer = Buffer::new(gpu, &resource.name, BufferUse::Uniform, &vec![0; block.bytes])?;
                blocks.push((resource.clone(), buffer));
            }
        }
        let upload = |(binding, image): &(u32, super::inputs::Encoded)| {
            let uploaded = Image::sampled(gpu, image.name, image.dimension, image.format, image.bytes())?;
            Ok((*binding, uploaded))
        };
        let sampler = |(binding, filter): &(u32, super::inputs::Filter)| {
            Ok((*binding, Sampler::new(gpu, filter.address, filter.anisotropy)?))
        };
        Ok(BoundInputs {
            blocks,
            images: inputs.images.iter().map(upload).collect::<Result<_, RenderError>>()?,
            samplers: inputs.samplers.iter().map(sampler).collect::<Result<_, RenderError>>()?,
            sparse: inputs.sparse,
            stored: inputs.stored().clone(),
            values: Values::new(),
        })
    }

    /// Writes the blocks for a picture; the last one is finished.
    pub(super) fn fill(
        &mut self,
        scene: &Scene,
        subject: &Subject,
        variant: &Variant,
        view: &View,
        moment: (&Planes, &LightSpace),
        sub_frame: &SubFrame,
    ) -> Result<(), RenderError> {
        self.values = self.stored.values(scene, subject, variant, view, moment, sub_frame);
        for (resource, buffer) in &mut self.blocks {
            let Use::Block(block) = &resource.holds else { continue };
            let bytes = block.fill(|name| self.values.get(name).map(Vec::as_slice)).map_err(RenderError::Unfilled)?;
            buffer.write(&resource.name, &bytes)?;
        }
        Ok(())
    }

    /// Largest error of a stored distance, units of its object; 0 for formulas.
    pub(super) fn quantization(&self) -> f32 {
        self.stored.quantization()
    }

    /// What the bricks of a volume save.
    pub(super) fn sparse(&self) -> Option<Sparse> {
        self.sparse
    }

    /// Puts the shadow volume among the images, in place of the one before.
    pub(super) fn replace_shadow(&mut self, program: &Program, image: Image) {
        if let Some(found) = program.resources.iter().find(|resource| resource.name == SHADOW) {
            self.images.retain(|(binding, _)| *binding != found.binding);
            self.images.push((found.binding, image));
        }
    }

    /// The blocks of another program that reads no value which this one does not have, as they were filled last.
    pub(super) fn blocks_of(&self, gpu: &Gpu, program: &Program) -> Result<Vec<(u32, Buffer)>, RenderError> {
        let buffer = |(resource, bytes): &(Resource, Vec<u8>)| {
            Ok((resource.binding, Buffer::new(gpu, &resource.name, BufferUse::Uniform, bytes)?))
        };
        blocks(program, &self.values)?.iter().map(buffer).collect()
    }

    /// The resources by binding.
    pub(super) fn resources(&self) -> Vec<(u32, gpu::Resource<'_>)> {
        let blocks = self.blocks.iter().map(|(resource, block)| (resource.binding, gpu::Resource::Uniform(block)));
        blocks.chain(self.images_and_samplers()).collect()
    }

    /// The images and samplers by binding.
    pub(super) fn images_and_samplers(&self) -> impl Iterator<Item = (u32, gpu::Resource<'_>)> {
        let images = self.images.iter().map(|(binding, image)| (*binding, gpu::Resource::Image(image)));
        images.chain(self.samplers.iter().map(|(binding, sampler)| (*binding, gpu::Resource::Sampler(sampler))))
    }

    /// Bytes of the images on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.images.iter().map(|(_, image)| image.bytes()).sum()
    }
}

/// The layout entry of a resource.
pub(super) fn binding(resource: &Resource) -> gpu::Binding {
    let kind = match resource.holds {
        Use::Block(_) => gpu::BindingKind::Uniform,
        Use::Image => gpu::BindingKind::Image,
        Use::Sampler => gpu::BindingKind::Sampler,
    };
    gpu::Binding { index: resource.binding, kind, vertex: resource.vertex, fragment: resource.fragment }
}
