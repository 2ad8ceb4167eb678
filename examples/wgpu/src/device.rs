//! wgpu's Vulkan device, shared with the renderer.

use crate::SIZE;
use crate::frame::{COLOR_VK, Frame};
use ash::vk;
use hypertexture::gpu::{Gpu, HostDevice, HostTarget, Recording};
use hypertexture::render::Renderer;
use hypertexture::scene::Scene;
use std::error::Error;
use wgpu::hal::api::Vulkan;

/// wgpu's device and queue, and the renderer's view of them.
pub struct Host {
    /// Dropped before the device.
    pub gpu: Gpu,
    pub queue: wgpu::Queue,
    pub device: wgpu::Device,
}

impl Host {
    /// Opens a device with the features that the renderer needs besides wgpu's: `hypertexture::gpu::required_features`.
    pub fn new() -> Result<Host, Box<dyn Error>> {
        let mut about = wgpu::InstanceDescriptor::new_without_display_handle();
        about.backends = wgpu::Backends::VULKAN;
        let instance = wgpu::Instance::new(about);
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
        let limits = wgpu::Limits::default();
        // wgpu has maintenance4 by itself.
        let mut rendering = vk::PhysicalDeviceDynamicRenderingFeatures::default().dynamic_rendering(true);
        let mut barriers = vk::PhysicalDeviceSynchronization2Features::default().synchronization2(true);
        // SAFETY: features are added, none is turned off, and the handles are those of one device that outlives the `Gpu`: it
        // is dropped first. Only this thread submits.
        unsafe {
            let raw = adapter.as_hal::<Vulkan>().ok_or("the adapter is not one of Vulkan")?;
            let more: Box<wgpu::hal::vulkan::CreateDeviceCallback<'_>> = Box::new(|more| {
                *more.create_info = more.create_info.push_next(&mut rendering).push_next(&mut barriers);
            });
            let hints = wgpu::MemoryHints::default();
            let open = raw.open_with_callback(wgpu::Features::empty(), &limits, &hints, Some(more))?;
            let own = &open.device;
            let shared = own.shared_instance();
            let host = HostDevice {
                entry: shared.entry().clone(),
                instance: shared.raw_instance().clone(),
                physical_device: own.raw_physical_device(),
                device: own.raw_device().clone(),
                features: vk::PhysicalDeviceFeatures::default(),
                queue: own.raw_queue(),
                queue_family: own.queue_family_index(),
            };
            let gpu = Gpu::from_raw(host, None)?;
            let about = wgpu::DeviceDescriptor { required_limits: limits.clone(), ..Default::default() };
            let (device, queue) = adapter.create_device_from_hal(open, &about)?;
            Ok(Host { gpu, queue, device })
        }
    }

    /// Records the scene into the textures of a frame, which a pass before has cleared.
    pub fn record(
        &self,
        frame: &Frame,
        renderer: &mut Renderer,
        scene: &Scene,
    ) -> Result<(wgpu::CommandBuffer, Recording), Box<dyn Error>> {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        // SAFETY: the textures are color attachments in the layout of such, where the pass before left them; the barrier makes
        // its writes visible. The commands are submitted once, in order, and the recording is dropped after their end.
        let recording = unsafe {
            let views = [&frame.color, &frame.depth].map(|view| view.as_hal::<Vulkan>().map(|view| view.raw_handle()));
            let [Some(color), Some(depth)] = views else { return Err("the textures are not those of Vulkan".into()) };
            let device = self.device.as_hal::<Vulkan>().ok_or("the device is not one of Vulkan")?.raw_device().clone();
            encoder.as_hal_mut::<Vulkan, _, _>(|encoder| -> Result<Recording, Box<dyn Error>> {
                let commands = encoder.ok_or("the encoder is not one of Vulkan")?.raw_handle();
                let stage = vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT;
                let write = vk::AccessFlags2::COLOR_ATTACHMENT_WRITE;
                let visible = [vk::MemoryBarrier2::default()
                    .src_stage_mask(stage)
                    .src_access_mask(write)
                    .dst_stage_mask(stage)
                    .dst_access_mask(write | vk::AccessFlags2::COLOR_ATTACHMENT_READ)];
                device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().memory_barriers(&visible));
                let target = |view, format| HostTarget { view, format, size: SIZE };
                let into = self.gpu.host_commands(commands, target(color, COLOR_VK))?;
                let mut into = into.with_depth(target(depth, vk::Format::R32_SFLOAT))?;
                Ok(renderer.record(&mut into, scene)?)
            })?
        };
        Ok((encoder.finish(), recording))
    }

    /// Waits for a frame in flight, and frees what its commands used.
    pub fn finish(&self, frame: Option<(wgpu::SubmissionIndex, Recording)>) -> Result<(), wgpu::PollError> {
        if let Some((index, recording)) = frame {
            self.device.poll(wgpu::PollType::Wait { submission_index: Some(index), timeout: None })?;
            drop(recording);
        }
        Ok(())
    }
}
