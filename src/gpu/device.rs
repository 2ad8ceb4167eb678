//! Instance, physical device, device, queue, allocator and pipeline cache: one [`Gpu`] for each process.

use super::instance::Instance;
use super::memory::ALLOCATED_AT_ONCE;
use super::{Format, GpuError, Messages, Named};
use ash::vk;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use std::ffi::c_char;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use support::disk_cache::{self, Kind};
use support::faults;

/// Compiled pipelines: one file for each driver, which none evicts.
const PIPELINES: Kind = Kind { ends: &[], limit: 256 << 20 };

/// How to open a device.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Part of the device's name; `None` takes a discrete GPU before an integrated, virtual or CPU one.
    pub device: Option<String>,
    /// Core and synchronization validation; needs the layer, whose version 1.3.239 demands that no other thread of the
    /// process uses a device under validation while one is opened or closed.
    pub validation: bool,
    /// Folder in which compiled pipelines are kept between runs.
    pub cache: Option<PathBuf>,
}

impl Options {
    /// The device that the environment variable `HYPERTEXTURE_DEVICE` names, as in the program and in tests.
    pub fn from_env() -> Options {
        Options { device: std::env::var("HYPERTEXTURE_DEVICE").ok(), ..Options::default() }
    }
}

/// What a person wants to know about the device.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DeviceInfo {
    /// Name of the device.
    pub name: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Vulkan version of the device.
    pub api: String,
    /// Whether the device is a CPU.
    pub cpu: bool,
    /// Largest 3D image, texels per axis.
    pub max_volume: u32,
    /// Largest 2D image, texels per axis.
    pub max_image: u32,
    /// Largest anisotropy of a sampler; 1 where the device has none.
    pub max_anisotropy: f32,
    /// Whether every sample of a multisampled image can be shaded on its own.
    pub sample_shading: bool,
    /// Whether the device counts fragment shader invocations.
    pub counts_fragments: bool,
    /// Nanoseconds per timestamp tick; 0 where the queue has no timestamps.
    pub timestamp_period: f32,
}

impl DeviceInfo {
    /// Device and driver, as pictures name them.
    pub fn title(&self) -> String {
        format!("{} ({})", self.name, self.driver)
    }
}

/// An open device. Clones share it; the last one closes it.
#[derive(Clone)]
pub struct Gpu(pub(super) Arc<Shared>);

/// What a [`Gpu`] owns; the fields are dropped from the first to the last.
pub(super) struct Shared {
    pub(super) pipeline_cache: PipelineCache,
    pub(super) pool: CommandPool,
    allocator: Mutex<Allocator>,
    queue: Mutex<vk::Queue>,
    /// Who waits for the queue holds this: the one who gave it back cannot take it again before.
    next: Mutex<()>,
    /// It did not finish in time: what it uses stays for as long as the process does.
    stuck: AtomicBool,
    /// How often a thread has waited for it.
    pub(super) waits: AtomicU64,
    pub(super) device: Device,
    pub(super) info: DeviceInfo,
    /// Family of the queue: what egui draws with is made for it.
    #[cfg(any(feature = "window", test))]
    pub(super) family: u32,
    pub(super) physical: vk::PhysicalDevice,
    pub(super) instance: Instance,
}

/// An open device, and what it was opened with.
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
    /// It is a host's, who destroys it.
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
        // SAFETY: all that was made from the device is gone: its owners are fields before it, or hold it alive.
        unsafe {
            if !self.hosted {
                let _ = self.raw.device_wait_idle();
                self.raw.destroy_device(None);
            }
        }
    }
}

/// Owner of the pool of command buffers.
pub(super) struct CommandPool {
    device: ash::Device,
    pub(super) handle: vk::CommandPool,
}

impl Drop for CommandPool {
    fn drop(&mut self) {
        // SAFETY: made from this device, which is a later field of the same owner; no command buffer is in use.
        unsafe { self.device.destroy_command_pool(self.handle, None) };
    }
}

/// Owner of the pipeline cache, which is written to its file at the end.
pub(super) struct PipelineCache {
    device: ash::Device,
    pub(super) handle: vk::PipelineCache,
    file: Option<PathBuf>,
}

impl Drop for PipelineCache {
    fn drop(&mut self) {
        // SAFETY: made from this device, which is a later field of the same owner.
        unsafe {
            if let (Some(file), Ok(data)) = (&self.file, self.device.get_pipeline_cache_data(self.handle)) {
                // A folder that cannot be written costs time, not correctness.
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

    /// Opens the best device of an instance with a queue family that fits, and with these extensions.
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
        // SAFETY: the device was just made with one queue of this family.
        let queue = unsafe { raw.get_device_queue(family, 0) };
        let device = Device { raw, hosted: false };
        let opened = Opened { instance, physical, info: device_info, device, queue, family };
        Gpu::with_device(opened, options.cache.as_deref())
    }

    /// A device with what every picture needs.
    pub(super) fn with_device(opened: Opened, cache: Option<&Path>) -> Result<Gpu, GpuError> {
        let Opened { instance, physical, info: device_info, device, queue, family } = opened;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: device.raw.clone(),
            physical_device: physical,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: gpu_allocator::AllocationSizes::new(ALLOCATED_AT_ONCE, ALLOCATED_AT_ONCE),
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
        let pipeline_cache = PipelineCache { device: device.raw.clone(), handle, file };
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

    /// What the device is and can do.
    pub fn info(&self) -> &DeviceInfo {
        &self.0.info
    }

    /// How often calls of this crate have waited for the device to finish what they had submitted, so far and on any thread.
    pub fn waits(&self) -> u64 {
        self.0.waits.load(Ordering::Relaxed)
    }

    /// What the validation layer has said; readable after the device is closed.
    pub fn messages(&self) -> Messages {
        self.0.instance.messages.clone()
    }

    /// Sample counts that a blended target of this format may have, ascending.
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

    /// Whether a target of this format can be blended into.
    pub fn can_blend(&self, format: Format) -> bool {
        self.features(format).contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND)
    }

    /// Whether an image of this format can be sampled with linear filtering.
    pub fn can_filter(&self, format: Format) -> bool {
        self.features(format).contains(vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR)
    }

    fn features(&self, format: Format) -> vk::FormatFeatureFlags {
        // SAFETY: the physical device belongs to the instance, and both are alive.
        unsafe { self.0.instance.raw.get_physical_device_format_properties(self.0.physical, format.vk()) }
            .optimal_tiling_features
    }

    /// The queue, in turn: a thread that submits again and again keeps no other one waiting.
    pub(super) fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        let _turn = self.0.next.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        self.0.queue.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Frees what was made from the device; nothing where that may still be in use.
    pub(super) fn free(&self, free: impl FnOnce(&ash::Device)) {
        if !self.0.stuck.load(Ordering::Relaxed) {
            free(&self.0.device);
        }
    }

    /// Leaves the device alone, which did not finish in time: it and all that was made from it stay.
    pub(super) fn give_up(&self) {
        if !self.0.stuck.swap(true, Ordering::Relaxed) {
            std::mem::forget(self.clone());
        }
    }

    pub(super) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.0.allocator.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// What every device must have enabled; all of it is mandatory in Vulkan 1.3, and no extension is needed.
pub fn required_features() -> vk::PhysicalDeviceVulkan13Features<'static> {
    // maintenance4 lets a fragment stage leave an output of the vertex stage unread.
    vk::PhysicalDeviceVulkan13Features::default().dynamic_rendering(true).synchronization2(true).maintenance4(true)
}

/// What is used where a device has it: anisotropic filters, the shading of every sample, the count of fragments.
pub fn optional_features(supported: &vk::PhysicalDeviceFeatures) -> vk::PhysicalDeviceFeatures {
    vk::PhysicalDeviceFeatures::default()
        .sampler_anisotropy(supported.sampler_anisotropy == vk::TRUE)
        .sample_rate_shading(supported.sample_rate_shading == vk::TRUE)
        .pipeline_statistics_query(supported.pipeline_statistics_query == vk::TRUE)
}

fn create_device(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    family: u32,
    extensions: &[*const c_char],
) -> Result<ash::Device, GpuError> {
    // SAFETY: the physical device belongs to `instance`, which is alive.
    let supported = unsafe { instance.get_physical_device_features(physical) };
    let (features, mut features13) = (optional_features(&supported), required_features());
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_features(&features)
        .enabled_extension_names(extensions)
        .push_next(&mut features13);
    // SAFETY: every pointer in `info` outlives the call; the features are supported or core in 1.3.
    unsafe { instance.create_device(physical, &info, None) }.named("vkCreateDevice")
}

fn choose(
    instance: &ash::Instance,
    wanted: &str,
    fits: impl Fn(vk::PhysicalDevice, u32) -> bool,
) -> Result<(vk::PhysicalDevice, u32, DeviceInfo), GpuError> {
    // SAFETY: the instance is alive.
    let all = unsafe { instance.enumerate_physical_devices() }.named("vkEnumeratePhysicalDevices")?;
    let mut found = Vec::new();
    let mut fitting = Vec::new();
    for physical in all {
        // SAFETY: the physical device belongs to the instance.
        let (properties, queues) = unsafe {
            (
                instance.get_physical_device_properties(physical),
                instance.get_physical_device_queue_family_properties(physical),
            )
        };
        // SAFETY: the physical device belongs to the instance.
        let supported = unsafe { instance.get_physical_device_features(physical) };
        let device_info = device_info(instance, physical, &supported);
        found.push(device_info.name.clone());
        let draws = |family: &usize| queues[*family].queue_flags.contains(vk::QueueFlags::GRAPHICS);
        let family = (0..queues.len()).find(|family| draws(family) && fits(physical, *family as u32));
        let named = device_info.name.to_lowercase().contains(&wanted.to_lowercase());
        if let (Some(family), true, true) = (family, named, properties.api_version >= vk::API_VERSION_1_3) {
            let rank = match properties.device_type {
                vk::PhysicalDeviceType::DISCRETE_GPU => 0,
                vk::PhysicalDeviceType::INTEGRATED_GPU => 1,
                vk::PhysicalDeviceType::VIRTUAL_GPU => 2,
                _ => 3,
            };
            let period = if queues[family].timestamp_valid_bits == 0 { 0.0 } else { device_info.timestamp_period };
            fitting.push((rank, physical, family as u32, DeviceInfo { timestamp_period: period, ..device_info }));
        }
    }
    let best = fitting.into_iter().min_by_key(|candidate| candidate.0);
    let (_, physical, family, device_info) = best.ok_or_else(|| GpuError::NoDevice {
        wanted: wanted.into(),
        found: if found.is_empty() { "none".into() } else { found.join(", ") },
    })?;
    Ok((physical, family, device_info))
}

impl DeviceInfo {
    /// Whether its samplers may weigh texels by few bits: GPUs have 8; a driver on the processor computes in floats.
    pub fn filters_by_few_bits(&self) -> bool {
        !self.cpu
    }
}

/// What a device is and can do with these features enabled.
pub(super) fn device_info(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    enabled: &vk::PhysicalDeviceFeatures,
) -> DeviceInfo {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut properties2 = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
    // SAFETY: the physical device belongs to the instance; the chain outlives the call.
    unsafe { instance.get_physical_device_properties2(physical, &mut properties2) };
    let properties = properties2.properties;
    let text =
        |name: Result<&std::ffi::CStr, _>| name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let version = properties.api_version;
    let (major, minor, patch) =
        (vk::api_version_major(version), vk::api_version_minor(version), vk::api_version_patch(version));
    DeviceInfo {
        name: text(properties.device_name_as_c_str()),
        driver: format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str())),
        api: format!("{major}.{minor}.{patch}"),
        cpu: properties.device_type == vk::PhysicalDeviceType::CPU,
        max_volume: properties.limits.max_image_dimension3_d,
        max_image: properties.limits.max_image_dimension2_d,
        max_anisotropy: if enabled.sampler_anisotropy == vk::TRUE {
            properties.limits.max_sampler_anisotropy
        } else {
            1.0
        },
        sample_shading: enabled.sample_rate_shading == vk::TRUE,
        counts_fragments: enabled.pipeline_statistics_query == vk::TRUE,
        timestamp_period: properties.limits.timestamp_period,
    }
}

/// A file name that changes with the device and its driver.
fn cache_name(instance: &ash::Instance, physical: vk::PhysicalDevice) -> String {
    // SAFETY: the physical device belongs to the instance, and both are alive.
    let properties = unsafe { instance.get_physical_device_properties(physical) };
    let uuid: String = properties.pipeline_cache_uuid.iter().map(|byte| format!("{byte:02x}")).collect();
    format!("pipelines-{:x}-{:x}-{:x}-{uuid}", properties.vendor_id, properties.device_id, properties.driver_version)
}
