//! Devices and command buffers of a host program.

use super::device::{Device, Opened};
use super::image::Upload;
use super::instance::Instance;
use super::physical::device_info;
use super::{BindSet, Buffer, Commands, Format, Gpu, GpuError, Image, Pipeline, Uploads};
use ash::vk;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// Handles of a device of Vulkan 1.3 with [`required_features`](super::required_features), owned by a host program.
pub struct HostDevice {
    /// The loader.
    pub entry: ash::Entry,
    /// The instance.
    pub instance: ash::Instance,
    /// The physical device.
    pub physical_device: vk::PhysicalDevice,
    /// The device.
    pub device: ash::Device,
    /// Its enabled features, such as [`optional_features`](super::optional_features).
    pub features: vk::PhysicalDeviceFeatures,
    /// A queue with graphics.
    pub queue: vk::Queue,
    /// The family of the queue.
    pub queue_family: u32,
}

impl Gpu {
    /// Wraps a device that the host keeps owning. The folder `cache` holds compiled pipelines.
    ///
    /// # Errors
    /// Memory is exhausted.
    ///
    /// # Safety
    /// - The handles belong together and outlive the [`Gpu`] and everything created from it;
    /// - the device has [`required_features`](super::required_features) and `features` enabled;
    /// - nobody else uses the queue during a call of this crate that submits: any that takes a `Gpu` or belongs to a renderer.
    ///   Recording for a host submits only for the shadow volume of a scene.
    pub unsafe fn from_raw(host: HostDevice, cache: Option<&Path>) -> Result<Gpu, GpuError> {
        let info = device_info(&host.instance, host.physical_device, &host.features);
        // SAFETY: the physical device belongs to the instance, as the caller says.
        let families = unsafe { host.instance.get_physical_device_queue_family_properties(host.physical_device) };
        let family = families.get(host.queue_family as usize).copied().unwrap_or_default();
        let info = info.with_queue(&family);
        let instance = Instance::of_host(host.entry, host.instance);
        let device = Device { raw: host.device, hosted: true };
        let HostDevice { physical_device: physical, queue, queue_family: family, .. } = host;
        Gpu::with_device(Opened { instance, physical, info, device, queue, family }, cache)
    }

    /// Converts the format of an image of a host.
    ///
    /// # Errors
    /// The format is not supported, or does not support blending.
    pub fn host_format(&self, format: vk::Format) -> Result<Format, GpuError> {
        let found = Format::HOST.into_iter().find(|own| own.vk() == format);
        found.filter(|&format| self.can_blend(format)).ok_or_else(|| GpuError::Unsupported {
            device: self.info().name.clone(),
            what: format!("blending into {format:?}"),
            remedy: format!("use an image of {:?}", Format::HOST.map(Format::vk)),
        })
    }

    /// Wraps a command buffer of a host for recording a picture.
    ///
    /// # Errors
    /// Those of [`Gpu::host_format`]; or the size is 0, or larger than the device allows.
    ///
    /// # Safety
    /// - The command buffer belongs to this device and its queue family, and is being recorded outside of a rendering;
    /// - the image of the view is a color attachment with one sample, in `COLOR_ATTACHMENT_OPTIMAL` layout, which it keeps;
    ///   previous writes are visible to color attachment reads and writes;
    /// - the commands are executed once on the queue of the [`Gpu`], in the order of recording, as later ones may read copies of
    ///   earlier ones. A recording that is not executed is [discarded](Recording::discard) before the next one begins;
    /// - the [`Recording`] is dropped after the commands have been executed, and before the device.
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
    /// Supported formats of host images.
    const HOST: [Format; 6] = [
        Format::Rgba8Srgb,
        Format::Bgra8Srgb,
        Format::Rgba8Unorm,
        Format::Bgra8Unorm,
        Format::Rgba16Float,
        Format::Rgba32Float,
    ];
}

/// An image of a host as a render target. Written colors are linear; sRGB formats encode them.
#[derive(Clone, Copy, Debug)]
pub struct HostTarget {
    /// View of the whole image.
    pub view: vk::ImageView,
    /// Its format.
    pub format: vk::Format,
    /// Width and height in pixels.
    pub size: [u32; 2],
}

/// A command buffer of a host and its render target; see [`Gpu::host_commands`].
pub struct HostCommands<'a> {
    commands: Commands<'a>,
    target: HostTarget,
    format: Format,
    depth: Option<vk::ImageView>,
}

impl HostCommands<'_> {
    /// Adds an image of the host that receives the depth of the picture in all its pixels; see
    /// [`Renderer::render_depth`](crate::render::Renderer::render_depth).
    ///
    /// # Errors
    /// [`GpuError::Unsupported`]: the format is not `R32_SFLOAT`, or the size differs from that of the picture.
    ///
    /// # Safety
    /// As for the picture in [`Gpu::host_commands`].
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

    /// Whether there is an image for the depth.
    pub(crate) fn has_depth(&self) -> bool {
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

    /// Records the queued uploads, then draws triangles over the image: a range of the vertices of `buffer`; without a buffer
    /// the program generates them. `depth` draws the image of the depth, if there is one.
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

/// Resources of recorded commands. The host drops it after their execution.
#[must_use = "the resources of the commands must live until their execution"]
pub struct Recording {
    _pipeline: Arc<Pipeline>,
    _set: BindSet,
    _vertices: Option<Buffer>,
    _depth: Option<(Arc<Pipeline>, BindSet)>,
    copied: Vec<Upload>,
    /// Queue of the copied uploads.
    uploads: Uploads,
}

impl Recording {
    /// Discards commands that the host does not execute. Their uploads return to the queue.
    pub fn discard(self) {
        for own in &self.copied {
            own.image.set_layout(vk::ImageLayout::UNDEFINED);
        }
        self.uploads.all().extend(self.copied);
    }
}

#[cfg(test)]
mod tests;
