//! Fault injection: calls of Vulkan that fail when a test says so, without reaching the driver.
//!
//! The functions are replaced in the table of ash, so that the calls of gpu-allocator are included.

use super::instance::Instance;
use ash::{DeviceFnV1_0, DeviceFnV1_3, Entry, vk};
use hypertexture_support::faults::{fails, is_lost};
use std::ffi::c_void;
use std::sync::OnceLock;

/// Calls that report a lost device.
pub(super) const LOSING: [&str; 3] = ["vkQueueSubmit2", "vkWaitForFences", "vkGetQueryPoolResults"];

/// Injected result of a call: a queue loses its device, a wait times out, all others run out of memory.
fn fault(name: &'static str) -> Option<vk::Result> {
    if LOSING.contains(&name) && is_lost(name) {
        return Some(vk::Result::ERROR_DEVICE_LOST);
    }
    let result = match name {
        "vkQueueSubmit2" => vk::Result::ERROR_DEVICE_LOST,
        "vkWaitForFences" => vk::Result::TIMEOUT,
        _ => vk::Result::ERROR_OUT_OF_HOST_MEMORY,
    };
    fails(name).then_some(result)
}

/// Functions of the loader, which dispatch by handle: one table serves every device. The loader stays loaded.
static REAL: OnceLock<(Entry, DeviceFnV1_0, DeviceFnV1_3)> = OnceLock::new();

macro_rules! may_fail {
    ($(of $table:tt { $($call:ident $name:literal ($($argument:ident: $type:ty),*);)* })*) => {
        $($(
            // SAFETY: called only through ash, whose callers meet the requirements of the Vulkan function.
            unsafe extern "system" fn $call($($argument: $type),*) -> vk::Result {
                match (fault($name), REAL.get()) {
                    // SAFETY: as below. The wait is still made, so that no work of a test continues after it.
                    (Some(result), Some(real)) if $name == "vkWaitForFences" => unsafe {
                        let _ = (real.$table.$call)($($argument),*);
                        result
                    },
                    (Some(result), _) => result,
                    // SAFETY: the caller passes the arguments and meets the requirements of the Vulkan function.
                    (None, Some(real)) => unsafe { (real.$table.$call)($($argument),*) },
                    (None, None) => vk::Result::ERROR_INITIALIZATION_FAILED,
                }
            }
        )*)*

        /// Replaces the functions of a device by ones that may fail.
        pub(super) fn armed(instance: &Instance, device: ash::Device) -> ash::Device {
            // SAFETY: the instance is alive; the loader returns functions with the types of their names.
            let load = |name: &std::ffi::CStr| unsafe {
                (instance.entry.static_fn().get_instance_proc_addr)(instance.raw.handle(), name.as_ptr())
                    .map_or(std::ptr::null(), |function| function as *const c_void)
            };
            REAL.get_or_init(|| (instance.entry.clone(), DeviceFnV1_0::load(load), DeviceFnV1_3::load(load)));
            let mut tables = (device.clone(), device.fp_v1_0().clone(), device.fp_v1_3().clone());
            $($(tables.$table.$call = $call;)*)*
            let (_, v1_0, v1_3) = tables;
            ash::Device::from_parts_1_3(
                device.handle(),
                v1_0,
                device.fp_v1_1().clone(),
                device.fp_v1_2().clone(),
                v1_3,
            )
        }
    };
}

type Callbacks<'a> = *const vk::AllocationCallbacks<'a>;

may_fail! {
    of 1 {
        create_command_pool "vkCreateCommandPool"
            (d: vk::Device, i: *const vk::CommandPoolCreateInfo<'_>, c: Callbacks<'_>, o: *mut vk::CommandPool);
        create_pipeline_cache "vkCreatePipelineCache"
            (d: vk::Device, i: *const vk::PipelineCacheCreateInfo<'_>, c: Callbacks<'_>, o: *mut vk::PipelineCache);
        get_pipeline_cache_data "vkGetPipelineCacheData"
            (d: vk::Device, cache: vk::PipelineCache, size: *mut usize, data: *mut c_void);
        create_buffer "vkCreateBuffer"
            (d: vk::Device, i: *const vk::BufferCreateInfo<'_>, c: Callbacks<'_>, o: *mut vk::Buffer);
        bind_buffer_memory "vkBindBufferMemory"
            (d: vk::Device, buffer: vk::Buffer, memory: vk::DeviceMemory, offset: vk::DeviceSize);
        create_image "vkCreateImage"
            (d: vk::Device, i: *const vk::ImageCreateInfo<'_>, c: Callbacks<'_>, o: *mut vk::Image);
        bind_image_memory "vkBindImageMemory"
            (d: vk::Device, image: vk::Image, memory: vk::DeviceMemory, offset: vk::DeviceSize);
        create_image_view "vkCreateImageView"
            (d: vk::Device, i: *const vk::ImageViewCreateInfo<'_>, c: Callbacks<'_>, o: *mut vk::ImageView);
        create_sampler "vkCreateSampler"
            (d: vk::Device, i: *const vk::SamplerCreateInfo<'_>, c: Callbacks<'_>, o: *mut vk::Sampler);
        allocate_memory "vkAllocateMemory"
            (d: vk::Device, i: *const vk::MemoryAllocateInfo<'_>, c: Callbacks<'_>, o: *mut vk::DeviceMemory);
        map_memory "vkMapMemory"
            (d: vk::Device, memory: vk::DeviceMemory, offset: vk::DeviceSize, size: vk::DeviceSize,
             flags: vk::MemoryMapFlags, o: *mut *mut c_void);
        create_descriptor_set_layout "vkCreateDescriptorSetLayout"
            (d: vk::Device, i: *const vk::DescriptorSetLayoutCreateInfo<'_>, c: Callbacks<'_>,
             o: *mut vk::DescriptorSetLayout);
        create_pipeline_layout "vkCreatePipelineLayout"
            (d: vk::Device, i: *const vk::PipelineLayoutCreateInfo<'_>, c: Callbacks<'_>, o: *mut vk::PipelineLayout);
        create_shader_module "vkCreateShaderModule"
            (d: vk::Device, i: *const vk::ShaderModuleCreateInfo<'_>, c: Callbacks<'_>, o: *mut vk::ShaderModule);
        create_graphics_pipelines "vkCreateGraphicsPipelines"
            (d: vk::Device, cache: vk::PipelineCache, count: u32, i: *const vk::GraphicsPipelineCreateInfo<'_>,
             c: Callbacks<'_>, o: *mut vk::Pipeline);
        create_compute_pipelines "vkCreateComputePipelines"
            (d: vk::Device, cache: vk::PipelineCache, count: u32, i: *const vk::ComputePipelineCreateInfo<'_>,
             c: Callbacks<'_>, o: *mut vk::Pipeline);
        create_descriptor_pool "vkCreateDescriptorPool"
            (d: vk::Device, i: *const vk::DescriptorPoolCreateInfo<'_>, c: Callbacks<'_>, o: *mut vk::DescriptorPool);
        allocate_descriptor_sets "vkAllocateDescriptorSets"
            (d: vk::Device, i: *const vk::DescriptorSetAllocateInfo<'_>, o: *mut vk::DescriptorSet);
        allocate_command_buffers "vkAllocateCommandBuffers"
            (d: vk::Device, i: *const vk::CommandBufferAllocateInfo<'_>, o: *mut vk::CommandBuffer);
        create_fence "vkCreateFence"
            (d: vk::Device, i: *const vk::FenceCreateInfo<'_>, c: Callbacks<'_>, o: *mut vk::Fence);
        create_query_pool "vkCreateQueryPool"
            (d: vk::Device, i: *const vk::QueryPoolCreateInfo<'_>, c: Callbacks<'_>, o: *mut vk::QueryPool);
        begin_command_buffer "vkBeginCommandBuffer"
            (b: vk::CommandBuffer, i: *const vk::CommandBufferBeginInfo<'_>);
        end_command_buffer "vkEndCommandBuffer" (b: vk::CommandBuffer);
        wait_for_fences "vkWaitForFences"
            (d: vk::Device, count: u32, fences: *const vk::Fence, all: vk::Bool32, timeout: u64);
        get_query_pool_results "vkGetQueryPoolResults"
            (d: vk::Device, pool: vk::QueryPool, first: u32, count: u32, size: usize, data: *mut c_void,
             stride: vk::DeviceSize, flags: vk::QueryResultFlags);
    }
    of 2 {
        queue_submit2 "vkQueueSubmit2"
            (q: vk::Queue, count: u32, i: *const vk::SubmitInfo2<'_>, fence: vk::Fence);
    }
}
