//! Recording of commands.

use super::{BindSet, Buffer, Gpu, Image, Pipeline};
use ash::vk;
use std::ops::Range;

/// Most vertices of a draw: a whole number of slices. Higher: lavapipe loses parts of slices (`docs/notes/drivers.md`).
const MAX_VERTICES: u32 = 3072;

/// Pixels along a side of a group of compute shader invocations: see `glsl/pixel.glsl`.
pub(super) const GROUP_SIDE: u32 = 8;

/// A render target.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// Color attachment.
    pub color: &'a Image,
    /// Resolve attachment: receives the mean of the samples.
    pub resolved: Option<&'a Image>,
    /// Depth attachment with marks of pixels, cleared with the color; see [`Marks`](super::Marks).
    pub marks: Option<&'a Image>,
}

impl<'a> Target<'a> {
    /// A target of one sample per pixel without marks.
    pub fn of(color: &'a Image) -> Target<'a> {
        Target { color, resolved: None, marks: None }
    }
}

/// A rectangle of pixels of a target.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Area {
    /// Columns from the left.
    pub columns: Range<u32>,
    /// Rows from the top.
    pub rows: Range<u32>,
}

impl Area {
    /// The area of a whole picture.
    pub fn whole([width, height]: [u32; 2]) -> Area {
        Area { columns: 0..width, rows: 0..height }
    }

    /// The area rounded up to quads of 2 x 2 pixels; it may exceed the picture.
    pub fn quads(&self) -> Area {
        let whole = |side: &Range<u32>| side.start & !1..side.end.next_multiple_of(2);
        Area { columns: whole(&self.columns), rows: whole(&self.rows) }
    }

    /// Number of pixels.
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

/// Initial content of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// A uniform color, premultiplied linear RGBA.
    Clear([f32; 4]),
    /// Its present content.
    Keep,
}

/// Commands being recorded.
pub struct Commands<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) buffer: vk::CommandBuffer,
}

impl Commands<'_> {
    /// Copies a buffer into a sampled image, and transitions the image for sampling.
    pub(super) fn upload(&mut self, from: &Buffer, to: &Image) {
        let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        self.transition(to, layout);
        let regions = level_regions(to);
        // SAFETY: the image is in the layout named, and the buffer holds exactly the texels of its levels.
        unsafe {
            self.gpu.0.device.cmd_copy_buffer_to_image(self.buffer, from.handle, to.handle, layout, &regions);
        }
        self.sample(to);
    }

    /// Copies all levels of a sampled image into a buffer.
    #[cfg(test)]
    pub(super) fn download_levels(&mut self, from: &Image, to: &Buffer) {
        let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        self.transition(from, layout);
        let regions = level_regions(from);
        // SAFETY: as for `upload`.
        unsafe {
            self.gpu.0.device.cmd_copy_image_to_buffer(self.buffer, from.handle, layout, to.handle, &regions);
        }
        self.sample(from);
    }

    /// Copies areas of a target into a buffer one after another, visible to the CPU.
    pub(super) fn download(&mut self, from: &Image, areas: &[Area], to: &Buffer) {
        use vk::{AccessFlags2 as Access, PipelineStageFlags2 as Stage};
        let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        self.transition(from, layout);
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
            self.gpu.0.device.cmd_copy_image_to_buffer(self.buffer, from.handle, layout, to.handle, &regions);
            let dependency = vk::DependencyInfo::default().memory_barriers(&visible);
            self.gpu.0.device.cmd_pipeline_barrier2(self.buffer, &dependency);
        }
    }

    /// Draws into a target, and resolves its samples if it has a resolve attachment.
    pub fn render(&mut self, target: Target<'_>, load: Load, draw: impl FnOnce(&mut Draw<'_>)) {
        let layout = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
        [Some(target.color), target.resolved].into_iter().flatten().for_each(|image| self.transition(image, layout));
        let mut attachment = vk::RenderingAttachmentInfo::default()
            .image_view(target.color.view)
            .image_layout(layout)
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
                .resolve_image_layout(layout);
        }
        let vk::Extent3D { width, height, .. } = target.color.extent;
        let marks = target.marks.map(|image| self.marks(image, load != Load::Keep));
        self.draw_into(Some(attachment), marks, vk::Extent2D { width, height }, draw);
    }

    /// Draws marks into pixels whose fragment is not discarded. The fragments may read the color of the target.
    pub fn mark(&mut self, color: &Image, marks: &Image, draw: impl FnOnce(&mut Draw<'_>)) {
        self.sample(color);
        let attachment = self.marks(marks, false);
        let vk::Extent3D { width, height, .. } = marks.extent;
        self.draw_into(None, Some(attachment), vk::Extent2D { width, height }, draw);
    }

    /// Attachment of an image of marks, transitioned for tests and writes.
    fn marks(&mut self, image: &Image, clear: bool) -> vk::RenderingAttachmentInfo<'static> {
        let layout = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        self.transition(image, layout);
        let depth_stencil = vk::ClearDepthStencilValue { depth: UNMARKED, stencil: 0 };
        vk::RenderingAttachmentInfo::default()
            .image_view(image.view)
            .image_layout(layout)
            .store_op(vk::AttachmentStoreOp::STORE)
            .load_op(if clear { vk::AttachmentLoadOp::CLEAR } else { vk::AttachmentLoadOp::LOAD })
            .clear_value(vk::ClearValue { depth_stencil })
    }

    /// Draws into attachments in their layouts: color, marks or both.
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
        // Everything has one depth: that of a mark, or with color that of an unmarked pixel, which passes the test there.
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

    /// Runs a compute pipeline for each pixel of some areas of its picture, in groups of 8 x 8.
    pub fn dispatch(&mut self, pipeline: &Pipeline, set: &BindSet, picture: &Image, areas: &[Area]) {
        self.transition(picture, vk::ImageLayout::GENERAL);
        let device = &self.gpu.0.device;
        // SAFETY: the command buffer is being recorded outside a rendering; the set has the layout of the pipeline, and the
        // caller keeps both until the submission has finished.
        unsafe {
            let point = vk::PipelineBindPoint::COMPUTE;
            device.cmd_bind_pipeline(self.buffer, point, pipeline.handle);
            device.cmd_bind_descriptor_sets(self.buffer, point, pipeline.layout, 0, &[set.handle], &[]);
            for Area { columns, rows } in areas {
                let bounds = [columns.start, rows.start, columns.end, rows.end];
                let stage = vk::ShaderStageFlags::COMPUTE;
                device.cmd_push_constants(self.buffer, pipeline.layout, stage, 0, bytemuck::cast_slice(&bounds));
                let [width, height] = [columns, rows].map(|side| (side.len() as u32).div_ceil(GROUP_SIDE));
                device.cmd_dispatch(self.buffer, width, height, 1);
            }
        }
    }

    /// Runs `groups` groups of a compute pipeline that writes words, with the constants of `glsl/block.comp`.
    pub(crate) fn write_words(&mut self, pipeline: &Pipeline, set: &BindSet, constants: [u32; 4], groups: u32) {
        let device = &self.gpu.0.device;
        // SAFETY: as for `dispatch`.
        unsafe {
            let point = vk::PipelineBindPoint::COMPUTE;
            device.cmd_bind_pipeline(self.buffer, point, pipeline.handle);
            device.cmd_bind_descriptor_sets(self.buffer, point, pipeline.layout, 0, &[set.handle], &[]);
            let (stage, bytes) = (vk::ShaderStageFlags::COMPUTE, bytemuck::cast_slice(&constants));
            device.cmd_push_constants(self.buffer, pipeline.layout, stage, 0, bytes);
            device.cmd_dispatch(self.buffer, groups, 1, 1);
        }
    }

    /// Copies written words into planes of a mip level of a sampled image, and transitions the image for sampling.
    pub(crate) fn copy_planes(&mut self, from: &Buffer, to: &Image, mip_level: u32, planes: Range<u32>) {
        use vk::{AccessFlags2 as Access, PipelineStageFlags2 as Stage};
        let written = [vk::MemoryBarrier2::default()
            .src_stage_mask(Stage::COMPUTE_SHADER)
            .src_access_mask(Access::SHADER_STORAGE_WRITE)
            .dst_stage_mask(Stage::COPY)
            .dst_access_mask(Access::TRANSFER_READ)];
        let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        self.transition(to, layout);
        let extent = vk::Extent3D { depth: planes.len() as u32, ..to.levels[mip_level as usize] };
        let region = vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers { mip_level, ..LAYERS })
            .image_offset(vk::Offset3D { z: planes.start as i32, ..Default::default() })
            .image_extent(extent);
        // SAFETY: as for `upload`; the buffer holds the texels of the planes.
        unsafe {
            let dependency = vk::DependencyInfo::default().memory_barriers(&written);
            self.gpu.0.device.cmd_pipeline_barrier2(self.buffer, &dependency);
            self.gpu.0.device.cmd_copy_buffer_to_image(self.buffer, from.handle, to.handle, layout, &[region]);
        }
        self.sample(to);
    }

    /// Transitions an image for sampling.
    pub fn sample(&mut self, image: &Image) {
        self.transition(image, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
    }

    /// Transitions an image to a layout, after its use in the present one.
    pub(super) fn transition(&mut self, image: &Image, layout: vk::ImageLayout) {
        let former = image.set_layout(layout);
        let ((after, written), (before, access)) = (scope(former), scope(layout));
        let barriers = [vk::ImageMemoryBarrier2::default()
            .image(image.handle)
            .subresource_range(image.format().range())
            .old_layout(former)
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

/// Copies of all levels of an image, one after the other in a buffer.
fn level_regions(image: &Image) -> Vec<vk::BufferImageCopy> {
    let mut offset = 0;
    let region = |(mip_level, extent): (u32, &vk::Extent3D)| {
        let layers = vk::ImageSubresourceLayers { mip_level, ..LAYERS };
        let region = vk::BufferImageCopy::default().buffer_offset(offset).image_subresource(layers);
        offset += image.level_bytes(*extent);
        region.image_extent(*extent)
    };
    (0..).zip(&image.levels).map(region).collect()
}

/// Stages and accesses that use an image in a layout.
fn scope(layout: vk::ImageLayout) -> (vk::PipelineStageFlags2, vk::AccessFlags2) {
    use vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};
    match layout {
        Layout::TRANSFER_SRC_OPTIMAL => (Stage::COPY, Access::TRANSFER_READ),
        Layout::TRANSFER_DST_OPTIMAL => (Stage::COPY, Access::TRANSFER_WRITE),
        Layout::SHADER_READ_ONLY_OPTIMAL => {
            (Stage::FRAGMENT_SHADER | Stage::COMPUTE_SHADER, Access::SHADER_SAMPLED_READ)
        }
        Layout::GENERAL => (Stage::COMPUTE_SHADER, Access::SHADER_STORAGE_WRITE),
        Layout::COLOR_ATTACHMENT_OPTIMAL => {
            (Stage::COLOR_ATTACHMENT_OUTPUT, Access::COLOR_ATTACHMENT_READ | Access::COLOR_ATTACHMENT_WRITE)
        }
        Layout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL => (
            Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS,
            Access::DEPTH_STENCIL_ATTACHMENT_READ | Access::DEPTH_STENCIL_ATTACHMENT_WRITE,
        ),
        _ => (Stage::NONE, Access::NONE),
    }
}

/// Depth of marked and unmarked pixels.
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
    /// Sets the scissor to an area of the target.
    pub fn within(&mut self, area: &Area) {
        // SAFETY: the command buffer is inside a rendering, and the scissor is a dynamic state of every pipeline.
        unsafe { self.gpu.0.device.cmd_set_scissor(self.buffer, 0, &[area.into()]) };
    }

    /// Draws triangles: a range of the vertices of `buffer`; without a buffer the program generates them.
    pub fn triangles(&mut self, pipeline: &Pipeline, set: &BindSet, buffer: Option<&Buffer>, vertices: Range<u32>) {
        let device = &self.gpu.0.device;
        // SAFETY: the command buffer is inside a rendering; the set has the layout of the pipeline, and the caller
        // keeps all of them until the submission has finished.
        unsafe {
            let point = vk::PipelineBindPoint::GRAPHICS;
            device.cmd_bind_pipeline(self.buffer, point, pipeline.handle);
            device.cmd_bind_descriptor_sets(self.buffer, point, pipeline.layout, 0, &[set.handle], &[]);
            if let Some(buffer) = buffer {
                device.cmd_bind_vertex_buffers(self.buffer, 0, &[buffer.handle], &[0]);
            }
            for first in vertices.clone().step_by(MAX_VERTICES as usize) {
                device.cmd_draw(self.buffer, MAX_VERTICES.min(vertices.end - first), 1, first, 0);
            }
        }
    }
}
