//! Bindings of programs, and descriptor sets with their resources.

use super::{Buffer, Gpu, GpuError, Image, Named, Sampler};
use ash::vk;
use std::sync::Arc;

/// A binding of a program, in set 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Binding number.
    pub index: u32,
    /// Kind of resource.
    pub kind: BindingKind,
    /// Whether the vertex stage reads it.
    pub vertex: bool,
    /// Whether the fragment stage reads it.
    pub fragment: bool,
}

/// Kind of resource of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingKind {
    /// A uniform block.
    Uniform,
    /// An image; the program combines it with a sampler.
    Image,
    /// A sampler.
    Sampler,
    /// An image that a compute shader writes.
    Storage,
    /// A buffer that a compute shader writes.
    Words,
}

impl BindingKind {
    fn vk(self) -> vk::DescriptorType {
        match self {
            BindingKind::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
            BindingKind::Image => vk::DescriptorType::SAMPLED_IMAGE,
            BindingKind::Sampler => vk::DescriptorType::SAMPLER,
            BindingKind::Storage => vk::DescriptorType::STORAGE_IMAGE,
            BindingKind::Words => vk::DescriptorType::STORAGE_BUFFER,
        }
    }
}

/// A resource for a binding.
#[derive(Clone)]
pub enum Resource {
    /// A uniform block.
    Uniform(Arc<Buffer>),
    /// A sampled image.
    Image(Arc<Image>),
    /// A sampler.
    Sampler(Arc<Sampler>),
    /// An image that a compute shader writes.
    Storage(Arc<Image>),
    /// A buffer that a compute shader writes.
    Words(Arc<Buffer>),
}

impl Resource {
    fn kind(&self) -> BindingKind {
        match self {
            Resource::Uniform(_) => BindingKind::Uniform,
            Resource::Image(_) => BindingKind::Image,
            Resource::Sampler(_) => BindingKind::Sampler,
            Resource::Storage(_) => BindingKind::Storage,
            Resource::Words(_) => BindingKind::Words,
        }
    }
}

/// A descriptor set, which keeps its resources alive.
pub struct BindSet {
    gpu: Gpu,
    pool: vk::DescriptorPool,
    pub(super) handle: vk::DescriptorSet,
    bound: Vec<Resource>,
}

impl BindSet {
    /// A set of a layout with its resources: see [`Pipeline::bind`](super::Pipeline::bind).
    pub(super) fn new(
        gpu: &Gpu,
        layout: vk::DescriptorSetLayout,
        bindings: &[Binding],
        resources: &[(u32, Resource)],
    ) -> Result<BindSet, GpuError> {
        let device = &gpu.0.device;
        let size = |binding: &Binding| vk::DescriptorPoolSize { ty: binding.kind.vk(), descriptor_count: 1 };
        let sizes: Vec<_> = bindings.iter().map(size).collect();
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        // SAFETY: the device is alive; the new handle is owned before anything can fail.
        let pool = unsafe { device.create_descriptor_pool(&info, None) }.named("vkCreateDescriptorPool")?;
        let mut set = BindSet { gpu: gpu.clone(), pool, handle: vk::DescriptorSet::null(), bound: Vec::new() };
        let layouts = [layout];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        // SAFETY: pool and layout belong to the device, and the pool has room for one set of this layout.
        let allocated = unsafe { device.allocate_descriptor_sets(&info) }.named("vkAllocateDescriptorSets")?;
        set.handle = allocated[0];
        for binding in bindings {
            let (_, resource) = resources
                .iter()
                .find(|(index, resource)| *index == binding.index && resource.kind() == binding.kind)
                .unwrap_or_else(|| panic!("binding {} has no resource of kind {:?}", binding.index, binding.kind));
            set.write(binding, resource);
            set.bound.push(resource.clone());
        }
        Ok(set)
    }

    fn write(&self, binding: &Binding, resource: &Resource) {
        let write = vk::WriteDescriptorSet::default().dst_set(self.handle).dst_binding(binding.index);
        let write = write.descriptor_type(binding.kind.vk());
        let mut image = [vk::DescriptorImageInfo::default()];
        let mut buffer = [vk::DescriptorBufferInfo::default()];
        let write = match resource {
            Resource::Uniform(own) | Resource::Words(own) => {
                buffer[0] = buffer[0].buffer(own.handle).range(vk::WHOLE_SIZE);
                write.buffer_info(&buffer)
            }
            Resource::Image(sampled) => {
                image[0] = image[0].image_view(sampled.view).image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
                write.image_info(&image)
            }
            Resource::Storage(stored) => {
                image[0] = image[0].image_view(stored.view).image_layout(vk::ImageLayout::GENERAL);
                write.image_info(&image)
            }
            Resource::Sampler(sampler) => {
                image[0] = image[0].sampler(sampler.handle);
                write.image_info(&image)
            }
        };
        // SAFETY: the set is unused, and its resources belong to the device and are kept alive by the set.
        unsafe { self.gpu.0.device.update_descriptor_sets(&[write], &[]) };
    }
}

impl Drop for BindSet {
    fn drop(&mut self) {
        // SAFETY: submissions with the set have finished; the pool frees the set.
        self.gpu.free(|device| unsafe { device.destroy_descriptor_pool(self.pool, None) });
    }
}

/// The binding in a layout of a graphics pipeline, or of a compute pipeline.
pub(super) fn layout_binding(binding: &Binding, is_compute: bool) -> vk::DescriptorSetLayoutBinding<'static> {
    let mut stages = vk::ShaderStageFlags::empty();
    if is_compute {
        stages = vk::ShaderStageFlags::COMPUTE;
    } else {
        if binding.vertex {
            stages |= vk::ShaderStageFlags::VERTEX;
        }
        if binding.fragment {
            stages |= vk::ShaderStageFlags::FRAGMENT;
        }
    }
    vk::DescriptorSetLayoutBinding::default()
        .binding(binding.index)
        .descriptor_type(binding.kind.vk())
        .descriptor_count(1)
        .stage_flags(stages)
}
