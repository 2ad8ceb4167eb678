//! A host's own device, and pictures in its own command buffers.

use super::device::{Device, Opened, device_info};
use super::instance::Instance;
use super::memory::Upload;
use super::{BindSet, Buffer, Commands, Format, Gpu, GpuError, Image, Pipeline, Uploads};
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
    /// - nobody else uses the queue while a call of this crate runs that submits: each that takes a `Gpu`, and a renderer's
    ///   too, but for those that record for a host, which submit for the shadow volume of a scene alone.
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

    /// The format of a host's image.
    ///
    /// # Errors
    /// It is none of [`Format`], or cannot be blended into.
    pub fn host_format(&self, format: vk::Format) -> Result<Format, GpuError> {
        let found = Format::HOST.into_iter().find(|own| own.vk() == format);
        found.filter(|&format| self.can_blend(format)).ok_or_else(|| GpuError::Unsupported {
            device: self.info().name.clone(),
            what: format!("blending into {format:?}"),
            remedy: format!("use an image of {:?}", Format::HOST.map(Format::vk)),
        })
    }

    /// A command buffer of a host, to record a picture into.
    ///
    /// # Errors
    /// As [`Gpu::host_format`]; or the size is 0, or more than the device allows.
    ///
    /// # Safety
    /// - The command buffer belongs to this device and to the family of its queue, and is being recorded outside of a rendering;
    /// - the image behind the view is a color attachment with one sample, in `COLOR_ATTACHMENT_OPTIMAL` layout, and what was
    ///   written before is visible to reads and writes of color attachments; it stays in that layout;
    /// - the commands are executed on the queue of the [`Gpu`], once, in the order in which they were recorded: what one copies
    ///   the next may read. A recording that is not executed is [discarded](Recording::discard) before the next is made;
    /// - what a recording returns is dropped after the commands have been executed, and before the device goes.
    pub unsafe fn host_commands(
        &self,
        buffer: vk::CommandBuffer,
        target: HostTarget,
    ) -> Result<HostCommands<'_>, GpuError> {
        let format = self.host_format(target.format)?;
        let [width, height] = target.size;
        Image::check(self, "the host's image", [width, height, 1], self.info().max_image)?;
        Ok(HostCommands { commands: Commands { gpu: self, buffer }, target, format, depth: None })
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
    depth: Option<vk::ImageView>,
}

impl HostCommands<'_> {
    /// The same with another image of the host, all of which the depth of the picture is written into: see
    /// [`Renderer::render_depth`](crate::render::Renderer::render_depth).
    ///
    /// # Errors
    /// [`GpuError::Unsupported`]: its format is not `R32_SFLOAT`, or its size not that of the picture's.
    ///
    /// # Safety
    /// Of its view, as [`Gpu::host_commands`].
    pub unsafe fn with_depth(self, depth: HostTarget) -> Result<Self, GpuError> {
        let [[width, height], size] = [self.target.size, depth.size];
        let (what, remedy) = match depth.format == Format::R32Float.vk() {
            true if depth.size == self.target.size => return Ok(HostCommands { depth: Some(depth.view), ..self }),
            true => {
                (format!("depth of {} x {} pixels", size[0], size[1]), format!("{width} x {height} as the picture's"))
            }
            false => (format!("depth in {:?}", depth.format), format!("{:?}", Format::R32Float.vk())),
        };
        let device = self.commands.gpu.info().name.clone();
        Err(GpuError::Unsupported { device, what, remedy: format!("use an image of {remedy}") })
    }

    /// Whether it has an image for the depth.
    pub fn has_depth(&self) -> bool {
        self.depth.is_some()
    }

    /// Width and height of the image in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.target.size
    }

    /// Format of the image.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Copies what waits to be copied, then draws triangles over what is in the image: a range of the vertices, or of none
    /// where the program makes its own. `depth` draws all of that image, where there is one.
    pub fn draw(
        &mut self,
        uploads: &Uploads,
        pipeline: &Arc<Pipeline>,
        set: BindSet,
        buffer: Option<Buffer>,
        vertices: Range<u32>,
        depth: Option<(Arc<Pipeline>, BindSet)>,
    ) -> Recording {
        let copied = std::mem::take(&mut *uploads.all());
        copied.iter().for_each(|own| self.commands.upload(&own.texels, &own.image));
        let attachment = |view, load| {
            vk::RenderingAttachmentInfo::default()
                .image_view(view)
                .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
                .load_op(load)
                .store_op(vk::AttachmentStoreOp::STORE)
        };
        let [width, height] = self.target.size;
        let (extent, color) =
            (vk::Extent2D { width, height }, attachment(self.target.view, vk::AttachmentLoadOp::LOAD));
        self.commands.draw_into(Some(color), None, extent, |draw| {
            draw.triangles(pipeline, &set, buffer.as_ref(), vertices);
        });
        if let (Some(view), Some((pipeline, set))) = (self.depth, &depth) {
            let all = attachment(view, vk::AttachmentLoadOp::DONT_CARE);
            self.commands.draw_into(Some(all), None, extent, |draw| draw.triangles(pipeline, set, None, 0..3));
        }
        let (_pipeline, uploads) = (pipeline.clone(), uploads.clone());
        Recording { _pipeline, _set: set, _vertices: buffer, _depth: depth, copied, uploads }
    }
}

/// What recorded commands use: the host drops it when they have been executed.
#[must_use = "what the commands use must stay until they have been executed"]
pub struct Recording {
    _pipeline: Arc<Pipeline>,
    _set: BindSet,
    _vertices: Option<Buffer>,
    _depth: Option<(Arc<Pipeline>, BindSet)>,
    copied: Vec<Upload>,
    /// Where they came from.
    uploads: Uploads,
}

impl Recording {
    /// Gives back what the commands use where the host does not execute them: the next commands copy what these were to.
    pub fn discard(self) {
        for own in &self.copied {
            own.image.set_layout(vk::ImageLayout::UNDEFINED);
        }
        self.uploads.all().extend(self.copied);
    }
}

#[cfg(test)]
mod tests;
