//! Textured triangles, drawn into the swapchain of a window.

use super::bind_set::{BindSet, Binding, BindingKind, Resource};
use super::commands::Commands;
use super::pipeline::{Blend, Marks, Pipeline, PipelineDescription};
use super::sampler::{Address, Sampler};
use super::surface::Surface;
use super::window::WindowHandle;
use super::{Area, Format, Gpu, GpuError, Named, Options};
use super::{Buffer, BufferUse, Dimension, Image, ImageUse};
use ash::vk;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// Longest wait for an image of the swapchain, nanoseconds: a compositor may withhold those of a hidden window.
const ACQUIRE_TIMEOUT: u64 = 200_000_000;
/// Floats of the attributes of a [`Vertex`].
const ATTRIBUTES: [u32; 3] = [2, 2, 4];
/// Bindings of the program: a texture and its sampler.
const TEXTURE: u32 = 0;
const SAMPLER: u32 = 1;
/// Specialization constant: whether the target expects linear colors.
const LINEAR_ID: u32 = 0;

/// Position in the window from -1 to 1 (2 numbers), texture coordinates (2), premultiplied sRGB color (4).
pub type Vertex = [f32; 8];

/// Texels of a new or changed texture.
pub struct CanvasTexture {
    /// Number of the texture.
    pub id: u64,
    /// Width and height in texels.
    pub size: [u32; 2],
    /// Premultiplied sRGB and alpha, 8 bits a channel, row by row.
    pub texels: Vec<u8>,
}

/// Triangles with one texture, clipped to an area.
pub struct Batch {
    /// Number of the texture.
    pub texture: u64,
    /// Pixels that may be drawn.
    pub area: Area,
    /// Range of the vertices.
    pub vertices: Range<u32>,
}

/// A device with the swapchain of a window.
pub struct Canvas {
    pipeline: Pipeline,
    sampler: Arc<Sampler>,
    textures: HashMap<u64, Texture>,
    freed: Vec<u64>,
    frame: WindowFrame,
    surface: Surface,
}

struct Texture {
    image: Arc<Image>,
    set: BindSet,
    /// Texels to copy into the image before its next use.
    fresh: Option<Buffer>,
}

/// Result of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presented {
    /// The content is on the screen.
    Yes,
    /// The swapchain had another size than the window; draw again.
    Later,
    /// The window has no pixels, or gave no image in time.
    Hidden,
}

/// Command buffer and synchronization of the one drawing in flight.
struct WindowFrame {
    gpu: Gpu,
    pool: vk::CommandPool,
    buffer: vk::CommandBuffer,
    /// Signaled while no drawing is in flight.
    done: vk::Fence,
    /// Signaled when the image is available.
    acquired: vk::Semaphore,
    /// Buffers that the drawing in flight reads.
    reads: Vec<Buffer>,
}

impl WindowFrame {
    fn new(gpu: &Gpu) -> Result<WindowFrame, GpuError> {
        let device = &gpu.0.device;
        let mut frame = WindowFrame {
            gpu: gpu.clone(),
            pool: vk::CommandPool::null(),
            buffer: vk::CommandBuffer::null(),
            done: vk::Fence::null(),
            acquired: vk::Semaphore::null(),
            reads: Vec::new(),
        };
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(gpu.0.family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: the device is alive and has a queue of this family; each handle is owned as soon as it exists.
        unsafe {
            frame.pool = device.create_command_pool(&info, None).named("vkCreateCommandPool")?;
            let info = vk::CommandBufferAllocateInfo::default().command_pool(frame.pool).command_buffer_count(1);
            frame.buffer = device.allocate_command_buffers(&info).named("vkAllocateCommandBuffers")?[0];
            let signaled = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
            frame.done = device.create_fence(&signaled, None).named("vkCreateFence")?;
            frame.acquired = device.create_semaphore(&Default::default(), None).named("vkCreateSemaphore")?;
        }
        Ok(frame)
    }

    /// Waits until no drawing is in flight.
    fn wait(&self) -> Result<(), GpuError> {
        self.gpu.wait_for(self.done, "the window")
    }
}

impl Drop for WindowFrame {
    fn drop(&mut self) {
        let _queue = self.gpu.queue();
        // SAFETY: the device is idle while its queue is locked; null is ignored.
        self.gpu.free(|device| unsafe {
            let _ = device.device_wait_idle();
            device.destroy_semaphore(self.acquired, None);
            device.destroy_fence(self.done, None);
            device.destroy_command_pool(self.pool, None);
        });
    }
}

impl Drop for Canvas {
    fn drop(&mut self) {
        // The drawing in flight may use what is freed here, unless the device is lost.
        if let Err(error) = self.frame.wait() {
            log::warn!("{error}");
        }
    }
}

impl Canvas {
    /// Opens the best device that can draw into a window.
    ///
    /// # Errors
    /// Those of [`Gpu::new`]; or no device can present to the window.
    pub fn open(options: &Options, window: Arc<dyn WindowHandle>) -> Result<Canvas, GpuError> {
        let surface = Surface::open(options, window)?;
        let gpu = &surface.gpu;
        let (format, linear) = match surface.format.format {
            vk::Format::B8G8R8A8_SRGB => (Format::Bgra8Srgb, true),
            vk::Format::R8G8B8A8_SRGB => (Format::Rgba8Srgb, true),
            vk::Format::R8G8B8A8_UNORM => (Format::Rgba8Unorm, false),
            _ => (Format::Bgra8Unorm, false),
        };
        let binding = |index, kind| Binding { index, kind, vertex: false, fragment: true };
        let description = PipelineDescription {
            vertex: &words(include_bytes!(concat!(env!("OUT_DIR"), "/window.vert"))),
            fragment: &words(include_bytes!(concat!(env!("OUT_DIR"), "/window.frag"))),
            constants: &[(LINEAR_ID, u32::from(linear))],
            bindings: &[binding(TEXTURE, BindingKind::Image), binding(SAMPLER, BindingKind::Sampler)],
            attributes: &ATTRIBUTES,
            format,
            samples: 1,
            blend: Blend::Over,
            marks: Marks::None,
            covered: false,
        };
        let (pipeline, frame) = (Pipeline::new(gpu, &description)?, WindowFrame::new(gpu)?);
        let sampler = Arc::new(Sampler::new(gpu, Address::Clamp, 1.0)?);
        Ok(Canvas { pipeline, sampler, textures: HashMap::new(), freed: Vec::new(), frame, surface })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.surface.gpu
    }

    /// Draws triangles into a window of `size` pixels. `triangles` takes the size of the image and gives their corners, three
    /// for each, and the batches from back to front. Textures are updated even if the window is hidden; those of `freed` are
    /// freed after this drawing. `pictures` are textures that the device has made.
    ///
    /// # Errors
    /// A call fails; [`GpuError::is_lost`] says whether another device may help.
    pub fn draw(
        &mut self,
        size: [u32; 2],
        textures: &[CanvasTexture],
        freed: impl IntoIterator<Item = u64>,
        pictures: impl IntoIterator<Item = (u64, Arc<Image>)>,
        triangles: impl FnOnce([u32; 2]) -> (Vec<Vertex>, Vec<Batch>),
    ) -> Result<Presented, GpuError> {
        // Textures in use must not change.
        self.frame.wait()?;
        self.frame.reads.clear();
        for id in self.freed.drain(..) {
            self.textures.remove(&id);
        }
        let gpu = self.surface.gpu.clone();
        for texture in textures {
            self.set_texture(&gpu, texture)?;
        }
        for (id, image) in pictures {
            if self.textures.get(&id).is_none_or(|own| !Arc::ptr_eq(&own.image, &image)) {
                let texture = self.texture(image, None)?;
                self.textures.insert(id, texture);
            }
        }
        self.freed.extend(freed);
        let presented = self.present(&gpu, size, triangles)?;
        if presented == Presented::Later {
            self.surface.outdated();
        }
        Ok(presented)
    }

    /// Stages the texels of a texture for the next drawing.
    fn set_texture(&mut self, gpu: &Gpu, texture: &CanvasTexture) -> Result<(), GpuError> {
        let CanvasTexture { id, size: [width, height], texels } = texture;
        let fresh = Some(Buffer::new(gpu, "upload", BufferUse::Upload, texels)?);
        match self.textures.get_mut(id).filter(|texture| texture.image.size() == [*width, *height, 1]) {
            Some(texture) => texture.fresh = fresh,
            None => {
                let (plane, sampled) = (Dimension::Plane(*width, *height), ImageUse::Sampled);
                let image = Arc::new(Image::new(gpu, "texture of the window", plane, Format::Rgba8Unorm, sampled)?);
                let texture = self.texture(image, fresh)?;
                self.textures.insert(*id, texture);
            }
        }
        Ok(())
    }

    /// Binds an image as a texture.
    fn texture(&self, image: Arc<Image>, fresh: Option<Buffer>) -> Result<Texture, GpuError> {
        let (own, sampler) = (Resource::Image(image.clone()), Resource::Sampler(self.sampler.clone()));
        Ok(Texture { image, set: self.pipeline.bind(&[(TEXTURE, own), (SAMPLER, sampler)])?, fresh })
    }

    fn present(
        &mut self,
        gpu: &Gpu,
        size: [u32; 2],
        triangles: impl FnOnce([u32; 2]) -> (Vec<Vertex>, Vec<Batch>),
    ) -> Result<Presented, GpuError> {
        let swapchains = self.surface.swapchains.clone();
        let Some(chain) = self.surface.swapchain(size)? else { return Ok(Presented::Hidden) };
        let (handle, extent) = (chain.handle, chain.extent);
        // SAFETY: the swapchain is alive and used by this thread only; the semaphore is unused.
        let index = match unsafe {
            swapchains.acquire_next_image(handle, ACQUIRE_TIMEOUT, self.frame.acquired, vk::Fence::null())
        } {
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => return Ok(Presented::Later),
            // Compositors withhold the images of hidden windows (docs/notes/drivers.md).
            Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => return Ok(Presented::Hidden),
            other => other.named("vkAcquireNextImageKHR")?.0,
        };
        let target = chain.images[index as usize];
        let device = &gpu.0.device;
        let buffer = self.frame.buffer;
        let (vertices, batches) = triangles([extent.width, extent.height]);
        let vertices = Buffer::new(gpu, "window", BufferUse::Vertices, bytemuck::cast_slice(&vertices))?;
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let attachment = vk::RenderingAttachmentInfo::default()
            .image_view(target.view)
            .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE);
        // SAFETY: the fence says that the command buffer is unused.
        unsafe { device.begin_command_buffer(buffer, &begin) }.named("vkBeginCommandBuffer")?;
        let mut commands = Commands { gpu, buffer };
        for texture in self.textures.values_mut() {
            if let Some(fresh) = texture.fresh.take() {
                commands.upload(&fresh, &texture.image);
                self.frame.reads.push(fresh);
            }
        }
        transition(gpu, buffer, target.image, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
        commands.draw_into(Some(attachment), None, extent, |draw| {
            for Batch { texture, area, vertices: range } in batches {
                if let Some(texture) = self.textures.get(&texture) {
                    draw.within(&area);
                    draw.triangles(&self.pipeline, &texture.set, Some(&vertices), range);
                }
            }
        });
        transition(gpu, buffer, target.image, vk::ImageLayout::PRESENT_SRC_KHR);
        self.frame.reads.push(vertices);
        // SAFETY: the command buffer is being recorded.
        unsafe { device.end_command_buffer(buffer) }.named("vkEndCommandBuffer")?;
        let stage = vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT;
        let waits = [vk::SemaphoreSubmitInfo::default().semaphore(self.frame.acquired).stage_mask(stage)];
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let signals = [vk::SemaphoreSubmitInfo::default().semaphore(target.drawn).stage_mask(all)];
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(buffer)];
        let submits = [vk::SubmitInfo2::default()
            .wait_semaphore_infos(&waits)
            .signal_semaphore_infos(&signals)
            .command_buffer_infos(&buffers)];
        let (drawn_ones, chains, indices) = ([target.drawn], [handle], [index]);
        let info =
            vk::PresentInfoKHR::default().wait_semaphores(&drawn_ones).swapchains(&chains).image_indices(&indices);
        let queue = gpu.queue();
        // SAFETY: the queue is locked; all submitted resources live until the fence is signaled.
        let presented = unsafe {
            device.reset_fences(&[self.frame.done]).named("vkResetFences")?;
            device.queue_submit2(*queue, &submits, self.frame.done).named("vkQueueSubmit2")?;
            swapchains.queue_present(*queue, &info)
        };
        match presented {
            Ok(false) => Ok(Presented::Yes),
            // Presented in a former size of the window.
            Ok(true) | Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(Presented::Later),
            Err(result) => Err(GpuError::Call { call: "vkQueuePresentKHR", result }),
        }
    }
}

/// Transitions an image of the swapchain, for drawing without its content or for presenting.
fn transition(gpu: &Gpu, buffer: vk::CommandBuffer, image: vk::Image, to: vk::ImageLayout) {
    use vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};
    let output = Stage::COLOR_ATTACHMENT_OUTPUT;
    let write = Access::COLOR_ATTACHMENT_WRITE;
    let barrier =
        vk::ImageMemoryBarrier2::default().image(image).subresource_range(super::format::COLOR).new_layout(to);
    let barrier = match to {
        // The semaphore of the acquired image is waited for at this stage.
        Layout::COLOR_ATTACHMENT_OPTIMAL => barrier
            .old_layout(Layout::UNDEFINED)
            .src_stage_mask(output)
            .dst_stage_mask(output)
            .dst_access_mask(write | Access::COLOR_ATTACHMENT_READ),
        _ => barrier
            .old_layout(Layout::COLOR_ATTACHMENT_OPTIMAL)
            .src_stage_mask(output)
            .src_access_mask(write)
            .dst_stage_mask(Stage::NONE),
    };
    let barriers = [barrier];
    let dependency = vk::DependencyInfo::default().image_memory_barriers(&barriers);
    // SAFETY: the command buffer is being recorded outside a rendering, and the image is one of the swapchain.
    unsafe { gpu.0.device.cmd_pipeline_barrier2(buffer, &dependency) };
}

/// The words of SPIR-V.
pub(super) fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect()
}
