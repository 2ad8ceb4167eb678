//! Inputs of a program on the device: uniform buffers, images and samplers.

use crate::field::Progress;
use crate::gpu::{self, Buffer, BufferUse, Gpu, Image, Sampler, Uploads};
use crate::render::camera::{FrameContext, SubFrame};
use crate::render::cells::{self, BackgroundCells, CellStats, EmptyCells, Tiles};
use crate::render::error::RenderError;
use crate::render::inputs::{
    Encoded, Filter, ImageInfo, Inputs, Sparse, StoredObjects, Values, block_image, blocks, groom_image,
};
use crate::render::variant::{
    Blocks, GroomImage, ImageInput, OCTAVES_ID, ObjectImage, PICTURE_BINDING, PassImage, Program, Resource, Use,
};
use crate::scene::Scene;
use crate::shader::Library;
use crate::shape::Groom;
use std::sync::Arc;

/// Bound resources of one program.
pub(crate) struct BoundInputs {
    blocks: Vec<(u32, Arc<Buffer>)>,
    images: Vec<(u32, Arc<Image>)>,
    samplers: Vec<(u32, Arc<Sampler>)>,
    sparse: Option<Sparse>,
    /// Whether an image depends on module parameters.
    pub(crate) holds_parameters: bool,
    stored: StoredObjects,
    /// Images whose texels are still to be copied.
    pub(crate) uploads: Uploads,
    /// Empty cells, if the program or its slices use them.
    cells: Option<EmptyCells>,
    /// Empty cells of recorded pictures.
    background_cells: BackgroundCells,
    /// Grid of a single non-empty cell, if the program reads cells.
    full_cell: Option<Arc<Image>>,
    /// Latest values of the blocks.
    values: Values,
}

impl BoundInputs {
    /// Uploads all images of a program except the shadow volume and the cells, which are rendered with the picture: see
    /// [`BoundInputs::replace`]. `is_cut` asks for cells for the tiles of slices. Images of recorded pictures are
    /// queued only.
    pub(crate) fn new(
        gpu: &Gpu,
        library: &Library,
        program: &Program,
        inputs: &Inputs,
        is_cut: bool,
        is_recorded: bool,
        progress: Progress<'_>,
    ) -> Result<BoundInputs, RenderError> {
        let uploads = Uploads::default();
        let upload = |(binding, image): &(u32, Encoded)| {
            let own = uploads.image(gpu, image.image.label(), image.dimension, image.format, &image.bytes)?;
            if !is_recorded {
                uploads.submit(gpu)?; // one by one: the texels exist twice until they are copied
            }
            Ok((*binding, own))
        };
        let mut images = inputs.images.iter().map(upload).collect::<Result<Vec<_>, RenderError>>()?;
        for (binding, block) in &inputs.blocks {
            images.push((*binding, Arc::new(block_image(gpu, block, progress)?)));
        }
        let sampler = |(binding, filter): &(u32, Filter)| {
            let lacks_filters = !gpu.info().unfiltered.is_empty();
            let made = if filter.reads_centers && lacks_filters {
                Sampler::nearest(gpu, filter.address)?
            } else {
                Sampler::new(gpu, filter.address, filter.anisotropy)?
            };
            Ok((*binding, Arc::new(made)))
        };
        inputs.samplers.iter().try_for_each(|(_, filter)| check_anisotropy(gpu, inputs, filter))?;
        let cells = (is_cut || program.reads_image(PassImage::Cells)).then(|| EmptyCells::new(library));
        Ok(BoundInputs {
            blocks: Vec::new(),
            images,
            samplers: inputs.samplers.iter().map(sampler).collect::<Result<_, RenderError>>()?,
            sparse: inputs.sparse,
            holds_parameters: inputs.holds_parameters,
            stored: inputs.stored().clone(),
            full_cell: program
                .reads_image(PassImage::Cells)
                .then(|| cells::image(gpu, &uploads, 1, &[0]))
                .transpose()?,
            uploads,
            cells,
            background_cells: BackgroundCells::new(library),
            values: Values::default(),
        })
    }

    /// Fills the blocks of a picture and proves its cells, unless told to `stop`.
    pub(crate) fn fill(
        &mut self,
        gpu: &Gpu,
        program: &Program,
        frame: &FrameContext,
        sub_frame: &SubFrame,
        stop: &dyn Fn() -> bool,
    ) -> Result<(), RenderError> {
        self.set_blocks(gpu, program, frame, sub_frame)?;
        let image_of = |name: &str| image_of(program, &self.images, name);
        let update = |cells: &mut EmptyCells| cells.update(gpu, frame, &self.values, &image_of, stop);
        self.cells.as_mut().map(update).transpose()?;
        if self.full_cell.is_some() {
            let own = self.cells.as_mut().map(|cells| cells.image(gpu, &self.uploads)).transpose()?.flatten();
            self.set_cells(program, own);
        }
        Ok(self.uploads.submit(gpu)?)
    }

    /// Binds the cells of a recorded picture that are proven so far, without waiting. The blocks are filled.
    pub(crate) fn update_recorded_cells(
        &mut self,
        gpu: &Gpu,
        program: &Program,
        frame: &FrameContext,
    ) -> Result<(), RenderError> {
        if self.full_cell.is_some() {
            let named = |own: &Resource| Some((own.name.clone(), image_of(program, &self.images, &own.name)?));
            let images = || program.resources.iter().filter_map(named).collect();
            let own = self.background_cells.image(gpu, frame, &self.values, images, &self.uploads)?;
            self.set_cells(program, own);
        }
        Ok(())
    }

    /// Binds the cells of a picture, or the single non-empty one.
    fn set_cells(&mut self, program: &Program, own: Option<Arc<Image>>) {
        if let Some(image) = own.or_else(|| self.full_cell.clone()) {
            self.replace(program, PassImage::Cells, image);
        }
    }

    /// Fills the blocks of a picture.
    pub(crate) fn set_blocks(
        &mut self,
        gpu: &Gpu,
        program: &Program,
        frame: &FrameContext,
        sub_frame: &SubFrame,
    ) -> Result<(), RenderError> {
        self.values = self.stored.values(frame, sub_frame);
        self.blocks = buffers(gpu, &self.blocks_of(program)?)?;
        Ok(())
    }

    /// Whether the cells of a picture are available at once.
    pub(crate) fn is_ready(&self, gpu: &Gpu, frame: &FrameContext) -> bool {
        self.cells.as_ref().is_none_or(|cells| cells.are_decided(gpu, frame))
    }

    /// Tiles of the picture, within some areas.
    pub(crate) fn tiles(&self, frame: &FrameContext, within: &[gpu::Area]) -> Tiles {
        cells::tiles(self.cells.as_ref(), frame, within)
    }

    /// Whether the next recorded picture has cells, and the empty share of the latest.
    #[cfg(test)]
    pub(crate) fn recorded_cells(&self) -> (bool, f32) {
        self.background_cells.found()
    }

    /// Statistics of the picture's cells.
    pub(crate) fn cells(&self) -> Option<CellStats> {
        self.cells.as_ref().and_then(EmptyCells::found)
    }

    /// Largest error of a stored distance, units of its object; 0 for formulas.
    pub(crate) fn quantization(&self) -> f32 {
        self.stored.quantization()
    }

    /// Memory saved by bricks.
    pub(crate) fn sparse(&self) -> Option<Sparse> {
        self.sparse
    }

    /// Binds an image that is rendered with the picture in place of the previous one.
    pub(crate) fn replace(&mut self, program: &Program, input: impl Into<ImageInput>, image: Arc<Image>) {
        if let Some(binding) = program.image(input) {
            self.images.retain(|(other, _)| *other != binding);
            self.images.push((binding, image));
        }
    }

    /// Uploads a groom in place of the one before. `has_cells`: whether the next pictures prove their cells anew, which takes
    /// longer than a stroke may.
    pub(crate) fn paint(
        &mut self,
        gpu: &Gpu,
        library: &Library,
        program: &Program,
        groom: &Groom,
        has_cells: bool,
    ) -> Result<(), RenderError> {
        let all = [GroomImage::Shape, GroomImage::Look, GroomImage::Amount];
        for input in all.into_iter().filter(|input| program.reads_image(*input)) {
            let own = groom_image(groom, input);
            let image = self.uploads.image(gpu, input.label(), own.dimension, own.format, &own.bytes)?;
            self.replace(program, input, image);
        }
        self.cells = has_cells.then(|| EmptyCells::new(library));
        Ok(self.uploads.submit(gpu)?)
    }

    /// Latest blocks of another program, which must not read further values.
    pub(crate) fn blocks_of(&self, program: &Program) -> Result<Blocks, RenderError> {
        blocks(program, &self.values)
    }

    /// Images that determine the results of another program. Cells do not: they only skip empty space.
    pub(crate) fn images_of(&self, program: &Program) -> Vec<Arc<Image>> {
        let cells = program.image(PassImage::Cells);
        let decides = |own: &Resource, number: u32| own.binding == number && cells != Some(number);
        let is_read = |(number, _): &&(u32, _)| program.resources.iter().any(|own| decides(own, *number));
        self.images.iter().filter(is_read).map(|(_, image)| image.clone()).collect()
    }

    /// Resources by binding.
    pub(crate) fn resources(&self) -> Vec<(u32, gpu::Resource)> {
        self.with(&self.blocks)
    }

    /// Images and samplers by binding, with the blocks of another program.
    pub(crate) fn with(&self, blocks: &[(u32, Arc<Buffer>)]) -> Vec<(u32, gpu::Resource)> {
        let blocks = blocks.iter().map(|(binding, block)| (*binding, gpu::Resource::Uniform(block.clone())));
        let images = self.images.iter().map(|(binding, image)| (*binding, gpu::Resource::Image(image.clone())));
        let samplers = self.samplers.iter().map(|(binding, own)| (*binding, gpu::Resource::Sampler(own.clone())));
        blocks.chain(images).chain(samplers).collect()
    }

    /// Descriptions of the images.
    pub(crate) fn images(&self) -> Vec<ImageInfo> {
        self.images.iter().map(|(_, image)| read(image)).collect()
    }

    /// Bytes of the images on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.images.iter().map(|(_, image)| image.bytes()).sum()
    }
}

/// Checks that the device filters distance fields whose sampler is anisotropic: no other filter can stand in. Blocks of
/// noise have samplers of their own, and other volumes are read texel by texel where the device cannot filter them.
fn check_anisotropy(gpu: &Gpu, inputs: &Inputs, filter: &Filter) -> Result<(), gpu::GpuError> {
    let fields = inputs.images.iter().filter(|(_, image)| image.image == ObjectImage::Volume.into());
    let mut formats = fields.map(|(_, image)| image.format).filter(|_| filter.anisotropy > 1.0);
    match formats.find(|format| !gpu.can_filter(*format)) {
        None => Ok(()),
        Some(format) => Err(gpu::GpuError::Unsupported {
            device: gpu.info().name.clone(),
            what: format!("linear filters of {format:?}"),
            remedy: "use quality.anisotropy = 1".into(),
        }),
    }
}

/// Uploads filled blocks, by binding.
pub(crate) fn buffers(gpu: &Gpu, blocks: &Blocks) -> Result<Vec<(u32, Arc<Buffer>)>, RenderError> {
    let buffer = |bytes| Buffer::new(gpu, "uniforms", BufferUse::Uniform, bytes);
    blocks.iter().map(|(binding, bytes)| Ok((*binding, Arc::new(buffer(bytes)?)))).collect()
}

/// Description of the image of a binding.
fn image_of(program: &Program, images: &[(u32, Arc<Image>)], name: &str) -> Option<ImageInfo> {
    let binding = program.binding(name)?;
    images.iter().find(|(own, _)| *own == binding).map(|(_, image)| read(image))
}

/// Description of an image.
fn read(image: &Image) -> ImageInfo {
    let channels = image.format().channels();
    let bits = 8 * image.format().bytes() as u32 / channels;
    ImageInfo { name: image.name().into(), size: image.size(), channels, bits, bytes: image.bytes() }
}

/// Vertices and target of a pipeline.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct PipelineShape {
    /// Numbers of each vertex attribute.
    pub(crate) attributes: &'static [u32],
    pub(crate) format: gpu::Format,
    /// Samples of a pixel.
    pub(crate) samples: u32,
    pub(crate) blend: gpu::Blend,
    /// Use of the opaque mask.
    pub(crate) marks: gpu::Marks,
}

impl PipelineShape {
    /// A pipeline without vertex attributes that replaces single samples of a format.
    pub(crate) const fn of(format: gpu::Format) -> PipelineShape {
        PipelineShape { attributes: &[], format, samples: 1, blend: gpu::Blend::Replace, marks: gpu::Marks::None }
    }
}

/// Compiles the pipeline of a program with the octaves of a scene.
pub(crate) fn pipeline(
    gpu: &Gpu,
    program: &Program,
    scene: &Scene,
    shape: PipelineShape,
) -> Result<gpu::Pipeline, gpu::GpuError> {
    let PipelineShape { attributes, format, samples, blend, marks } = shape;
    let mut bindings: Vec<gpu::Binding> = program.resources.iter().map(binding).collect();
    let (vertex, fragment, constants) = (&program.vertex, &program.fragment, &[(OCTAVES_ID, scene.effect.octaves)]);
    if program.is_compute {
        let kind = gpu::BindingKind::Storage;
        bindings.push(gpu::Binding { index: PICTURE_BINDING, kind, vertex: false, fragment: false });
        return gpu::Pipeline::compute(gpu, fragment, constants, &bindings);
    }
    let description = gpu::PipelineDescription {
        vertex,
        fragment,
        constants,
        bindings: &bindings,
        attributes,
        format,
        samples,
        blend,
        marks,
        // Programs of several objects end llvmpipe of Mesa 26.1 by a signal then: see `docs/notes/drivers.md`.
        covered: !scene.has_several(),
    };
    gpu::Pipeline::new(gpu, &description)
}

/// Binds the inputs of rays, and the target of a compute shader.
pub(super) fn bind_rays(
    program: &Program,
    pipeline: &gpu::Pipeline,
    mut resources: Vec<(u32, gpu::Resource)>,
    target: Option<&Arc<Image>>,
) -> Result<gpu::BindSet, gpu::GpuError> {
    let target = target.filter(|_| program.is_compute);
    resources.extend(target.map(|target| (PICTURE_BINDING, gpu::Resource::Storage(target.clone()))));
    pipeline.bind(&resources)
}

fn binding(resource: &Resource) -> gpu::Binding {
    let kind = match resource.holds {
        Use::Block(_) => gpu::BindingKind::Uniform,
        Use::Image => gpu::BindingKind::Image,
        Use::Sampler => gpu::BindingKind::Sampler,
    };
    gpu::Binding { index: resource.binding, kind, vertex: resource.vertex, fragment: resource.fragment }
}
