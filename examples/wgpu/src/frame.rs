//! Textures of a frame in flight, and wgpu's passes before and after the scene.

use crate::device::Host;
use crate::{SIZE, floats};
use ash::vk;
use hypertexture::glam::Mat4;
use std::error::Error;

/// Format of the scene's color, premultiplied linear light, for wgpu and for Vulkan.
const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
pub const COLOR_VK: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const PICTURE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
const EXTENT: wgpu::Extent3d = wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 };
/// Bytes of a uniform block: two matrices.
const BYTES: u64 = 128;

/// Textures and uniforms of a frame in flight.
pub struct Frame {
    picture: wgpu::Texture,
    picture_view: wgpu::TextureView,
    /// Depth of wgpu's own objects.
    host_depth: wgpu::TextureView,
    /// Color and depth of the scene.
    pub color: wgpu::TextureView,
    pub depth: wgpu::TextureView,
    uniforms: [wgpu::Buffer; 2],
    groups: [wgpu::BindGroup; 2],
}

impl Frame {
    pub fn new(device: &wgpu::Device, passes: &Passes) -> Frame {
        let texture = |format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: EXTENT,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let read = |format| view(&texture(format, wgpu::TextureUsages::TEXTURE_BINDING));
        let picture = texture(PICTURE, wgpu::TextureUsages::COPY_SRC);
        let (host_depth, color, depth) = (read(DEPTH), read(COLOR), read(wgpu::TextureFormat::R32Float));
        let uniforms = [(); 2].map(|()| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: BYTES,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        });
        let group = |pipeline: &wgpu::RenderPipeline, uniform: &wgpu::Buffer, views: &[&wgpu::TextureView]| {
            let mut entries = vec![wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }];
            entries.extend((1..).zip(views).map(|(binding, view)| wgpu::BindGroupEntry {
                binding,
                resource: wgpu::BindingResource::TextureView(view),
            }));
            let layout = &pipeline.get_bind_group_layout(0);
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
        };
        let groups = [
            group(&passes.pillars, &uniforms[0], &[]),
            group(&passes.compose, &uniforms[1], &[&color, &depth, &host_depth]),
        ];
        Frame { picture_view: view(&picture), picture, host_depth, color, depth, uniforms, groups }
    }

    /// Texels of the picture, row by row.
    pub fn read(&self, host: &Host) -> Result<Vec<u8>, Box<dyn Error>> {
        let row = 4 * SIZE[0];
        let buffer = host.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row * SIZE[1]),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = host.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_texture_to_buffer(self.picture.as_image_copy(), to, EXTENT);
        host.queue.submit([encoder.finish()]);
        buffer.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        host.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(buffer.slice(..).get_mapped_range()?.to_vec())
    }
}

/// Pipelines of wgpu's passes.
pub struct Passes {
    pillars: wgpu::RenderPipeline,
    compose: wgpu::RenderPipeline,
}

impl Passes {
    pub fn new(device: &wgpu::Device) -> Passes {
        let module = device.create_shader_module(wgpu::include_wgsl!("passes.wgsl"));
        let pipeline = |name: &str, blend, depth_stencil| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(name),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(&format!("{name}_vertex")),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(&format!("{name}_fragment")),
                    compilation_options: Default::default(),
                    targets: &[Some(wgpu::ColorTargetState {
                        format: PICTURE,
                        blend,
                        write_mask: wgpu::ColorWrites::ALL,
                    })],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let depth = wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        };
        let over = Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING);
        Passes { pillars: pipeline("pillars", None, Some(depth)), compose: pipeline("compose", over, None) }
    }

    /// Draws the host's objects, and clears the textures of the scene.
    pub fn before(&self, host: &Host, frame: &Frame, projection_view: Mat4) -> wgpu::CommandBuffer {
        host.queue.write_buffer(&frame.uniforms[0], 0, bytemuck::cast_slice(&floats(projection_view)));
        let mut encoder = host.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let sky = wgpu::Color { r: 0.03, g: 0.05, b: 0.09, a: 1.0 };
        let depth = wgpu::RenderPassDepthStencilAttachment {
            view: &frame.host_depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        };
        let mut pass = begin(&mut encoder, &frame.picture_view, wgpu::LoadOp::Clear(sky), Some(depth));
        pass.set_pipeline(&self.pillars);
        pass.set_bind_group(0, &frame.groups[0], &[]);
        pass.draw(0..36, 0..9);
        drop(pass);
        for view in [&frame.color, &frame.depth] {
            drop(begin(&mut encoder, view, wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), None));
        }
        encoder.finish()
    }

    /// Lays the scene over what is behind it.
    pub fn after(&self, host: &Host, frame: &Frame, projection: Mat4, object_view: Mat4) -> wgpu::CommandBuffer {
        let matrices = [floats(projection), floats(object_view)];
        host.queue.write_buffer(&frame.uniforms[1], 0, bytemuck::cast_slice(&matrices));
        let mut encoder = host.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = begin(&mut encoder, &frame.picture_view, wgpu::LoadOp::Load, None);
        pass.set_pipeline(&self.compose);
        pass.set_bind_group(0, &frame.groups[1], &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        encoder.finish()
    }
}

fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
    depth: Option<wgpu::RenderPassDepthStencilAttachment<'_>>,
) -> wgpu::RenderPass<'a> {
    let color = wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
    };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(color)],
        depth_stencil_attachment: depth,
        ..Default::default()
    })
}
