//! A host's own device, and pictures in its own command buffers.

use super::device::{Device, Opened, device_info};
use super::instance::Instance;
use super::{BindSet, Buffer, Commands, Format, Gpu, GpuError, Pipeline};
use ash::vk;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// The device of another program: of Vulkan 1.3, with [`required_features`](super::required_features).
pub struct HostDevice {
    /// The loader.
    pub entry: ash::Entry,
    /// The instance.
    pub instance: ash::Instance,
    /// The physical device.
    pub physical_device: vk::PhysicalDevice,
    /// The device.
    pub device: ash::Device,
    /// Its features that are enabled, such as [`optional_features`](super::optional_features).
    pub features: vk::PhysicalDeviceFeatures,
    /// A queue with graphics.
    pub queue: vk::Queue,
    /// The family of the queue.
    pub queue_family: u32,
}

impl Gpu {
    /// A device of another program, which stays its own. Compiled pipelines are kept in the folder `cache`.
    ///
    /// # Errors
    /// No memory left.
    ///
    /// # Safety
    /// - The handles belong together and are alive until all that was made from the [`Gpu`] is dropped, and the `Gpu` itself;
    /// - the device has [`required_features`](super::required_features) and the `features` named enabled;
    /// - nobody else uses the queue while a call of this crate runs that submits: each that takes a `Gpu`, a renderer's too.
    pub unsafe fn from_raw(host: HostDevice, cache: Option<&Path>) -> Result<Gpu, GpuError> {
        let mut info = device_info(&host.instance, host.physical_device, &host.features);
        // SAFETY: the physical device belongs to the instance, as the caller says.
        let families = unsafe { host.instance.get_physical_device_queue_family_properties(host.physical_device) };
        if families.get(host.queue_family as usize).is_none_or(|family| family.timestamp_valid_bits == 0) {
            info.timestamp_period = 0.0;
        }
        let instance = Instance::of_host(host.entry, host.instance);
        let device = Device { raw: host.device, hosted: true };
        let HostDevice { physical_device: physical, queue, queue_family: family, .. } = host;
        Gpu::with_device(Opened { instance, physical, info, device, queue, family }, cache)
    }

    /// A command buffer of a host, to record a picture into.
    ///
    /// # Errors
    /// The image has a format that is none of [`Format`], or one that cannot be blended into.
    ///
    /// # Safety
    /// - The command buffer belongs to this device and to the family of its queue, and is being recorded outside of a rendering;
    /// - the image behind the view is a color attachment with one sample, in `COLOR_ATTACHMENT_OPTIMAL` layout, and what was
    ///   written before is visible to reads and writes of color attachments; it stays in that layout;
    /// - what a recording returns is dropped after the commands have been executed, and before the device goes.
    pub unsafe fn host_commands(
        &self,
        buffer: vk::CommandBuffer,
        target: HostTarget,
    ) -> Result<HostCommands<'_>, GpuError> {
        let format = Format::HOST.into_iter().find(|format| format.vk() == target.format);
        let format = format.filter(|&format| self.can_blend(format)).ok_or_else(|| GpuError::Unsupported {
            device: self.info().name.clone(),
            what: format!("blending into {:?}", target.format),
            remedy: format!("use an image of {:?}", Format::HOST.map(Format::vk)),
        })?;
        Ok(HostCommands { commands: Commands { gpu: self, buffer }, target, format })
    }
}

impl Format {
    /// What a host's image may be of.
    const HOST: [Format; 6] = [
        Format::Rgba8Srgb,
        Format::Bgra8Srgb,
        Format::Rgba8Unorm,
        Format::Bgra8Unorm,
        Format::Rgba16Float,
        Format::Rgba32Float,
    ];
}

/// An image of a host that is drawn into. What is written is linear: formats that encode sRGB show it as it is.
#[derive(Clone, Copy, Debug)]
pub struct HostTarget {
    /// A view of all of it.
    pub view: vk::ImageView,
    /// Its format.
    pub format: vk::Format,
    /// Width and height in pixels.
    pub size: [u32; 2],
}

/// A host's command buffer and the image to draw into: [`Gpu::host_commands`].
pub struct HostCommands<'a> {
    commands: Commands<'a>,
    target: HostTarget,
    format: Format,
}

impl HostCommands<'_> {
    /// Width and height of the image in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.target.size
    }

    /// Format of the image.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Draws triangles over what is in the image: a range of the vertices, or of none where the program makes its own.
    pub fn draw(
        &mut self,
        pipeline: &Arc<Pipeline>,
        set: BindSet,
        buffer: Option<Buffer>,
        vertices: Range<u32>,
    ) -> Recording {
        let attachment = vk::RenderingAttachmentInfo::default()
            .image_view(self.target.view)
            .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::LOAD)
            .store_op(vk::AttachmentStoreOp::STORE);
        let [width, height] = self.target.size;
        self.commands.draw_into(Some(attachment), None, vk::Extent2D { width, height }, |draw| {
            draw.triangles(pipeline, &set, buffer.as_ref(), vertices);
        });
        Recording { _pipeline: pipeline.clone(), _set: set, _vertices: buffer }
    }
}

/// What recorded commands use: the host drops it when they have been executed.
#[must_use = "what the commands use must stay until they have been executed"]
pub struct Recording {
    _pipeline: Arc<Pipeline>,
    _set: BindSet,
    _vertices: Option<Buffer>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Alone, Dimension, Image, ImageUse, Load, Options, Target};
    use crate::render::{Renderer, Subject, render};
    use crate::scene::{Order, Pass, preset};
    use crate::shader;

    const SIZE: [u32; 2] = [48, 40];
    const BEHIND: [f32; 4] = [0.1, 0.3, 0.2, 1.0];

    /// What a host sees of a picture that is recorded over a color.
    fn recorded(own: &Gpu, gpu: &Gpu, renderer: &mut Renderer, scene: &crate::scene::Scene) -> Vec<[f32; 4]> {
        use vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};
        let [width, height] = SIZE;
        let format = Format::Rgba32Float;
        let image = Image::new(gpu, "host", Dimension::Plane(width, height), format, ImageUse::Target(1)).unwrap();
        let device = &own.0.device;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(own.0.pool.handle).command_buffer_count(1);
        // SAFETY: the test is the only user of the device, and waits for what it submits.
        unsafe {
            let buffer = device.allocate_command_buffers(&info).unwrap()[0];
            device.begin_command_buffer(buffer, &vk::CommandBufferBeginInfo::default()).unwrap();
            let mut commands = Commands { gpu, buffer };
            commands.render(Target::of(&image), Load::Clear(BEHIND), |_| ());
            let (output, write) = (Stage::COLOR_ATTACHMENT_OUTPUT, Access::COLOR_ATTACHMENT_WRITE);
            let blend = write | Access::COLOR_ATTACHMENT_READ;
            commands.transition(&image, Layout::COLOR_ATTACHMENT_OPTIMAL, output, write, output, blend);
            let target = HostTarget { view: image.view, format: format.vk(), size: SIZE };
            let recording = renderer.record(&mut gpu.host_commands(buffer, target).unwrap(), scene).unwrap();
            device.end_command_buffer(buffer).unwrap();
            let buffers = [buffer];
            let submits = [vk::SubmitInfo::default().command_buffers(&buffers)];
            let queue = own.queue();
            device.queue_submit(*queue, &submits, vk::Fence::null()).unwrap();
            device.queue_wait_idle(*queue).unwrap();
            drop(recording);
            device.free_command_buffers(own.0.pool.handle, &buffers);
        }
        image.read().unwrap()
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn a_recorded_picture_is_that_of_render_over_what_the_host_has_drawn() {
        let _alone = Alone::new();
        let own = Gpu::new(&Options { validation: true, ..Options::of_tests() }).unwrap();
        let messages = own.messages();
        let host = HostDevice {
            entry: own.0.instance.entry.clone(),
            instance: own.0.instance.raw.clone(),
            physical_device: own.0.physical,
            device: own.0.device.raw.clone(),
            features: vk::PhysicalDeviceFeatures::default(),
            queue: *own.queue(),
            queue_family: own.0.family,
        };
        // SAFETY: the handles are those of an open device, which is closed last.
        let gpu = unsafe { Gpu::from_raw(host, None) }.unwrap();
        let library = shader::shipped();
        for name in ["fire_ball", "fur"] {
            let mut scene = preset(name).unwrap();
            scene.object.input = "sphere".into();
            (scene.image.size, scene.quality.samples, scene.quality.order) = (SIZE, 48, Order::BackToFront);
            scene.light.shadow_resolution = 16;
            let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
            let mut renderer = Renderer::new(&gpu, &library, &subject);
            for pass in [Pass::Slices, Pass::March] {
                scene.quality.pass = pass;
                let frame = render(&own, &library, &scene, &subject).unwrap();
                let over = frame.pixels.iter().map(|pixel| {
                    std::array::from_fn::<f32, 4, _>(|channel| pixel[channel] + (1.0 - pixel[3]) * BEHIND[channel])
                });
                // Twice: the second picture is made of what the first has left.
                for found in [(); 2].map(|()| recorded(&own, &gpu, &mut renderer, &scene)) {
                    let off = |(a, b): ([f32; 4], &[f32; 4])| (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
                    let worst = over.clone().zip(&found).map(off).fold(0.0, f32::max);
                    assert!(worst < 1e-5, "{name}, {pass:?}: {worst}");
                    assert!(frame.pixels.iter().any(|pixel| pixel[3] > 0.5), "{name}: nothing is drawn");
                }
            }
            scene.quality.msaa = 4;
            let target = HostTarget { view: vk::ImageView::null(), format: Format::Rgba32Float.vk(), size: SIZE };
            // SAFETY: nothing is recorded.
            let mut commands = unsafe { gpu.host_commands(vk::CommandBuffer::null(), target) }.unwrap();
            let refused = renderer.record(&mut commands, &scene).map(drop).unwrap_err().to_string();
            assert!(refused.ends_with("use quality.msaa = 1"), "{refused}");
        }
        drop(gpu);
        drop(own);
        assert_eq!(messages.take(), Vec::<String>::new());
    }
}
