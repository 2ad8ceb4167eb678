//! Pipelines, with layouts of the bindings that their programs use.

use super::bind_set::{BindSet, Binding, BindingKind, Resource, layout_binding};
use super::covered::covered;
use super::{Format, Gpu, GpuError, Named};
use ash::vk;

/// Blending of premultiplied colors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// The fragment replaces the target.
    Replace,
    /// The fragment is in front of the target: for slices drawn back to front.
    Over,
    /// The fragment is behind the target: for slices drawn front to back.
    Under,
}

/// Use of pixel marks (values of a depth attachment) by a pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marks {
    /// The target has no marks.
    None,
    /// Only unmarked pixels are drawn.
    Test,
    /// Pixels are marked, and no color is written.
    Write,
}

/// Description of a pipeline.
pub struct PipelineDescription<'a> {
    /// SPIR-V of the vertex stage, entry point `main`.
    pub vertex: &'a [u32],
    /// SPIR-V of the fragment stage, entry point `main`.
    pub fragment: &'a [u32],
    /// Specialization constants by `constant_id`; a stage ignores those that it does not declare.
    pub constants: &'a [(u32, u32)],
    /// Bindings of both stages.
    pub bindings: &'a [Binding],
    /// Floats of each vertex attribute by location, interleaved in one buffer.
    pub attributes: &'a [u32],
    /// Format of the target.
    pub format: Format,
    /// Samples per pixel of the target; if above 1, each is shaded.
    pub samples: u32,
    /// Blending.
    pub blend: Blend,
    /// Use of marks.
    pub marks: Marks,
    /// Whether a driver of the CPU runs the fragment stage in covered pixels alone, if that reads no other pixels.
    pub covered: bool,
}

/// A pipeline and its layout.
pub struct Pipeline {
    gpu: Gpu,
    pub(super) handle: vk::Pipeline,
    pub(super) layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
    bindings: Vec<Binding>,
}

impl Pipeline {
    /// Compiles a pipeline.
    ///
    /// # Errors
    /// The device does not support the format, the sample count or sample shading, or rejects the program.
    pub fn new(gpu: &Gpu, description: &PipelineDescription<'_>) -> Result<Pipeline, GpuError> {
        check(gpu, description)?;
        let mut pipeline = Pipeline::with_layout(gpu, description.bindings, &[])?;
        let vertex = Module::new(gpu, description.vertex)?;
        let within = if description.covered && gpu.info().cpu { covered(description.fragment) } else { None };
        let fragment = Module::new(gpu, within.as_deref().unwrap_or(description.fragment))?;
        let (entries, values): (Vec<_>, Vec<u8>) = specialization(description.constants);
        let constants = vk::SpecializationInfo::default().map_entries(&entries).data(&values);
        let flags = [vk::ShaderStageFlags::VERTEX, vk::ShaderStageFlags::FRAGMENT];
        let stages = [stage(flags[0], &vertex, &constants), stage(flags[1], &fragment, &constants)];
        pipeline.handle = compile(gpu, description, &stages, pipeline.layout)?;
        Ok(pipeline)
    }

    /// Compiles a compute pipeline for areas of a picture: see [`Commands::dispatch`](super::Commands::dispatch).
    ///
    /// # Errors
    /// The device rejects the program.
    pub fn compute(
        gpu: &Gpu,
        code: &[u32],
        constants: &[(u32, u32)],
        bindings: &[Binding],
    ) -> Result<Pipeline, GpuError> {
        let area = [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::COMPUTE).size(16)];
        let mut pipeline = Pipeline::with_layout(gpu, bindings, &area)?;
        let module = Module::new(gpu, code)?;
        let (entries, values) = specialization(constants);
        let constants = vk::SpecializationInfo::default().map_entries(&entries).data(&values);
        let stage = stage(vk::ShaderStageFlags::COMPUTE, &module, &constants);
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(pipeline.layout)];
        // SAFETY: every handle belongs to the device and every pointer outlives the call.
        let pipelines = unsafe { gpu.0.device.create_compute_pipelines(gpu.0.pipeline_cache.handle, &info, None) };
        let pipelines = pipelines.map_err(|(_, result)| result).named("vkCreateComputePipelines")?;
        pipeline.handle = pipelines[0];
        Ok(pipeline)
    }

    /// Creates the layouts of a pipeline.
    fn with_layout(gpu: &Gpu, bindings: &[Binding], ranges: &[vk::PushConstantRange]) -> Result<Pipeline, GpuError> {
        let device = &gpu.0.device;
        let mut pipeline = Pipeline {
            gpu: gpu.clone(),
            handle: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            bindings: bindings.to_vec(),
        };
        let is_compute = !ranges.is_empty();
        check_count(gpu, &pipeline.bindings)?;
        let bindings: Vec<_> = bindings.iter().map(|binding| layout_binding(binding, is_compute)).collect();
        let set_info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: the device is alive, and every pointer outlives its call; each handle is owned as soon as it exists.
        unsafe {
            pipeline.set_layout =
                device.create_descriptor_set_layout(&set_info, None).named("vkCreateDescriptorSetLayout")?;
            let layouts = [pipeline.set_layout];
            let layout_info =
                vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts).push_constant_ranges(ranges);
            pipeline.layout = device.create_pipeline_layout(&layout_info, None).named("vkCreatePipelineLayout")?;
        }
        Ok(pipeline)
    }

    /// Whether the pipeline is one of a compute shader.
    pub fn is_compute(&self) -> bool {
        self.bindings.iter().any(|binding| matches!(binding.kind, BindingKind::Storage | BindingKind::Words))
    }

    /// Creates a descriptor set for a draw.
    ///
    /// # Errors
    /// Memory is exhausted.
    ///
    /// # Panics
    /// If a binding of the pipeline has no resource of its kind.
    pub fn bind(&self, resources: &[(u32, Resource)]) -> Result<BindSet, GpuError> {
        BindSet::new(&self.gpu, self.set_layout, &self.bindings, resources)
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        // SAFETY: submissions with the pipeline have finished; each handle is destroyed once, null is ignored.
        self.gpu.free(|device| unsafe {
            device.destroy_pipeline(self.handle, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        });
    }
}

fn stage<'a>(
    stage: vk::ShaderStageFlags,
    module: &Module,
    constants: &'a vk::SpecializationInfo<'a>,
) -> vk::PipelineShaderStageCreateInfo<'a> {
    let info = vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module.handle);
    info.name(c"main").specialization_info(constants)
}

fn specialization(constants: &[(u32, u32)]) -> (Vec<vk::SpecializationMapEntry>, Vec<u8>) {
    let entry = |(index, (id, _)): (usize, &(u32, u32))| {
        vk::SpecializationMapEntry::default().constant_id(*id).offset(4 * index as u32).size(4)
    };
    let values = constants.iter().flat_map(|(_, value)| value.to_ne_bytes());
    (constants.iter().enumerate().map(entry).collect(), values.collect())
}

/// Checks the number of images and samplers of the fragment or compute stage, which reads nearly all.
fn check_count(gpu: &Gpu, bindings: &[Binding]) -> Result<(), GpuError> {
    let info = gpu.info();
    let count = |kind: BindingKind| bindings.iter().filter(|own| own.kind == kind).count() as u32;
    let kinds = [
        (BindingKind::Image, "images", info.max_sampled_images),
        (BindingKind::Sampler, "samplers", info.max_samplers),
    ];
    match kinds.into_iter().find(|(kind, _, most)| count(*kind) > *most) {
        None => Ok(()),
        Some((kind, name, most)) => Err(GpuError::Unsupported {
            device: info.name.clone(),
            what: format!("{} {name} in one program", count(kind)),
            remedy: format!(
                "it has {most}; use fewer objects, formulas in place of volumes, light.shadows = false, or no groom"
            ),
        }),
    }
}

fn check(gpu: &Gpu, description: &PipelineDescription<'_>) -> Result<(), GpuError> {
    let unsupported =
        |what: String, remedy: String| Err(GpuError::Unsupported { device: gpu.info().name.clone(), what, remedy });
    if description.blend != Blend::Replace && !gpu.can_blend(description.format) {
        return unsupported(format!("blending into {:?}", description.format), "use another quality.target".into());
    }
    if description.marks == Marks::Write {
        return Ok(()); // every device supports the format of marks
    }
    let counts = gpu.sample_counts(description.format);
    if !counts.contains(&description.samples) {
        let what = format!("{} samples per pixel in {:?}", description.samples, description.format);
        return unsupported(what, format!("use quality.msaa = one of {counts:?}"));
    }
    if description.samples > 1 && !gpu.info().sample_shading {
        return unsupported("shading every sample of a pixel".into(), "use quality.msaa = 1".into());
    }
    Ok(())
}

fn compile(
    gpu: &Gpu,
    description: &PipelineDescription<'_>,
    stages: &[vk::PipelineShaderStageCreateInfo<'_>],
    layout: vk::PipelineLayout,
) -> Result<vk::Pipeline, GpuError> {
    let mut offset = 0;
    let mut attributes = Vec::new();
    for (location, &floats) in description.attributes.iter().enumerate() {
        let format = match floats {
            1 => vk::Format::R32_SFLOAT,
            2 => vk::Format::R32G32_SFLOAT,
            3 => vk::Format::R32G32B32_SFLOAT,
            _ => vk::Format::R32G32B32A32_SFLOAT,
        };
        let attribute = vk::VertexInputAttributeDescription::default().location(location as u32).offset(offset);
        attributes.push(attribute.format(format));
        offset += 4 * floats;
    }
    let buffers = [vk::VertexInputBindingDescription::default().stride(offset)];
    let mut input = vk::PipelineVertexInputStateCreateInfo::default();
    if !attributes.is_empty() {
        input = input.vertex_binding_descriptions(&buffers).vertex_attribute_descriptions(&attributes);
    }
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
    let multisample = vk::PipelineMultisampleStateCreateInfo::default()
        .rasterization_samples(vk::SampleCountFlags::from_raw(description.samples))
        .sample_shading_enable(description.samples > 1)
        .min_sample_shading(1.0);
    let colors = if description.marks == Marks::Write { 0 } else { 1 };
    let attachments = [blend_state(description.blend)];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&attachments[..colors]);
    let compare = if description.marks == Marks::Write { vk::CompareOp::ALWAYS } else { vk::CompareOp::LESS_OR_EQUAL };
    let depth = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(description.marks != Marks::None)
        .depth_write_enable(description.marks == Marks::Write)
        .depth_compare_op(compare);
    let dynamic_states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic_states);
    let formats = [description.format.vk()];
    let mut rendering = vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&formats[..colors]);
    if description.marks != Marks::None {
        rendering = rendering.depth_attachment_format(Format::Depth16.vk());
    }
    let info = vk::GraphicsPipelineCreateInfo::default()
        .stages(stages)
        .vertex_input_state(&input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&multisample)
        .depth_stencil_state(&depth)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout)
        .push_next(&mut rendering);
    // SAFETY: every handle belongs to the device and every pointer outlives the call.
    let pipelines = unsafe { gpu.0.device.create_graphics_pipelines(gpu.0.pipeline_cache.handle, &[info], None) };
    pipelines.map(|pipelines| pipelines[0]).map_err(|(_, result)| result).named("vkCreateGraphicsPipelines")
}

fn blend_state(blend: Blend) -> vk::PipelineColorBlendAttachmentState {
    let (source, destination) = match blend {
        Blend::Replace => (vk::BlendFactor::ONE, vk::BlendFactor::ZERO),
        Blend::Over => (vk::BlendFactor::ONE, vk::BlendFactor::ONE_MINUS_SRC_ALPHA),
        Blend::Under => (vk::BlendFactor::ONE_MINUS_DST_ALPHA, vk::BlendFactor::ONE),
    };
    vk::PipelineColorBlendAttachmentState::default()
        .blend_enable(blend != Blend::Replace)
        .src_color_blend_factor(source)
        .dst_color_blend_factor(destination)
        .src_alpha_blend_factor(source)
        .dst_alpha_blend_factor(destination)
        .color_write_mask(vk::ColorComponentFlags::RGBA)
}

/// A shader module, alive while its pipeline is compiled.
struct Module {
    gpu: Gpu,
    handle: vk::ShaderModule,
}

impl Module {
    fn new(gpu: &Gpu, code: &[u32]) -> Result<Module, GpuError> {
        let info = vk::ShaderModuleCreateInfo::default().code(code);
        // SAFETY: shaderc emits valid SPIR-V.
        let handle = unsafe { gpu.0.device.create_shader_module(&info, None) }.named("vkCreateShaderModule")?;
        Ok(Module { gpu: gpu.clone(), handle })
    }
}

impl Drop for Module {
    fn drop(&mut self) {
        // SAFETY: a pipeline does not need its modules once it is compiled; destroyed once.
        unsafe { self.gpu.0.device.destroy_shader_module(self.handle, None) };
    }
}
