//! A host without this library: the files of `export`, drawn by plain Vulkan.
#![expect(unsafe_code, unsafe_op_in_unsafe_fn, reason = "the host has a device of its own")]

use crate::common::{picture, subject, with_gpu};
use ash::{Device, Entry, Instance, vk};
use hypertexture::render::Portable;
use hypertexture::scene::preset;
use hypertexture::shader::shipped;
use hypertexture_export::folder;
use serde_json::Value;
use std::collections::HashMap;
use std::slice::from_ref;

const SIDE: u32 = 48;
const TARGET: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// A device and its queue. It stays until the process ends.
struct Host {
    device: Device,
    memory: vk::PhysicalDeviceMemoryProperties,
    queue: vk::Queue,
    _instance: (Entry, Instance),
}

impl Host {
    /// Opens the device of this name.
    unsafe fn open(name: &str) -> Host {
        let entry = Entry::load().unwrap();
        let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let info = vk::InstanceCreateInfo::default().application_info(&application);
        let instance = entry.create_instance(&info, None).unwrap();
        let is_named = |device: &vk::PhysicalDevice| {
            let properties = instance.get_physical_device_properties(*device);
            properties.device_name_as_c_str().unwrap().to_str() == Ok(name)
        };
        let physical = instance.enumerate_physical_devices().unwrap().into_iter().find(is_named).unwrap();
        let queues = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
        let mut dynamic = vk::PhysicalDeviceVulkan13Features::default().dynamic_rendering(true);
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).push_next(&mut dynamic);
        let device = instance.create_device(physical, &info, None).unwrap();
        let memory = instance.get_physical_device_memory_properties(physical);
        let queue = device.get_device_queue(0, 0);
        Host { device, memory, queue, _instance: (entry, instance) }
    }

    unsafe fn memory(&self, needs: vk::MemoryRequirements, is_mapped: bool) -> vk::DeviceMemory {
        let mapped = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let flags = if is_mapped { mapped } else { vk::MemoryPropertyFlags::DEVICE_LOCAL };
        let fits = |&index: &u32| {
            needs.memory_type_bits >> index & 1 == 1
                && self.memory.memory_types[index as usize].property_flags.contains(flags)
        };
        let index = (0..self.memory.memory_type_count).find(fits).unwrap();
        let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(index);
        self.device.allocate_memory(&info, None).unwrap()
    }

    /// A buffer that holds these bytes, and its memory.
    unsafe fn buffer(&self, usage: vk::BufferUsageFlags, bytes: &[u8]) -> (vk::Buffer, *mut u8) {
        let info = vk::BufferCreateInfo::default().size(bytes.len() as u64).usage(usage);
        let buffer = self.device.create_buffer(&info, None).unwrap();
        let memory = self.memory(self.device.get_buffer_memory_requirements(buffer), true);
        self.device.bind_buffer_memory(buffer, memory, 0).unwrap();
        let mapped = self.device.map_memory(memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty()).unwrap().cast();
        std::ptr::copy_nonoverlapping(bytes.as_ptr(), mapped, bytes.len());
        (buffer, mapped)
    }

    unsafe fn image(&self, info: vk::ImageCreateInfo<'_>) -> (vk::Image, vk::ImageView) {
        let info = info.array_layers(1).samples(vk::SampleCountFlags::TYPE_1);
        let view = match info.image_type {
            vk::ImageType::TYPE_1D => vk::ImageViewType::TYPE_1D,
            vk::ImageType::TYPE_2D => vk::ImageViewType::TYPE_2D,
            _ => vk::ImageViewType::TYPE_3D,
        };
        let image = self.device.create_image(&info, None).unwrap();
        let memory = self.memory(self.device.get_image_memory_requirements(image), false);
        self.device.bind_image_memory(image, memory, 0).unwrap();
        let view = vk::ImageViewCreateInfo::default().image(image).view_type(view).format(info.format);
        (image, self.device.create_image_view(&view.subresource_range(COLOR), None).unwrap())
    }

    /// Moves an image to the layout of its next use.
    unsafe fn ready(&self, commands: vk::CommandBuffer, image: vk::Image, layout: vk::ImageLayout) {
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        let access = vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE;
        let barrier = vk::ImageMemoryBarrier::default().image(image).subresource_range(COLOR).new_layout(layout);
        let old = match layout {
            vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL => vk::ImageLayout::TRANSFER_DST_OPTIMAL,
            vk::ImageLayout::TRANSFER_SRC_OPTIMAL => vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
            _ => vk::ImageLayout::UNDEFINED,
        };
        let barrier = barrier.old_layout(old).src_access_mask(access).dst_access_mask(access);
        self.device.cmd_pipeline_barrier(commands, all, all, Default::default(), &[], &[], from_ref(&barrier))
    }
}

const COLOR: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: vk::REMAINING_MIP_LEVELS,
    base_array_layer: 0,
    layer_count: 1,
};

fn number(value: &Value) -> u32 {
    value.as_u64().unwrap() as u32
}

fn all(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().unwrap().iter()
}

/// Draws the picture of the files on the device of this name.
unsafe fn draw(files: &HashMap<String, Vec<u8>>, device: &str) -> Vec<f32> {
    let scene: Value = serde_json::from_slice(&files["scene.json"]).unwrap();
    let program = &scene["programs"][0];
    let host = Host::open(device);
    let Host { device, queue, .. } = &host;
    let stage = vk::ShaderStageFlags::FRAGMENT;
    let layout = |own: &Value, kind| {
        let binding = vk::DescriptorSetLayoutBinding::default().binding(number(&own["binding"]));
        binding.descriptor_type(kind).descriptor_count(1).stage_flags(stage)
    };
    let kinds = [
        ("blocks", vk::DescriptorType::UNIFORM_BUFFER),
        ("images", vk::DescriptorType::SAMPLED_IMAGE),
        ("samplers", vk::DescriptorType::SAMPLER),
    ];
    let bindings: Vec<_> =
        kinds.iter().flat_map(|(name, kind)| all(&program[*name]).map(|own| layout(own, *kind))).collect();
    let info = vk::CommandPoolCreateInfo::default();
    let pool = device.create_command_pool(&info, None).unwrap();
    let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
    let commands = device.allocate_command_buffers(&info).unwrap()[0];
    device.begin_command_buffer(commands, &Default::default()).unwrap();

    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    let set_layout = device.create_descriptor_set_layout(&info, None).unwrap();
    let sizes = kinds.map(|(_, kind)| vk::DescriptorPoolSize { ty: kind, descriptor_count: 64 });
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
    let pool = device.create_descriptor_pool(&info, None).unwrap();
    let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(from_ref(&set_layout));
    let set = device.allocate_descriptor_sets(&info).unwrap()[0];
    let write = |own: &Value| vk::WriteDescriptorSet::default().dst_set(set).dst_binding(number(&own["binding"]));

    for block in all(&program["blocks"]) {
        let mut bytes = vec![0; number(&block["bytes"]) as usize];
        for member in all(&block["members"]) {
            let offset = number(&member["offset"]) as usize;
            let values = all(&scene["values"][member["name"].as_str().unwrap()]);
            let values: Vec<u8> = values.flat_map(|own| (own.as_f64().unwrap() as f32).to_le_bytes()).collect();
            bytes[offset..offset + values.len()].copy_from_slice(&values);
        }
        let (buffer, _) = host.buffer(vk::BufferUsageFlags::UNIFORM_BUFFER, &bytes);
        let info = vk::DescriptorBufferInfo { buffer, offset: 0, range: vk::WHOLE_SIZE };
        let write = write(block).descriptor_type(kinds[0].1).buffer_info(from_ref(&info));
        device.update_descriptor_sets(&[write], &[]);
    }
    for own in all(&scene["images"]) {
        let (format, texel) = match own["format"].as_str().unwrap() {
            "r8unorm" => (vk::Format::R8_UNORM, 1),
            "r16unorm" => (vk::Format::R16_UNORM, 2),
            "r32float" => (vk::Format::R32_SFLOAT, 4),
            "rgba8unorm" => (vk::Format::R8G8B8A8_UNORM, 4),
            "rgba16unorm" => (vk::Format::R16G16B16A16_UNORM, 8),
            other => panic!("{other}"),
        };
        let [width, height, depth] = [0, 1, 2].map(|axis| number(&own["size"][axis]));
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let kind = vk::ImageType::from_raw(number(&own["axes"]) as i32 - 1);
        let info = vk::ImageCreateInfo::default().image_type(kind).format(format).usage(usage);
        let info = info.extent(vk::Extent3D { width, height, depth }).mip_levels(number(&own["levels"]));
        let (image, view) = host.image(info);
        let (buffer, _) = host.buffer(vk::BufferUsageFlags::TRANSFER_SRC, &files[own["file"].as_str().unwrap()]);
        host.ready(commands, image, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        let mut offset = 0;
        for level in 0..number(&own["levels"]) {
            let [width, height, depth] = [width, height, depth].map(|side| (side >> level).max(1));
            let region =
                vk::BufferImageCopy::default().buffer_offset(offset).image_subresource(vk::ImageSubresourceLayers {
                    mip_level: level,
                    aspect_mask: COLOR.aspect_mask,
                    base_array_layer: 0,
                    layer_count: 1,
                });
            offset += u64::from(width * height * depth) * texel;
            let region = region.image_extent(vk::Extent3D { width, height, depth });
            let to = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
            device.cmd_copy_buffer_to_image(commands, buffer, image, to, &[region]);
        }
        let image_layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        host.ready(commands, image, image_layout);
        let info = vk::DescriptorImageInfo { image_view: view, image_layout, sampler: vk::Sampler::null() };
        let write = write(own).descriptor_type(kinds[1].1).image_info(from_ref(&info));
        device.update_descriptor_sets(&[write], &[]);
    }
    for own in all(&scene["samplers"]) {
        let address = match own["address"].as_str().unwrap() {
            "repeat" => vk::SamplerAddressMode::REPEAT,
            "mirror-repeat" => vk::SamplerAddressMode::MIRRORED_REPEAT,
            _ => vk::SamplerAddressMode::CLAMP_TO_EDGE,
        };
        let linear = vk::Filter::LINEAR;
        let info = vk::SamplerCreateInfo::default().mag_filter(linear).min_filter(linear).max_lod(vk::LOD_CLAMP_NONE);
        let info = info.mipmap_mode(vk::SamplerMipmapMode::LINEAR);
        let info = info.address_mode_u(address).address_mode_v(address).address_mode_w(address);
        let sampler = device.create_sampler(&info, None).unwrap();
        let info = vk::DescriptorImageInfo { sampler, ..Default::default() };
        let write = write(own).descriptor_type(kinds[2].1).image_info(from_ref(&info));
        device.update_descriptor_sets(&[write], &[]);
    }

    let (width, height) = (SIDE, SIDE);
    let extent = vk::Extent3D { width, height, depth: 1 };
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
    let info = vk::ImageCreateInfo::default().image_type(vk::ImageType::TYPE_2D).format(TARGET).usage(usage);
    let (target, view) = host.image(info.extent(extent).mip_levels(1));
    let module = |file: &str| {
        let words: Vec<u32> = files[file].as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
        device.create_shader_module(&vk::ShaderModuleCreateInfo::default().code(&words), None).unwrap()
    };
    let entry = |stage, file: &str| {
        let info = vk::PipelineShaderStageCreateInfo::default().stage(stage).name(c"main");
        info.module(module(file))
    };
    let stages = [entry(vk::ShaderStageFlags::VERTEX, "screen.spv"), entry(stage, program["spirv"].as_str().unwrap())];
    let info = vk::PipelineLayoutCreateInfo::default().set_layouts(from_ref(&set_layout));
    let layout = device.create_pipeline_layout(&info, None).unwrap();
    let viewport = vk::Viewport { width: SIDE as f32, height: SIDE as f32, max_depth: 1.0, ..Default::default() };
    let area = vk::Rect2D { extent: vk::Extent2D { width, height }, ..Default::default() };
    let viewports = vk::PipelineViewportStateCreateInfo::default();
    let viewports = viewports.viewports(from_ref(&viewport)).scissors(from_ref(&area));
    let samples = vk::PipelineMultisampleStateCreateInfo::default();
    let samples = samples.rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let blend = [vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA)];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blend);
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default();
    let assembly = assembly.topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let (raster, vertices) = (vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0), Default::default());
    let mut rendering = vk::PipelineRenderingCreateInfo::default().color_attachment_formats(from_ref(&TARGET));
    let info = vk::GraphicsPipelineCreateInfo::default().stages(&stages).layout(layout).push_next(&mut rendering);
    let info = info.viewport_state(&viewports).multisample_state(&samples).color_blend_state(&blend);
    let info = info.input_assembly_state(&assembly).rasterization_state(&raster).vertex_input_state(&vertices);
    let pipeline = device.create_graphics_pipelines(vk::PipelineCache::null(), &[info], None).unwrap()[0];

    let attachment = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
    host.ready(commands, target, attachment);
    let color = vk::RenderingAttachmentInfo::default().image_view(view).image_layout(attachment);
    let color = [color.load_op(vk::AttachmentLoadOp::CLEAR).store_op(vk::AttachmentStoreOp::STORE)];
    let info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&color);
    device.cmd_begin_rendering(commands, &info);
    let graphics = vk::PipelineBindPoint::GRAPHICS;
    device.cmd_bind_pipeline(commands, graphics, pipeline);
    device.cmd_bind_descriptor_sets(commands, graphics, layout, 0, &[set], &[]);
    device.cmd_draw(commands, 3, 1, 0, 0);
    device.cmd_end_rendering(commands);
    host.ready(commands, target, vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
    let bytes = (16 * width * height) as usize;
    let (buffer, mapped) = host.buffer(vk::BufferUsageFlags::TRANSFER_DST, &vec![0; bytes]);
    let layers = vk::ImageSubresourceLayers { aspect_mask: COLOR.aspect_mask, layer_count: 1, ..Default::default() };
    let region = vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent);
    let from = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
    device.cmd_copy_image_to_buffer(commands, target, from, buffer, &[region]);
    device.end_command_buffer(commands).unwrap();
    let info = vk::SubmitInfo::default().command_buffers(from_ref(&commands));
    device.queue_submit(*queue, &[info], vk::Fence::null()).unwrap();
    device.queue_wait_idle(*queue).unwrap();
    let floats = std::slice::from_raw_parts(mapped, bytes).as_chunks().0;
    floats.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn plain_vulkan_draws_an_export_as_render_does() {
    for name in ["fire_ball", "bump", "noisy_sphere"] {
        let mut scene = preset(name).unwrap();
        (scene.image.size, scene.object.resolution) = ([SIDE; 2], 32);
        (scene.light.shadows, scene.quality.supersampling) = (false, 1);
        let (library, subject) = (shipped(), subject(&scene, &shipped()));
        let portable = Portable::of(&library, &scene, &subject, &|_| ()).unwrap();
        let files: HashMap<_, _> = folder(&portable, "").unwrap().into_iter().collect();
        with_gpu(|gpu| {
            let expected = picture(gpu, &library, &scene, &subject);
            // SAFETY: the calls and their order are those of the specification, and nothing is freed.
            let drawn = unsafe { draw(&files, &gpu.info().name) };
            let pairs = drawn.iter().zip(expected.pixels.as_flattened());
            let worst = pairs.map(|(drawn, expected)| (drawn - expected).abs()).fold(0.0, f32::max);
            let opaque = expected.pixels.iter().filter(|pixel| pixel[3] > 0.5).count();
            println!("{name}: {worst:e}");
            assert!(worst < 2e-3 && opaque > 300, "{name}: {worst}, {opaque} opaque pixels");
        });
    }
}
