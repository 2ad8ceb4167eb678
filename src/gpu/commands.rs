//! Recording and submission: every submission is timed and waited for.

use super::{BindSet, Buffer, Gpu, GpuError, Image, Named, Pipeline};
use ash::vk;
use std::ops::Range;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use support::watchdog::{Excess, Watchdog};

/// A submission that takes longer is given up. Shorter: slow devices fail on large images. Longer: a hang looks like
/// patience; a desktop resets the device after two seconds anyway.
const TIMEOUT_SECONDS: u64 = 60;

/// Vertices of a draw: whole slices of either proxy. More: lavapipe (Mesa 22) takes 4095 at a time, and loses what is left
/// of a slice cut there where that is 9 vertices: a slice of a batch of 342 was missing, once in some hundred pictures.
const MOST_VERTICES: u32 = 3072;

/// How long a submission took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Submitted {
    /// Milliseconds on the device, by timestamps; those of the wall clock where the device has none.
    pub gpu_ms: f64,
    /// Milliseconds from submission to completion.
    pub wall_ms: f64,
    /// Fragment shader invocations, where the device counts them.
    pub fragments: Option<u64>,
}

/// What is drawn into.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// The image that is blended into.
    pub color: &'a Image,
    /// Where its samples are averaged to, at the end of a rendering that asks for it.
    pub resolved: Option<&'a Image>,
    /// Which pixels are marked: pipelines that heed it draw the others alone. Cleared with the color.
    pub marks: Option<&'a Image>,
}

impl<'a> Target<'a> {
    /// An image of one sample per pixel, all of which is drawn into.
    pub fn of(color: &'a Image) -> Target<'a> {
        Target { color, resolved: None, marks: None }
    }
}

/// A rectangle of pixels of a target.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Area {
    /// From the left.
    pub columns: Range<u32>,
    /// From the top.
    pub rows: Range<u32>,
}

impl Area {
    /// A whole picture of this width and height.
    pub fn whole([width, height]: [u32; 2]) -> Area {
        Area { columns: 0..width, rows: 0..height }
    }

    /// The whole quads of 2 x 2 pixels that it is in, beyond the picture too.
    pub fn quads(&self) -> Area {
        let whole = |side: &Range<u32>| side.start & !1..side.end.next_multiple_of(2);
        Area { columns: whole(&self.columns), rows: whole(&self.rows) }
    }

    /// How many pixels it has.
    pub fn pixels(&self) -> u64 {
        self.columns.len() as u64 * self.rows.len() as u64
    }
}

impl From<&Area> for vk::Rect2D {
    fn from(Area { columns, rows }: &Area) -> vk::Rect2D {
        let offset = vk::Offset2D { x: columns.start as i32, y: rows.start as i32 };
        vk::Rect2D { offset, extent: vk::Extent2D { width: columns.len() as u32, height: rows.len() as u32 } }
    }
}

/// What a rendering begins with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// A uniform color, premultiplied linear RGBA.
    Clear([f32; 4]),
    /// What is there.
    Keep,
}

impl Gpu {
    /// Records commands, submits them and waits until they are done.
    ///
    /// # Errors
    /// A call fails, or the device does not finish within a minute.
    pub fn submit(&self, what: &str, record: impl FnOnce(&mut Commands<'_>)) -> Result<Submitted, GpuError> {
        let device = &self.0.device;
        // The lock makes this the only user of pool and queue.
        let queue = self.queue();
        let job = Job::new(self)?;
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer is new and in no use.
        unsafe { device.begin_command_buffer(job.buffer, &begin) }.named("vkBeginCommandBuffer")?;
        let mut commands = Commands { gpu: self, buffer: job.buffer };
        let timed = self.0.info.timestamp_period > 0.0;
        // SAFETY: the command buffer is being recorded; the pool has two queries.
        unsafe {
            if timed {
                device.cmd_reset_query_pool(job.buffer, job.queries, 0, 2);
                device.cmd_write_timestamp2(job.buffer, vk::PipelineStageFlags2::ALL_COMMANDS, job.queries, 0);
            }
            if job.statistics != vk::QueryPool::null() {
                device.cmd_reset_query_pool(job.buffer, job.statistics, 0, 1);
                device.cmd_begin_query(job.buffer, job.statistics, 0, vk::QueryControlFlags::empty());
            }
            record(&mut commands);
            if job.statistics != vk::QueryPool::null() {
                device.cmd_end_query(job.buffer, job.statistics, 0);
            }
            if timed {
                device.cmd_write_timestamp2(job.buffer, vk::PipelineStageFlags2::ALL_COMMANDS, job.queries, 1);
            }
            device.end_command_buffer(job.buffer).named("vkEndCommandBuffer")?;
        }
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(job.buffer)];
        let start = Instant::now();
        // SAFETY: the queue is locked; what the commands use is borrowed by the caller for longer than this call, and
        // the job stays until the fence is signaled. After a timeout nothing is freed any more.
        unsafe {
            let submits = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
            device.queue_submit2(*queue, &submits, job.fence).named("vkQueueSubmit2")?;
            let waited = self.wait_for(job.fence, what);
            if waited.as_ref().is_err_and(|error| !error.is_lost()) {
                self.give_up();
            }
            waited?;
        }
        let wall_ms = start.elapsed().as_secs_f64() * 1e3;
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        let mut fragments = None;
        if job.statistics != vk::QueryPool::null() {
            let mut count = [0u64];
            // SAFETY: the query was ended by the finished submission.
            unsafe { device.get_query_pool_results(job.statistics, 0, &mut count, flags) }
                .named("vkGetQueryPoolResults")?;
            fragments = Some(count[0]);
        }
        if !timed {
            return Ok(Submitted { gpu_ms: wall_ms, wall_ms, fragments });
        }
        let mut ticks = [0u64; 2];
        // SAFETY: both queries were written by the finished submission.
        unsafe { device.get_query_pool_results(job.queries, 0, &mut ticks, flags) }.named("vkGetQueryPoolResults")?;
        let gpu_ms = ticks[1].saturating_sub(ticks[0]) as f64 * f64::from(self.0.info.timestamp_period) * 1e-6;
        Ok(Submitted { gpu_ms, wall_ms, fragments })
    }

    /// Waits for a fence: of a device for a minute; of one that is the processor until it has had a minute of that, too, or
    /// none of it for three. Where many programs share a processor, it takes long and hangs no more than before.
    pub(super) fn wait_for(&self, fence: vk::Fence, what: &str) -> Result<(), GpuError> {
        self.0.waits.fetch_add(1, Ordering::Relaxed);
        let (limit, start) = (Duration::from_secs(TIMEOUT_SECONDS), Instant::now());
        let mut watch = Watchdog::new(std::process::id(), limit, u64::MAX);
        let mut patience = limit;
        loop {
            let is_awaited = || self.info().cpu && start.elapsed() >= limit;
            // SAFETY: the fence belongs to the device.
            match unsafe { self.0.device.wait_for_fences(&[fence], true, patience.as_nanos() as u64) } {
                Err(vk::Result::TIMEOUT) if is_awaited() && watch.excess() != Some(Excess::Time) => {
                    patience = Duration::from_secs(1);
                }
                Err(vk::Result::TIMEOUT) => {
                    return Err(GpuError::Timeout { what: what.into(), seconds: TIMEOUT_SECONDS });
                }
                other => return other.named("vkWaitForFences"),
            }
        }
    }
}

/// What one submission needs, freed at its end.
struct Job<'a> {
    gpu: &'a Gpu,
    buffer: vk::CommandBuffer,
    fence: vk::Fence,
    queries: vk::QueryPool,
    statistics: vk::QueryPool,
}

impl<'a> Job<'a> {
    fn new(gpu: &'a Gpu) -> Result<Job<'a>, GpuError> {
        let device = &gpu.0.device;
        let (fence, queries) = (vk::Fence::null(), vk::QueryPool::null());
        let info = vk::CommandBufferAllocateInfo::default().command_pool(gpu.0.pool.handle).command_buffer_count(1);
        // SAFETY: the pool belongs to the device and is only used under the queue's lock.
        let buffer = unsafe { device.allocate_command_buffers(&info) }.named("vkAllocateCommandBuffers")?[0];
        let mut job = Job { gpu, buffer, fence, queries, statistics: queries };
        // SAFETY: the device is alive; each handle is owned as soon as it exists.
        unsafe {
            job.fence = device.create_fence(&vk::FenceCreateInfo::default(), None).named("vkCreateFence")?;
            let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2);
            job.queries = device.create_query_pool(&info, None).named("vkCreateQueryPool")?;
            if gpu.info().counts_fragments {
                let info = vk::QueryPoolCreateInfo::default()
                    .query_type(vk::QueryType::PIPELINE_STATISTICS)
                    .pipeline_statistics(vk::QueryPipelineStatisticFlags::FRAGMENT_SHADER_INVOCATIONS)
                    .query_count(1);
                job.statistics = device.create_query_pool(&info, None).named("vkCreateQueryPool")?;
            }
        }
        Ok(job)
    }
}

impl Drop for Job<'_> {
    fn drop(&mut self) {
        // SAFETY: nothing is in use any more: the fence was signaled, or the device is lost.
        self.gpu.free(|device| unsafe {
            device.free_command_buffers(self.gpu.0.pool.handle, &[self.buffer]);
            device.destroy_fence(self.fence, None);
            device.destroy_query_pool(self.queries, None);
            device.destroy_query_pool(self.statistics, None);
        });
    }
}

/// Commands being recorded.
pub struct Commands<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) buffer: vk::CommandBuffer,
}

impl Commands<'_> {
    /// Copies a buffer into a sampled image and leaves it ready to be sampled.
    pub(super) fn upload(&mut self, from: &Buffer, to: &Image) {
        use vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};
        self.transition(
            to,
            Layout::TRANSFER_DST_OPTIMAL,
            Stage::NONE,
            Access::NONE,
            Stage::COPY,
            Access::TRANSFER_WRITE,
        );
        let mut offset = 0;
        let region = |(mip_level, extent): (u32, &vk::Extent3D)| {
            let layers = vk::ImageSubresourceLayers { mip_level, ..LAYERS };
            let region = vk::BufferImageCopy::default().buffer_offset(offset).image_subresource(layers);
            offset += to.level_bytes(*extent);
            region.image_extent(*extent)
        };
        let regions: Vec<vk::BufferImageCopy> = (0..).zip(&to.levels).map(region).collect();
        // SAFETY: the image is in the layout named, and the buffer holds exactly the texels of its levels.
        unsafe {
            let layout = Layout::TRANSFER_DST_OPTIMAL;
            self.gpu.0.device.cmd_copy_buffer_to_image(self.buffer, from.handle, to.handle, layout, &regions);
        }
        let (stage, access) = (Stage::FRAGMENT_SHADER, Access::SHADER_SAMPLED_READ);
        self.transition(to, Layout::SHADER_READ_ONLY_OPTIMAL, Stage::COPY, Access::TRANSFER_WRITE, stage, access);
    }

    /// Copies areas of a target into a buffer, one behind the other, visible to the host.
    pub(super) fn download(&mut self, from: &Image, areas: &[Area], to: &Buffer) {
        use vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};
        let (stage, access) = (Stage::COLOR_ATTACHMENT_OUTPUT, Access::COLOR_ATTACHMENT_WRITE);
        self.transition(from, Layout::TRANSFER_SRC_OPTIMAL, stage, access, Stage::COPY, Access::TRANSFER_READ);
        let mut offset = 0;
        let region = |area: &Area| {
            let vk::Rect2D { offset: at, extent: vk::Extent2D { width, height } } = area.into();
            let region = vk::BufferImageCopy::default().image_subresource(LAYERS).buffer_offset(offset);
            offset += area.pixels() * from.format().bytes();
            let extent = vk::Extent3D { width, height, depth: 1 };
            region.image_offset(vk::Offset3D { x: at.x, y: at.y, z: 0 }).image_extent(extent)
        };
        let regions: Vec<vk::BufferImageCopy> = areas.iter().map(region).collect();
        let visible = [vk::MemoryBarrier2::default()
            .src_stage_mask(Stage::COPY)
            .src_access_mask(Access::TRANSFER_WRITE)
            .dst_stage_mask(Stage::HOST)
            .dst_access_mask(Access::HOST_READ)];
        // SAFETY: the image is in the layout named, and the buffer has room for exactly the texels of the areas in it.
        unsafe {
            let layout = Layout::TRANSFER_SRC_OPTIMAL;
            self.gpu.0.device.cmd_copy_image_to_buffer(self.buffer, from.handle, layout, to.handle, &regions);
            let dependency = vk::DependencyInfo::default().memory_barriers(&visible);
            self.gpu.0.device.cmd_pipeline_barrier2(self.buffer, &dependency);
        }
    }

    /// Draws into a target; its samples are resolved where it says so.
    pub fn render(&mut self, target: Target<'_>, load: Load, draw: impl FnOnce(&mut Draw<'_>)) {
        use vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};
        let (stage, write) = (Stage::COLOR_ATTACHMENT_OUTPUT, Access::COLOR_ATTACHMENT_WRITE);
        let access = write | Access::COLOR_ATTACHMENT_READ;
        for image in [Some(target.color), target.resolved].into_iter().flatten() {
            let (after, written) = match image.layout() {
                Layout::SHADER_READ_ONLY_OPTIMAL => (Stage::FRAGMENT_SHADER, Access::NONE), // it was sampled
                _ => (stage | Stage::COPY, write),
            };
            self.transition(image, Layout::COLOR_ATTACHMENT_OPTIMAL, after, written, stage, access);
        }
        let mut attachment = vk::RenderingAttachmentInfo::default()
            .image_view(target.color.view)
            .image_layout(Layout::COLOR_ATTACHMENT_OPTIMAL)
            .store_op(vk::AttachmentStoreOp::STORE)
            .load_op(vk::AttachmentLoadOp::LOAD);
        if let Load::Clear(float32) = load {
            attachment = attachment.load_op(vk::AttachmentLoadOp::CLEAR);
            attachment = attachment.clear_value(vk::ClearValue { color: vk::ClearColorValue { float32 } });
        }
        if let Some(resolved) = target.resolved {
            attachment = attachment
                .resolve_mode(vk::ResolveModeFlags::AVERAGE)
                .resolve_image_view(resolved.view)
                .resolve_image_layout(Layout::COLOR_ATTACHMENT_OPTIMAL);
        }
        let vk::Extent3D { width, height, .. } = target.color.extent;
        let marks = target.marks.map(|image| self.marks(image, load != Load::Keep));
        self.draw_into(Some(attachment), marks, vk::Extent2D { width, height }, draw);
    }

    /// Draws marks of pixels, where nothing is discarded. What is drawn may read the color of the target.
    pub fn mark(&mut self, color: &Image, marks: &Image, draw: impl FnOnce(&mut Draw<'_>)) {
        self.sample(color);
        let attachment = self.marks(marks, false);
        let vk::Extent3D { width, height, .. } = marks.extent;
        self.draw_into(None, Some(attachment), vk::Extent2D { width, height }, draw);
    }

    /// An image of marks, ready to be tested and written.
    fn marks(&mut self, image: &Image, clear: bool) -> vk::RenderingAttachmentInfo<'static> {
        use vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};
        let tests = Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS;
        let write = Access::DEPTH_STENCIL_ATTACHMENT_WRITE;
        let layout = Layout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        self.transition(image, layout, tests, write, tests, write | Access::DEPTH_STENCIL_ATTACHMENT_READ);
        let depth_stencil = vk::ClearDepthStencilValue { depth: UNMARKED, stencil: 0 };
        vk::RenderingAttachmentInfo::default()
            .image_view(image.view)
            .image_layout(layout)
            .store_op(vk::AttachmentStoreOp::STORE)
            .load_op(if clear { vk::AttachmentLoadOp::CLEAR } else { vk::AttachmentLoadOp::LOAD })
            .clear_value(vk::ClearValue { depth_stencil })
    }

    /// Draws into attachments that are in their layouts: colors, marks or both.
    pub(super) fn draw_into(
        &mut self,
        color: Option<vk::RenderingAttachmentInfo<'_>>,
        marks: Option<vk::RenderingAttachmentInfo<'_>>,
        extent: vk::Extent2D,
        draw: impl FnOnce(&mut Draw<'_>),
    ) {
        let vk::Extent2D { width, height } = extent;
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent };
        let mut info = vk::RenderingInfo::default().render_area(area).layer_count(1);
        info = info.color_attachments(color.as_slice());
        if let Some(marks) = &marks {
            info = info.depth_attachment(marks);
        }
        // Beside marks all that is drawn has one depth: that of a mark, or that which passes where there is none.
        let [min_depth, max_depth] = match (&color, &marks) {
            (_, None) => [0.0, 1.0],
            (Some(_), Some(_)) => [UNMARKED; 2],
            (None, Some(_)) => [MARKED; 2],
        };
        let (width_points, height_points) = (width as f32, height as f32);
        let viewport =
            vk::Viewport { width: width_points, height: height_points, min_depth, max_depth, ..Default::default() };
        let device = &self.gpu.0.device;
        // SAFETY: the command buffer is being recorded, and the images are in the layouts named.
        unsafe {
            device.cmd_begin_rendering(self.buffer, &info);
            device.cmd_set_viewport(self.buffer, 0, &[viewport]);
            device.cmd_set_scissor(self.buffer, 0, &[area]);
            draw(&mut Draw { gpu: self.gpu, buffer: self.buffer });
            device.cmd_end_rendering(self.buffer);
        }
    }

    /// Leaves a target that was drawn into ready to be sampled.
    pub fn sample(&mut self, image: &Image) {
        use vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};
        let (drawn, written) = (Stage::COLOR_ATTACHMENT_OUTPUT, Access::COLOR_ATTACHMENT_WRITE);
        let (read, access) = (Stage::FRAGMENT_SHADER, Access::SHADER_SAMPLED_READ);
        self.transition(image, Layout::SHADER_READ_ONLY_OPTIMAL, drawn, written, read, access);
    }

    pub(super) fn transition(
        &mut self,
        image: &Image,
        layout: vk::ImageLayout,
        after: vk::PipelineStageFlags2,
        written: vk::AccessFlags2,
        before: vk::PipelineStageFlags2,
        access: vk::AccessFlags2,
    ) {
        let barriers = [vk::ImageMemoryBarrier2::default()
            .image(image.handle)
            .subresource_range(image.format().range())
            .old_layout(image.set_layout(layout))
            .new_layout(layout)
            .src_stage_mask(after)
            .src_access_mask(written)
            .dst_stage_mask(before)
            .dst_access_mask(access)];
        let dependency = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: the command buffer is being recorded outside a rendering, and the image belongs to the device.
        unsafe { self.gpu.0.device.cmd_pipeline_barrier2(self.buffer, &dependency) };
    }
}

/// Depth of a pixel that is marked, and of one that is not.
const MARKED: f32 = 0.0;
const UNMARKED: f32 = 1.0;

/// The single layer of a color image.
const LAYERS: vk::ImageSubresourceLayers = vk::ImageSubresourceLayers {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    mip_level: 0,
    base_array_layer: 0,
    layer_count: 1,
};

/// Draws of one rendering.
pub struct Draw<'a> {
    gpu: &'a Gpu,
    buffer: vk::CommandBuffer,
}

impl Draw<'_> {
    /// Limits what is drawn next to this area of the target.
    pub fn within(&mut self, area: &Area) {
        // SAFETY: the command buffer is inside a rendering, and the scissor is a dynamic state of every pipeline.
        unsafe { self.gpu.0.device.cmd_set_scissor(self.buffer, 0, &[area.into()]) };
    }

    /// Draws triangles: a range of the vertices of `buffer`, or of none where the program makes its own.
    pub fn triangles(&mut self, pipeline: &Pipeline, set: &BindSet, buffer: Option<&Buffer>, vertices: Range<u32>) {
        let device = &self.gpu.0.device;
        // SAFETY: the command buffer is inside a rendering; the set was made for this pipeline's layout, and the
        // caller holds all of them until the submission has been waited for.
        unsafe {
            let point = vk::PipelineBindPoint::GRAPHICS;
            device.cmd_bind_pipeline(self.buffer, point, pipeline.handle);
            device.cmd_bind_descriptor_sets(self.buffer, point, pipeline.layout, 0, &[set.handle], &[]);
            if let Some(buffer) = buffer {
                device.cmd_bind_vertex_buffers(self.buffer, 0, &[buffer.handle], &[0]);
            }
            for first in vertices.clone().step_by(MOST_VERTICES as usize) {
                device.cmd_draw(self.buffer, MOST_VERTICES.min(vertices.end - first), 1, first, 0);
            }
        }
    }
}
