//! Planted bugs: the proof that the gate of validation messages is alive.
//!
//! Every test of the GPU fails on a message of the validation layer. That means something only if the layer really
//! says something, and if what it says arrives: each bug here must be reported under its own id, and nothing else.

use super::format::COLOR;
use super::*;
use ash::vk;
use hypertexture_glsl::{Library, Linker, Slots, Stage};
use hypertexture_support::validation_lock::ValidationLock;
use std::sync::Arc;

const SIDE: u32 = 8;
const BYTES: usize = (SIDE * SIDE * 4) as usize;

/// Runs `plant` on a device with validation, closes the device, and returns the distinct ids of what was reported.
fn reported(plant: impl FnOnce(&Gpu)) -> Vec<String> {
    let _lock = ValidationLock::acquire();
    let options = Options { validation: true, ..Options::from_env() };
    let gpu = Gpu::new(&options).unwrap_or_else(|error| panic!("{error}"));
    let messages = gpu.messages();
    plant(&gpu);
    drop(gpu);
    let id = |message: &String| message.split(": ").next().unwrap_or_default().to_string();
    let mut ids: Vec<String> = messages.take().iter().map(id).collect();
    ids.sort();
    ids.dedup();
    ids
}

fn upload_buffer(gpu: &Gpu) -> Buffer {
    Buffer::new(gpu, "texels", BufferUse::Upload, &[7; BYTES]).unwrap()
}

fn plane(gpu: &Gpu, purpose: ImageUse) -> Image {
    Image::new(gpu, "plane", Dimension::Plane(SIDE, SIDE), Format::Rgba8Unorm, purpose).unwrap()
}

/// All of the plane.
fn region() -> vk::BufferImageCopy {
    let subresource = vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
    let extent = vk::Extent3D { width: SIDE, height: SIDE, depth: 1 };
    vk::BufferImageCopy::default().image_subresource(subresource).image_extent(extent)
}

/// A layout transition with these scopes.
fn transition(
    gpu: &Gpu,
    commands: &Commands<'_>,
    image: &Image,
    [from, to]: [vk::ImageLayout; 2],
    after: (vk::PipelineStageFlags2, vk::AccessFlags2),
    before: (vk::PipelineStageFlags2, vk::AccessFlags2),
) {
    let barriers = [vk::ImageMemoryBarrier2::default()
        .image(image.handle)
        .subresource_range(COLOR)
        .old_layout(from)
        .new_layout(to)
        .src_stage_mask(after.0)
        .src_access_mask(after.1)
        .dst_stage_mask(before.0)
        .dst_access_mask(before.1)];
    let dependency = vk::DependencyInfo::default().image_memory_barriers(&barriers);
    // SAFETY: the command buffer is being recorded, and the image outlives its submission.
    unsafe { gpu.0.device.cmd_pipeline_barrier2(commands.buffer, &dependency) };
}

/// A program that covers the target with the texel of a sampled image.
fn sampling_pipeline(gpu: &Gpu, attributes: &[u32]) -> Pipeline {
    let compile = |text: &str, stage| {
        let library = Library::new([("planted".into(), text.into())]);
        Linker::new().unwrap().link(&library, "planted", stage, &["planted"], &Slots::new()).unwrap()
    };
    let position = match attributes {
        [] => "vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 4.0 - 1.0",
        _ => "corner",
    };
    let input = if attributes.is_empty() { "" } else { "layout(location = 0) in vec2 corner;" };
    let vertex = format!("#version 450\n{input}\nvoid main() {{ gl_Position = vec4({position}, 0.0, 1.0); }}");
    let fragment = "#version 450
        layout(set = 0, binding = 0) uniform texture2D image;
        layout(set = 0, binding = 1) uniform sampler linear;
        layout(location = 0) out vec4 color;
        void main() { color = texture(sampler2D(image, linear), vec2(0.5)); }";
    let binding = |index, kind| Binding { index, kind, vertex: false, fragment: true };
    let description = PipelineDescription {
        vertex: &compile(&vertex, Stage::Vertex),
        fragment: &compile(fragment, Stage::Fragment),
        constants: &[],
        bindings: &[binding(0, BindingKind::Image), binding(1, BindingKind::Sampler)],
        attributes,
        format: Format::Rgba8Unorm,
        samples: 1,
        blend: Blend::Replace,
        marks: super::Marks::None,
        covered: true,
    };
    Pipeline::new(gpu, &description).unwrap()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_correct_frame_is_not_reported() {
    let ids = reported(|gpu| {
        let image =
            Image::sampled(gpu, "texels", Dimension::Plane(SIDE, SIDE), Format::Rgba8Unorm, &[7; BYTES]).unwrap();
        let image = Arc::new(image);
        let sampler = Arc::new(Sampler::new(gpu, Address::Clamp, 1.0).unwrap());
        let pipeline = sampling_pipeline(gpu, &[]);
        let set =
            pipeline.bind(&[(0, Resource::Image(image.clone())), (1, Resource::Sampler(sampler.clone()))]).unwrap();
        let color = plane(gpu, ImageUse::Target(1));
        let target = Target::of(&color);
        gpu.submit("draw", |commands| {
            commands.render(target, Load::Clear([0.0; 4]), |draw| draw.triangles(&pipeline, &set, None, 0..3));
            commands.render(target, Load::Keep, |draw| draw.triangles(&pipeline, &set, None, 0..3));
        })
        .unwrap();
        assert_eq!(color.read().unwrap(), [[7.0 / 255.0; 4]; (SIDE * SIDE) as usize]);
    });
    assert!(ids.is_empty(), "{ids:?}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_read_without_a_barrier_after_a_copy_is_reported() {
    use vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};
    let ids = reported(|gpu| {
        let (texels, image) = (upload_buffer(gpu), Arc::new(plane(gpu, ImageUse::Sampled)));
        let sampler = Arc::new(Sampler::new(gpu, Address::Clamp, 1.0).unwrap());
        let pipeline = sampling_pipeline(gpu, &[]);
        let set =
            pipeline.bind(&[(0, Resource::Image(image.clone())), (1, Resource::Sampler(sampler.clone()))]).unwrap();
        let color = plane(gpu, ImageUse::Target(1));
        gpu.submit("planted", |commands| {
            let writable = [Layout::UNDEFINED, Layout::TRANSFER_DST_OPTIMAL];
            let copied = (Stage::COPY, Access::TRANSFER_WRITE);
            transition(gpu, commands, &image, writable, (Stage::NONE, Access::NONE), copied);
            // SAFETY: the buffer holds the texels of the image, and both outlive the submission.
            unsafe {
                let layout = Layout::TRANSFER_DST_OPTIMAL;
                let device = &gpu.0.device;
                device.cmd_copy_buffer_to_image(commands.buffer, texels.handle, image.handle, layout, &[region()]);
            }
            // The bug: the vertex stage waits for the copy, and the fragment stage reads.
            let sampled = [Layout::TRANSFER_DST_OPTIMAL, Layout::SHADER_READ_ONLY_OPTIMAL];
            transition(gpu, commands, &image, sampled, copied, (Stage::VERTEX_SHADER, Access::SHADER_SAMPLED_READ));
            let target = Target::of(&color);
            commands.render(target, Load::Clear([0.0; 4]), |draw| draw.triangles(&pipeline, &set, None, 0..3));
        })
        .unwrap();
    });
    assert_eq!(ids, ["SYNC-HAZARD-READ-AFTER-WRITE"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn two_copies_into_one_buffer_without_a_barrier_are_reported() {
    let ids = reported(|gpu| {
        let color = plane(gpu, ImageUse::Target(1));
        let buffer = Buffer::empty(gpu, "download", BufferUse::Download, BYTES as u64).unwrap();
        gpu.submit("planted", |commands| {
            commands.render(Target::of(&color), Load::Clear([0.0; 4]), |_| ());
            commands.download(&color, &[Area::whole([4, 4])], &buffer);
            // SAFETY: the image is in the layout named, and buffer and image outlive the submission.
            unsafe {
                let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
                let device = &gpu.0.device;
                device.cmd_copy_image_to_buffer(commands.buffer, color.handle, layout, buffer.handle, &[region()]);
            }
        })
        .unwrap();
    });
    assert_eq!(ids, ["SYNC-HAZARD-WRITE-AFTER-WRITE"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_image_in_another_layout_than_the_one_named_is_reported() {
    let ids = reported(|gpu| {
        let texels = upload_buffer(gpu);
        let image = plane(gpu, ImageUse::Sampled);
        gpu.submit("planted", |commands| {
            commands.upload(&texels, &image);
            use vk::{AccessFlags2 as Access, PipelineStageFlags2 as Stage};
            let visible = [vk::MemoryBarrier2::default()
                .src_stage_mask(Stage::ALL_COMMANDS)
                .src_access_mask(Access::MEMORY_WRITE)
                .dst_stage_mask(Stage::ALL_COMMANDS)
                .dst_access_mask(Access::MEMORY_READ | Access::MEMORY_WRITE)];
            let dependency = vk::DependencyInfo::default().memory_barriers(&visible);
            // SAFETY: buffer and image outlive the submission. The bug: the image is ready to be sampled.
            unsafe {
                let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
                let device = &gpu.0.device;
                device.cmd_pipeline_barrier2(commands.buffer, &dependency);
                device.cmd_copy_buffer_to_image(commands.buffer, texels.handle, image.handle, layout, &[region()]);
            }
        })
        .unwrap();
    });
    assert_eq!(ids, ["VUID-vkCmdCopyBufferToImage-dstImageLayout-00180"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_buffer_used_for_what_it_was_not_made_for_is_reported() {
    let ids = reported(|gpu| {
        let vertices = Buffer::new(gpu, "vertices", BufferUse::Vertices, &[7; BYTES]).unwrap();
        let image = plane(gpu, ImageUse::Sampled);
        gpu.submit("planted", |commands| commands.upload(&vertices, &image)).unwrap();
    });
    assert_eq!(ids, ["VUID-vkCmdCopyBufferToImage-srcBuffer-00174"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_draw_without_its_vertices_is_reported() {
    let ids = reported(|gpu| {
        let image =
            Image::sampled(gpu, "texels", Dimension::Plane(SIDE, SIDE), Format::Rgba8Unorm, &[7; BYTES]).unwrap();
        let image = Arc::new(image);
        let sampler = Arc::new(Sampler::new(gpu, Address::Clamp, 1.0).unwrap());
        let pipeline = sampling_pipeline(gpu, &[2]);
        let set =
            pipeline.bind(&[(0, Resource::Image(image.clone())), (1, Resource::Sampler(sampler.clone()))]).unwrap();
        let color = plane(gpu, ImageUse::Target(1));
        let target = Target::of(&color);
        gpu.submit("planted", |commands| {
            commands.render(target, Load::Clear([0.0; 4]), |draw| draw.triangles(&pipeline, &set, None, 0..3));
        })
        .unwrap();
    });
    // No buffer is bound; older layers also say that no vertex lies inside one, as 02721.
    let known = ["VUID-vkCmdDraw-None-02721", "VUID-vkCmdDraw-None-04007"];
    assert!(ids == known || ids == known[1..], "{ids:?}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn objects_that_outlive_their_device_are_reported() {
    let ids = reported(|gpu| {
        // SAFETY: the device is alive. The bug: nothing destroys the fence.
        unsafe { gpu.0.device.create_fence(&vk::FenceCreateInfo::default(), None) }.unwrap();
    });
    let known = ["VUID-vkDestroyDevice-device-00378", "VUID-vkDestroyDevice-device-05137"]; // of Vulkan before 1.4, and since
    assert!(ids.len() == 1 && known.contains(&ids[0].as_str()), "{ids:?}");
}
