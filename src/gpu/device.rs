//! Instance, physical device, device, queue, allocator and pipeline cache: one [`Gpu`] for each process.

use super::instance::Instance;
use super::memory::MEMORY_BLOCK;
use super::physical::{choose, create_device};
use super::{DeviceInfo, Format, GpuError, Messages, Named};
use ash::vk;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use hypertexture_support::disk_cache::{self, CacheKind};
use hypertexture_support::faults;
use std::ffi::c_char;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

/// Cache of compiled pipelines: one file per driver, never evicted.
const PIPELINES: CacheKind = CacheKind { ends: &[], limit: 256 << 20 };

/// Options for opening a device.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Part of the name of the device. `None` prefers discrete GPUs, then integrated ones, virtual ones and CPUs.
    pub device: Option<String>,
    /// Core and synchronization validation, which needs the layer. With its version 1.3.239, no other thread may use a
    /// validated device while one is opened or closed (`docs/notes/drivers.md`).
    pub validation: bool,
    /// Folder for compiled pipelines.
    pub cache: Option<PathBuf>,
}

impl Options {
    /// Options with the device from the environment variable `HYPERTEXTURE_DEVICE`.
    pub fn from_env() -> Options {
        Options { device: std::env::var("HYPERTEXTURE_DEVICE").ok(), ..Options::default() }
    }
}

/// An open device. Clones share it; the last one closes it.
#[derive(Clone)]
pub struct Gpu(pub(super) Arc<Shared>);

/// The handles of a [`Gpu`], in the order of their destruction.
pub(super) struct Shared {
    pub(super) pipeline_cache: PipelineCache,
    pub(super) pool: CommandPool,
    allocator: Mutex<Allocator>,
    queue: Mutex<vk::Queue>,
    /// Ticket for the queue: the thread that released the queue cannot lock it again before a waiting one.
    next: Mutex<()>,
    /// Whether a submission timed out: then nothing is freed any more.
    stuck: AtomicBool,
    /// Number of waits for a fence.
    pub(super) waits: AtomicU64,
    pub(super) device: Device,
    pub(super) info: DeviceInfo,
    /// Family of the queue.
    #[cfg(any(feature = "window", test))]
    pub(super) family: u32,
    pub(super) physical: vk::PhysicalDevice,
    pub(super) instance: Instance,
}

/// An open device with its instance.
pub(super) struct Opened {
    pub(super) instance: Instance,
    pub(super) physical: vk::PhysicalDevice,
    pub(super) info: DeviceInfo,
    pub(super) device: Device,
    pub(super) queue: vk::Queue,
    pub(super) family: u32,
}

/// The logical device.
pub(super) struct Device {
    pub(super) raw: ash::Device,
    /// Whether a host owns and destroys it.
    pub(super) hosted: bool,
}

impl std::ops::Deref for Device {
    type Target = ash::Device;
    fn deref(&self) -> &ash::Device {
        &self.raw
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: all objects of the device are destroyed: their owners are earlier fields, or keep it alive.
        unsafe {
            if !self.hosted {
                let _ = self.raw.device_wait_idle();
                self.raw.destroy_device(None);
            }
        }
    }
}

/// Owner of the command pool.
pub(super) struct CommandPool {
    device: ash::Device,
    pub(super) handle: vk::CommandPool,
}

impl Drop for CommandPool {
    fn drop(&mut self) {
        // SAFETY: the pool belongs to this device, a later field of the same owner; no command buffer is in use.
        unsafe { self.device.destroy_command_pool(self.handle, None) };
    }
}

/// Owner of the pipeline cache, written to its file on drop.
pub(super) struct PipelineCache {
    device: ash::Device,
    pub(super) handle: vk::PipelineCache,
    file: Option<PathBuf>,
    /// Content of the file, and of a cache without pipelines of this driver.
    known: Vec<u8>,
    empty: Vec<u8>,
}

impl Drop for PipelineCache {
    fn drop(&mut self) {
        // SAFETY: the cache belongs to this device, a later field of the same owner.
        unsafe {
            // Drivers such as lavapipe keep pipelines in a cache of their own, and give out a header alone.
            let is_new = |data: &Vec<u8>| *data != self.known && data.len() > self.empty.len();
            let data = self.device.get_pipeline_cache_data(self.handle).ok().filter(is_new);
            if let (Some(file), Some(data)) = (&self.file, data) {
                // Without the file, the next start takes longer.
                if let Err(error) = disk_cache::write(file, data, PIPELINES) {
                    log::warn!("the pipeline cache {} could not be written: {error}", file.display());
                }
            }
            self.device.destroy_pipeline_cache(self.handle, None);
        }
    }
}

impl Gpu {
    /// Opens a device.
    ///
    /// # Errors
    /// No loader, driver, device or validation layer: the message says what to install.
    pub fn new(options: &Options) -> Result<Gpu, GpuError> {
        Gpu::with_instance(options, Instance::new(options.validation, &[])?, &[], |_, _| true)
    }

    /// Takes a device that was just opened for a GPU.
    #[cfg(test)]
    pub(crate) fn taken_for_a_gpu(self) -> Gpu {
        self.with_info(|info| info.cpu = false)
    }

    /// Takes a device that was just opened for one with other properties.
    #[cfg(test)]
    pub(crate) fn with_info(mut self, change: impl FnOnce(&mut DeviceInfo)) -> Gpu {
        if let Some(shared) = Arc::get_mut(&mut self.0) {
            change(&mut shared.info);
        }
        self
    }

    /// Opens the best device of an instance, with a queue family that `fits` and with extensions.
    pub(super) fn with_instance(
        options: &Options,
        instance: Instance,
        extensions: &[*const c_char],
        fits: impl Fn(vk::PhysicalDevice, u32) -> bool,
    ) -> Result<Gpu, GpuError> {
        let wanted = options.device.as_deref().unwrap_or_default();
        let (physical, family, device_info) = choose(&instance.raw, wanted, fits)?;
        let raw = create_device(&instance.raw, physical, family, extensions)?;
        let raw = if faults::are_on() { super::faults::armed(&instance, raw) } else { raw };
        // SAFETY: the device has one queue of this family.
        let queue = unsafe { raw.get_device_queue(family, 0) };
        let device = Device { raw, hosted: false };
        let opened = Opened { instance, physical, info: device_info, device, queue, family };
        Gpu::with_device(opened, options.cache.as_deref())
    }

    /// Adds the allocator, command pool and pipeline cache to an open device.
    pub(super) fn with_device(opened: Opened, cache: Option<&Path>) -> Result<Gpu, GpuError> {
        let Opened { instance, physical, info: device_info, device, queue, family } = opened;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: device.raw.clone(),
            physical_device: physical,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: gpu_allocator::AllocationSizes::new(MEMORY_BLOCK, MEMORY_BLOCK),
        })
        .map_err(|error| GpuError::Memory {
            what: "the allocator".into(),
            bytes: 0,
            reason: error.to_string(),
        })?;
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the device is alive and has a queue of this family.
        let handle = unsafe { device.create_command_pool(&info, None) }.named("vkCreateCommandPool")?;
        let pool = CommandPool { device: device.raw.clone(), handle };
        let file = cache.map(|folder| folder.join(cache_name(&instance.raw, physical)));
        let known = file.as_ref().and_then(|file| disk_cache::read(file, PIPELINES).ok()?).unwrap_or_default();
        let info = vk::PipelineCacheCreateInfo::default().initial_data(&known);
        // SAFETY: the device is alive; the data was written by this very driver, as its file name and checksum say.
        let handle = unsafe { device.create_pipeline_cache(&info, None) }.named("vkCreatePipelineCache")?;
        let mut pipeline_cache = PipelineCache { device: device.raw.clone(), handle, file, known, empty: Vec::new() };
        if pipeline_cache.known.is_empty() {
            // SAFETY: the device and the cache are alive.
            pipeline_cache.empty = unsafe { device.get_pipeline_cache_data(handle) }.unwrap_or_default();
        }
        let (allocator, queue, next) = (Mutex::new(allocator), Mutex::new(queue), Mutex::new(()));
        Ok(Gpu(Arc::new(Shared {
            pipeline_cache,
            pool,
            allocator,
            queue,
            next,
            stuck: AtomicBool::new(false),
            waits: AtomicU64::new(0),
            device,
            info: device_info,
            #[cfg(any(feature = "window", test))]
            family,
            physical,
            instance,
        })))
    }

    /// Properties of the device.
    pub fn info(&self) -> &DeviceInfo {
        &self.0.info
    }

    /// Number of times that this crate has waited for a submission, on all threads.
    pub fn waits(&self) -> u64 {
        self.0.waits.load(Ordering::Relaxed)
    }

    /// Messages of the validation layer; readable after the device is closed.
    pub fn messages(&self) -> Messages {
        self.0.instance.messages.clone()
    }

    /// Sample counts of render targets with this format, ascending.
    pub fn sample_counts(&self, format: Format) -> Vec<u32> {
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        // SAFETY: the physical device belongs to the instance, and both are alive.
        let properties = unsafe {
            self.0.instance.raw.get_physical_device_image_format_properties(
                self.0.physical,
                format.vk(),
                vk::ImageType::TYPE_2D,
                vk::ImageTiling::OPTIMAL,
                usage,
                vk::ImageCreateFlags::empty(),
            )
        };
        let Ok(properties) = properties else { return Vec::new() };
        (0..7).map(|bit| 1 << bit).filter(|count| properties.sample_counts.as_raw() & count != 0).collect()
    }

    /// Whether render targets of this format support blending.
    pub fn can_blend(&self, format: Format) -> bool {
        self.features(format).contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND)
    }

    /// Whether images of this format support linear filtering.
    pub fn can_filter(&self, format: Format) -> bool {
        !self.0.info.unfiltered.contains(&format)
    }

    /// The format in which the texels of a sampled image are stored.
    pub(super) fn stored(&self, format: Format) -> Format {
        format.widened().filter(|_| self.0.info.unread.contains(&format)).unwrap_or(format)
    }

    fn features(&self, format: Format) -> vk::FormatFeatureFlags {
        // SAFETY: the physical device belongs to the instance, and both are alive.
        unsafe { self.0.instance.raw.get_physical_device_format_properties(self.0.physical, format.vk()) }
            .optimal_tiling_features
    }

    /// Locks the queue fairly: a thread that submits in a loop does not starve the others.
    pub(super) fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        let _turn = self.0.next.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        self.0.queue.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Frees an object of the device, unless a submission that timed out may still use it.
    pub(super) fn free(&self, free: impl FnOnce(&ash::Device)) {
        if !self.0.stuck.load(Ordering::Relaxed) {
            free(&self.0.device);
        }
    }

    /// Leaks the device and all its objects after a timeout.
    pub(super) fn give_up(&self) {
        if !self.0.stuck.swap(true, Ordering::Relaxed) {
            std::mem::forget(self.clone());
        }
    }

    pub(super) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.0.allocator.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// Name of the pipeline cache, which depends on the device and its driver.
fn cache_name(instance: &ash::Instance, physical: vk::PhysicalDevice) -> String {
    // SAFETY: the physical device belongs to the instance, and both are alive.
    let properties = unsafe { instance.get_physical_device_properties(physical) };
    let uuid: String = properties.pipeline_cache_uuid.iter().map(|byte| format!("{byte:02x}")).collect();
    format!("pipelines-{:x}-{:x}-{:x}-{uuid}", properties.vendor_id, properties.device_id, properties.driver_version)
}
