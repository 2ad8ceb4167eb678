//! A window's content: the triangles that egui makes of it, drawn into the images of a swapchain.

use super::commands::Commands;
use super::memory::{Buffer, BufferUse, Dimension, Image, ImageUse};
use super::pipeline::{BindSet, Binding, BindingKind, Blend, Marks, Pipeline, PipelineDescription, Resource};
use super::sampler::{Address, Sampler};
use super::surface::Surface;
use super::window::WindowHandle;
use super::{Area, Format, Gpu, GpuError, Named, Options};
use ash::vk;
use egui::epaint::{ImageData, ImageDelta, Primitive};
use egui::{ClippedPrimitive, Color32, ColorImage, TextureId, TexturesDelta};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// A window is waited for at most this long, nanoseconds: a hidden one may give no image, and must not stop the program.
const PATIENCE: u64 = 200_000_000;
/// Floats of the attributes of a vertex: its place in the window from -1 to 1, its place in a texture, and its color.
const ATTRIBUTES: [u32; 3] = [2, 2, 4];
/// Bindings of the program: a texture, and how it is sampled.
const TEXTURE: u32 = 0;
const SAMPLER: u32 = 1;
/// Its constant: whether the target takes linear light.
const LINEAR_ID: u32 = 0;

/// A device that draws into a window.
pub struct Canvas {
    pipeline: Pipeline,
    sampler: Arc<Sampler>,
    textures: HashMap<TextureId, Texture>,
    /// The glyphs, which egui changes in parts.
    glyphs: Option<ColorImage>,
    freed: Vec<TextureId>,
    frame: WindowFrame,
    surface: Surface,
}

/// A texture of egui.
struct Texture {
    image: Arc<Image>,
    set: BindSet,
    /// What is to be copied into it before it is used.
    fresh: Option<Buffer>,
}

/// Triangles of one texture within an area.
struct Batch {
    texture: TextureId,
    area: Area,
    vertices: Range<u32>,
}

/// What became of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presented {
    /// It is on the screen.
    Yes,
    /// The window had an image of another size: try again.
    Later,
    /// The window has no pixel, or gave no image in time.
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
    /// What the drawing that is under way reads.
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

    /// Waits until nothing is being drawn.
    fn wait(&self) -> Result<(), GpuError> {
        self.gpu.wait_for(self.done, "the window")
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
        // What this frees may be in use. A device that is lost uses nothing.
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
        };
        let (pipeline, frame) = (Pipeline::new(gpu, &description)?, WindowFrame::new(gpu)?);
        let sampler = Arc::new(Sampler::new(gpu, Address::Clamp, 1.0)?);
        Ok(Canvas { pipeline, sampler, textures: HashMap::new(), glyphs: None, freed: Vec::new(), frame, surface })
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
        self.frame.reads.clear();
        for id in self.freed.drain(..) {
            self.textures.remove(&id);
        }
        let gpu = self.surface.gpu.clone();
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                self.take(&gpu, id, delta)?;
            }
        }
        self.freed.extend(textures.free.drain());
        let presented = self.present(&gpu, size, primitives, pixels_per_point)?;
        if presented == Presented::Later {
            self.surface.outdated();
        }
        Ok(presented)
    }

    /// Takes the texels of a texture, which are on the device from the next drawing on.
    fn take(&mut self, gpu: &Gpu, id: TextureId, delta: ImageDelta) -> Result<(), GpuError> {
        let delta = self.whole(id, delta);
        let ImageData::Color(content) = &delta.image;
        let [width, height] = content.size.map(|side| side as u32);
        let texels: Vec<u8> = content.pixels.iter().flat_map(Color32::to_array).collect();
        let fresh = Some(Buffer::new(gpu, "upload", BufferUse::Upload, &texels)?);
        match self.textures.get_mut(&id).filter(|texture| texture.image.size() == [width, height, 1]) {
            Some(texture) => texture.fresh = fresh,
            None => {
                let (plane, sampled) = (Dimension::Plane(width, height), ImageUse::Sampled);
                let image = Arc::new(Image::new(gpu, "texture of the window", plane, Format::Rgba8Unorm, sampled)?);
                let (own, sampler) = (Resource::Image(image.clone()), Resource::Sampler(self.sampler.clone()));
                let set = self.pipeline.bind(&[(TEXTURE, own), (SAMPLER, sampler)])?;
                self.textures.insert(id, Texture { image, set, fresh });
            }
        }
        Ok(())
    }

    /// A change of the glyphs as all of them.
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
                Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => return Ok(Presented::Later),
                // A compositor keeps the images of a window that nobody sees.
                Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => return Ok(Presented::Hidden),
                other => other.named("vkAcquireNextImageKHR")?.0,
            };
        let target = chain.images[index as usize];
        let device = &gpu.0.device;
        let buffer = self.frame.buffer;
        let (vertices, batches) = triangles(primitives, [extent.width, extent.height], pixels_per_point);
        let vertices = Buffer::new(gpu, "window", BufferUse::Vertices, bytemuck::cast_slice(&vertices))?;
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let attachment = vk::RenderingAttachmentInfo::default()
            .image_view(target.view)
            .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE);
        // SAFETY: nothing else uses the command buffer, as its fence says.
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
        // SAFETY: the queue is locked; all that is submitted lives until the fence is signaled, which is waited for.
        let presented = unsafe {
            device.reset_fences(&[self.frame.done]).named("vkResetFences")?;
            device.queue_submit2(*queue, &submits, self.frame.done).named("vkQueueSubmit2")?;
            swapchains.queue_present(*queue, &info)
        };
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

/// The triangles of egui as vertices, three for each, and which of them are drawn together.
fn triangles(primitives: &[ClippedPrimitive], size: [u32; 2], pixels_per_point: f32) -> (Vec<[f32; 8]>, Vec<Batch>) {
    let (mut vertices, mut batches) = (Vec::new(), Vec::new());
    let [x, y] = size.map(|side| 2.0 * pixels_per_point / side as f32);
    for ClippedPrimitive { clip_rect, primitive } in primitives {
        let Primitive::Mesh(mesh) = primitive else { continue };
        let range = |from: f32, to: f32, side: u32| {
            let [from, to] = [from, to].map(|edge| (edge * pixels_per_point).round().clamp(0.0, side as f32) as u32);
            from..to.max(from)
        };
        let columns = range(clip_rect.min.x, clip_rect.max.x, size[0]);
        let rows = range(clip_rect.min.y, clip_rect.max.y, size[1]);
        let area = Area { columns, rows };
        if area.pixels() == 0 {
            continue;
        }
        let first = vertices.len() as u32;
        vertices.extend(mesh.indices.iter().filter_map(|index| mesh.vertices.get(*index as usize)).map(|vertex| {
            let [r, g, b, a] = vertex.color.to_array().map(|code| f32::from(code) / 255.0);
            [x * vertex.pos.x - 1.0, y * vertex.pos.y - 1.0, vertex.uv.x, vertex.uv.y, r, g, b, a]
        }));
        batches.push(Batch { texture: mesh.texture_id, area, vertices: first..vertices.len() as u32 });
    }
    if vertices.is_empty() {
        vertices.push([0.0; 8]); // a buffer cannot be empty
    }
    (vertices, batches)
}

/// SPIR-V as the device takes it.
fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect()
}
