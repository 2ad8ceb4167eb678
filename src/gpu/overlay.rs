//! A window's content: the triangles that egui makes of it, drawn into the images of a swapchain.

use super::surface::Surface;
use super::window::WindowHandle;
use super::{Gpu, GpuError, Named, Options};
use ash::vk;
use egui::epaint::{ImageData, ImageDelta};
use egui::{ClippedPrimitive, ColorImage, TextureId, TexturesDelta};
use egui_ash_renderer::allocator::DefaultAllocator;
use egui_ash_renderer::{DynamicRendering, Options as EguiOptions, RenderMode, Renderer, RendererError};
use std::sync::Arc;

/// A window is waited for at most this long, nanoseconds: a hidden one may give no image, and must not stop the program.
const PATIENCE: u64 = 200_000_000;

/// A device that draws into a window.
pub struct Canvas {
    renderer: Renderer<DefaultAllocator>,
    frame: WindowFrame,
    /// The glyphs, which egui changes in parts.
    glyphs: Option<ColorImage>,
    freed: Vec<TextureId>,
    surface: Surface,
}

/// What became of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presented {
    /// It is on the screen.
    Yes,
    /// The window had no image to draw into, or one of another size: try again.
    Later,
    /// The window has no pixel.
    Hidden,
}

/// What one drawing at a time needs.
struct WindowFrame {
    gpu: Gpu,
    pool: vk::CommandPool,
    buffer: vk::CommandBuffer,
    /// Signaled while no drawing is under way.
    done: vk::Fence,
    /// Signaled when the image may be drawn into.
    acquired: vk::Semaphore,
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

    /// Waits until nothing is being drawn.
    fn wait(&self) -> Result<(), GpuError> {
        const SECONDS: u64 = 60;
        // SAFETY: the fence belongs to the device.
        match unsafe { self.gpu.0.device.wait_for_fences(&[self.done], true, SECONDS * 1_000_000_000) } {
            Err(vk::Result::TIMEOUT) => Err(GpuError::Timeout { what: "the window".into(), seconds: SECONDS }),
            other => other.named("vkWaitForFences"),
        }
    }
}

impl Drop for WindowFrame {
    fn drop(&mut self) {
        let _queue = self.gpu.queue();
        // SAFETY: nothing is in use any more, since the device is waited for while its queue is locked; null is ignored.
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
        // What egui's renderer frees may be in use. A device that is lost uses nothing.
        if let Err(error) = self.frame.wait() {
            log::warn!("{error}");
        }
    }
}

impl Canvas {
    /// Opens the best device that can draw into a window.
    ///
    /// # Errors
    /// As [`Gpu::new`]; or no device draws into windows.
    pub fn open(options: &Options, window: Arc<dyn WindowHandle>) -> Result<Canvas, GpuError> {
        let surface = Surface::open(options, window)?;
        let gpu = &surface.gpu;
        let format = surface.format.format;
        let srgb = matches!(format, vk::Format::B8G8R8A8_SRGB | vk::Format::R8G8B8A8_SRGB);
        let frame = WindowFrame::new(gpu)?;
        let mode = RenderMode::DynamicRendering(DynamicRendering {
            color_attachment_format: format,
            depth_attachment_format: None,
            stencil_attachment_format: None,
        });
        let options = EguiOptions { in_flight_frames: 1, srgb_framebuffer: srgb, ..Default::default() };
        let (instance, device) = (&gpu.0.instance.raw, (*gpu.0.device).clone());
        let renderer = Renderer::with_default_allocator(instance, gpu.0.physical, device, mode, options);
        let renderer = renderer.map_err(drawing)?;
        Ok(Canvas { renderer, frame, glyphs: None, freed: Vec::new(), surface })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.surface.gpu
    }

    /// Draws what egui has made of a window of `size` pixels. The textures are taken in any case, since egui tells of a
    /// change once.
    ///
    /// # Errors
    /// A call fails; [`GpuError::is_lost`] says whether another device may help.
    pub fn draw(
        &mut self,
        size: [u32; 2],
        mut textures: TexturesDelta,
        primitives: &[ClippedPrimitive],
        pixels_per_point: f32,
    ) -> Result<Presented, GpuError> {
        // A texture in use must not change, so nothing is under way from here on.
        self.frame.wait()?;
        for id in self.freed.drain(..) {
            self.renderer.free_texture(id).map_err(drawing)?;
        }
        let gpu = self.surface.gpu.clone();
        {
            let queue = gpu.queue();
            for (id, deltas) in textures.set.drain() {
                for delta in deltas {
                    let delta = self.whole(id, delta);
                    self.renderer.set_texture(*queue, self.frame.pool, id, &delta).map_err(drawing)?;
                }
            }
        }
        self.freed.extend(textures.free.drain());
        let presented = self.present(&gpu, size, primitives, pixels_per_point)?;
        if presented == Presented::Later {
            self.surface.outdated();
        }
        Ok(presented)
    }

    /// A change of the glyphs as all of them: the renderer drops what a change does not cover (it begins with an
    /// undefined layout, of which a device may keep nothing).
    fn whole(&mut self, id: TextureId, delta: ImageDelta) -> ImageDelta {
        if id != TextureId::default() {
            return delta;
        }
        let ImageData::Color(part) = &delta.image;
        match (delta.pos, &mut self.glyphs) {
            (Some([left, top]), Some(glyphs)) => {
                let [width, height] = part.size;
                for row in 0..height {
                    let to = (top + row) * glyphs.size[0] + left;
                    glyphs.pixels[to..to + width].copy_from_slice(&part.pixels[row * width..(row + 1) * width]);
                }
                ImageDelta::full(glyphs.clone(), delta.options)
            }
            _ => {
                self.glyphs = Some((**part).clone());
                delta
            }
        }
    }

    fn present(
        &mut self,
        gpu: &Gpu,
        size: [u32; 2],
        primitives: &[ClippedPrimitive],
        pixels_per_point: f32,
    ) -> Result<Presented, GpuError> {
        let swapchains = self.surface.swapchains.clone();
        let Some(chain) = self.surface.swapchain(size)? else { return Ok(Presented::Hidden) };
        let (handle, extent) = (chain.handle, chain.extent);
        // SAFETY: the swapchain is alive and used by this thread only; the semaphore is in no use.
        let index =
            match unsafe { swapchains.acquire_next_image(handle, PATIENCE, self.frame.acquired, vk::Fence::null()) } {
                Err(vk::Result::ERROR_OUT_OF_DATE_KHR | vk::Result::TIMEOUT | vk::Result::NOT_READY) => {
                    return Ok(Presented::Later);
                }
                other => other.named("vkAcquireNextImageKHR")?.0,
            };
        let target = chain.images[index as usize];
        let device = &gpu.0.device;
        let (buffer, renderer) = (self.frame.buffer, &mut self.renderer);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let attachments = [vk::RenderingAttachmentInfo::default()
            .image_view(target.view)
            .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE)];
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent };
        let rendering = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&attachments);
        // SAFETY: nothing else uses the command buffer, as its fence says; the image was acquired.
        let drawn = unsafe {
            device.begin_command_buffer(buffer, &begin).named("vkBeginCommandBuffer")?;
            transition(gpu, buffer, target.image, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
            device.cmd_begin_rendering(buffer, &rendering);
            let drawn = renderer.cmd_draw(buffer, extent, pixels_per_point, primitives).map_err(drawing);
            device.cmd_end_rendering(buffer);
            transition(gpu, buffer, target.image, vk::ImageLayout::PRESENT_SRC_KHR);
            device.end_command_buffer(buffer).named("vkEndCommandBuffer")?;
            drawn
        };
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
        // SAFETY: the queue is locked; all that is submitted lives until the fence is signaled, which is waited for.
        let presented = unsafe {
            device.reset_fences(&[self.frame.done]).named("vkResetFences")?;
            device.queue_submit2(*queue, &submits, self.frame.done).named("vkQueueSubmit2")?;
            swapchains.queue_present(*queue, &info)
        };
        drawn?;
        match presented {
            Ok(false) => Ok(Presented::Yes),
            // Presented, in the size that the window had.
            Ok(true) | Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(Presented::Later),
            Err(result) => Err(GpuError::Call { call: "vkQueuePresentKHR", result }),
        }
    }
}

/// To be drawn into, whatever was there; or to be presented.
fn transition(gpu: &Gpu, buffer: vk::CommandBuffer, image: vk::Image, to: vk::ImageLayout) {
    use vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};
    let output = Stage::COLOR_ATTACHMENT_OUTPUT;
    let write = Access::COLOR_ATTACHMENT_WRITE;
    let barrier =
        vk::ImageMemoryBarrier2::default().image(image).subresource_range(super::memory::COLOR).new_layout(to);
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

fn drawing(error: RendererError) -> GpuError {
    match error {
        RendererError::Vulkan(result) => GpuError::Call { call: "a call of egui's renderer", result },
        other => GpuError::Drawing(other.to_string()),
    }
}
