//! A host with its own Vulkan device and image: it clears the image, has a scene drawn over that, and draws something of its
//! own over the scene, all in one command buffer. Writes `embed.png` or the file that is named.

#![allow(unsafe_code, unsafe_op_in_unsafe_fn, reason = "the host calls Vulkan")]

use hypertexture::gpu::ash::{self, vk};
use hypertexture::gpu::{Gpu, HostDevice, HostTarget, optional_features, required_features};
use hypertexture::render::{Renderer, Subject};
use hypertexture::{scene, shader};
use std::error::Error;

const SIZE: [u32; 2] = [320, 240];
/// The scene is linear light; this format encodes it where it is written.
const FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;
const COLOR: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).unwrap_or("embed.png".into());
    // SAFETY: the host keeps the rules of Vulkan, and those of `Gpu::from_raw` and `Gpu::host_commands`.
    let pixels = unsafe { draw()? };
    image::save_buffer(&file, &pixels, SIZE[0], SIZE[1], image::ExtendedColorType::Rgba8)?;
    println!("wrote {file}");
    Ok(())
}

/// The texels of the host's image.
unsafe fn draw() -> Result<Vec<u8>, Box<dyn Error>> {
    // The host's own device.
    let entry = ash::Entry::load()?;
    let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
    let instance = entry.create_instance(&vk::InstanceCreateInfo::default().application_info(&application), None)?;
    let physical = instance.enumerate_physical_devices()?[0];
    let features = optional_features(&instance.get_physical_device_features(physical));
    let mut required = required_features();
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_features(&features)
        .push_next(&mut required);
    let device = instance.create_device(physical, &info, None)?;
    let queue = device.get_device_queue(0, 0);
    let memory = instance.get_physical_device_memory_properties(physical);
    let allocate = |needs: vk::MemoryRequirements, wanted: vk::MemoryPropertyFlags| {
        let fits = |index: &usize| {
            needs.memory_type_bits >> index & 1 == 1 && memory.memory_types[*index].property_flags.contains(wanted)
        };
        let index = (0..memory.memory_type_count as usize).find(fits).unwrap_or_default() as u32;
        let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(index);
        device.allocate_memory(&info, None)
    };

    // The host's own image, and a buffer to read it from.
    let extent = vk::Extent3D { width: SIZE[0], height: SIZE[1], depth: 1 };
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
    let info = vk::ImageCreateInfo::default()
        .image_type(vk::ImageType::TYPE_2D)
        .format(FORMAT)
        .extent(extent)
        .mip_levels(1)
        .array_layers(1)
        .samples(vk::SampleCountFlags::TYPE_1)
        .usage(usage);
    let image = device.create_image(&info, None)?;
    let needs = device.get_image_memory_requirements(image);
    let image_memory = allocate(needs, vk::MemoryPropertyFlags::DEVICE_LOCAL)?;
    device.bind_image_memory(image, image_memory, 0)?;
    let info = vk::ImageViewCreateInfo::default()
        .image(image)
        .view_type(vk::ImageViewType::TYPE_2D)
        .format(FORMAT)
        .subresource_range(COLOR);
    let view = device.create_image_view(&info, None)?;
    let bytes = u64::from(4 * SIZE[0] * SIZE[1]);
    let info = vk::BufferCreateInfo::default().size(bytes).usage(vk::BufferUsageFlags::TRANSFER_DST);
    let buffer = device.create_buffer(&info, None)?;
    let needs = device.get_buffer_memory_requirements(buffer);
    let host_memory = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
    let buffer_memory = allocate(needs, host_memory)?;
    device.bind_buffer_memory(buffer, buffer_memory, 0)?;

    // The renderer, on the host's device.
    let library = shader::shipped();
    let scene = scene::preset("fire_ball")?;
    let subject = Subject::load(&scene, &library, &|_| ())?;
    let host = HostDevice {
        entry: entry.clone(),
        instance: instance.clone(),
        physical_device: physical,
        device: device.clone(),
        features,
        queue,
        queue_family: 0,
    };
    let gpu = Gpu::from_raw(host, None)?;
    let mut renderer = Renderer::new(&gpu, &library, &subject);
    // A host draws something else meanwhile.
    while !renderer.is_recordable(&scene, gpu.host_format(FORMAT)?)? {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }

    // One command buffer: the host clears, the scene is drawn over that, the host draws over the scene.
    let pool = device.create_command_pool(&vk::CommandPoolCreateInfo::default(), None)?;
    let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
    let commands = device.allocate_command_buffers(&info)?[0];
    device.begin_command_buffer(commands, &vk::CommandBufferBeginInfo::default())?;
    let barrier = |old, new, stages: [vk::PipelineStageFlags2; 2], access: [vk::AccessFlags2; 2]| {
        let barriers = [vk::ImageMemoryBarrier2::default()
            .image(image)
            .subresource_range(COLOR)
            .old_layout(old)
            .new_layout(new)
            .src_stage_mask(stages[0])
            .src_access_mask(access[0])
            .dst_stage_mask(stages[1])
            .dst_access_mask(access[1])];
        let dependency = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        device.cmd_pipeline_barrier2(commands, &dependency);
    };
    use vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};
    let output = Stage::COLOR_ATTACHMENT_OUTPUT;
    let (write, blend) =
        (Access::COLOR_ATTACHMENT_WRITE, Access::COLOR_ATTACHMENT_WRITE | Access::COLOR_ATTACHMENT_READ);
    let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width: SIZE[0], height: SIZE[1] } };
    let fill = |load, color: [f32; 4], rects: &[vk::ClearRect]| {
        let value = |float32| vk::ClearValue { color: vk::ClearColorValue { float32 } };
        let attachments = [vk::RenderingAttachmentInfo::default()
            .image_view(view)
            .image_layout(Layout::COLOR_ATTACHMENT_OPTIMAL)
            .load_op(load)
            .store_op(vk::AttachmentStoreOp::STORE)
            .clear_value(value(color))];
        let info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&attachments);
        let clear = vk::ClearAttachment {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            color_attachment: 0,
            clear_value: value(color),
        };
        device.cmd_begin_rendering(commands, &info);
        if !rects.is_empty() {
            device.cmd_clear_attachments(commands, &[clear], rects);
        }
        device.cmd_end_rendering(commands);
    };
    let again = || {
        let both = Layout::COLOR_ATTACHMENT_OPTIMAL;
        barrier(both, both, [output; 2], [write, blend]);
    };
    barrier(Layout::UNDEFINED, Layout::COLOR_ATTACHMENT_OPTIMAL, [Stage::NONE, output], [Access::NONE, blend]);
    fill(vk::AttachmentLoadOp::CLEAR, [0.02, 0.05, 0.12, 1.0], &[]);
    again();
    let target = HostTarget { view, format: FORMAT, size: SIZE };
    let recording = renderer.record(&mut gpu.host_commands(commands, target)?, &scene)?;
    again();
    let rect = |x, y, width, height| vk::ClearRect {
        rect: vk::Rect2D { offset: vk::Offset2D { x, y }, extent: vk::Extent2D { width, height } },
        base_array_layer: 0,
        layer_count: 1,
    };
    let bars = [rect(0, 0, SIZE[0], 12), rect(0, SIZE[1] as i32 - 12, SIZE[0], 12)];
    fill(vk::AttachmentLoadOp::LOAD, [0.6, 0.6, 0.6, 1.0], &bars);
    let (copy, read) = (Stage::COPY, Access::TRANSFER_READ);
    barrier(Layout::COLOR_ATTACHMENT_OPTIMAL, Layout::TRANSFER_SRC_OPTIMAL, [output, copy], [write, read]);
    let layers = vk::ImageSubresourceLayers { aspect_mask: COLOR.aspect_mask, layer_count: 1, ..Default::default() };
    let region = vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent);
    let visible = [vk::MemoryBarrier2::default()
        .src_stage_mask(copy)
        .src_access_mask(Access::TRANSFER_WRITE)
        .dst_stage_mask(Stage::HOST)
        .dst_access_mask(Access::HOST_READ)];
    device.cmd_copy_image_to_buffer(commands, image, Layout::TRANSFER_SRC_OPTIMAL, buffer, &[region]);
    device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().memory_barriers(&visible));
    device.end_command_buffer(commands)?;
    let buffers = [commands];
    device.queue_submit(queue, &[vk::SubmitInfo::default().command_buffers(&buffers)], vk::Fence::null())?;
    device.queue_wait_idle(queue)?;

    // Drop resources of the commands first, then those of the renderer, then the host's.
    drop(recording);
    drop(renderer);
    drop(gpu);
    let mapped = device.map_memory(buffer_memory, 0, bytes, vk::MemoryMapFlags::empty())?;
    let pixels = std::slice::from_raw_parts(mapped.cast::<u8>(), bytes as usize).to_vec();
    device.destroy_command_pool(pool, None);
    device.destroy_buffer(buffer, None);
    device.free_memory(buffer_memory, None);
    device.destroy_image_view(view, None);
    device.destroy_image(image, None);
    device.free_memory(image_memory, None);
    device.destroy_device(None);
    instance.destroy_instance(None);
    Ok(pixels)
}
