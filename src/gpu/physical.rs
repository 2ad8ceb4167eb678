//! Choice of the physical device, its properties and features.

use super::commands::GROUP_SIDE;
use super::{Format, GpuError, Named};
use ash::vk;
use std::ffi::c_char;

/// Properties of a device.
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
    /// Whether each sample of a multisampled image can be shaded.
    pub sample_shading: bool,
    /// Whether compute shaders trace rays: in groups of 8 x 8, into images of 32-bit floats.
    pub computes: bool,
    /// Whether the device counts fragment shader invocations.
    pub counts_fragments: bool,
    /// Nanoseconds per timestamp tick; 0 where the queue has no timestamps.
    pub timestamp_period: f32,
}

impl DeviceInfo {
    /// Device and driver in one line.
    pub fn title(&self) -> String {
        format!("{} ({})", self.name, self.driver)
    }
}

/// Features that every device must have enabled, all mandatory in Vulkan 1.3. No extension is needed.
pub fn required_features() -> vk::PhysicalDeviceVulkan13Features<'static> {
    // maintenance4: a fragment stage may ignore outputs of the vertex stage.
    vk::PhysicalDeviceVulkan13Features::default().dynamic_rendering(true).synchronization2(true).maintenance4(true)
}

/// Features that are used if supported: anisotropic filters, sample shading, counts of fragments.
pub fn optional_features(supported: &vk::PhysicalDeviceFeatures) -> vk::PhysicalDeviceFeatures {
    vk::PhysicalDeviceFeatures::default()
        .sampler_anisotropy(supported.sampler_anisotropy == vk::TRUE)
        .sample_rate_shading(supported.sample_rate_shading == vk::TRUE)
        .pipeline_statistics_query(supported.pipeline_statistics_query == vk::TRUE)
}

pub(super) fn create_device(
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

pub(super) fn choose(
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
            let computes = device_info.computes && queues[family].queue_flags.contains(vk::QueueFlags::COMPUTE);
            let period = if queues[family].timestamp_valid_bits == 0 { 0.0 } else { device_info.timestamp_period };
            fitting.push((
                rank,
                physical,
                family as u32,
                DeviceInfo { timestamp_period: period, computes, ..device_info },
            ));
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
    /// Whether filter weights may have few bits: 8 on GPUs; drivers on the CPU use floats.
    pub fn filters_by_few_bits(&self) -> bool {
        !self.cpu
    }
}

/// Properties of a device with these features enabled.
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
        computes: computes(&properties.limits, |format| {
            // SAFETY: the physical device belongs to the instance.
            unsafe { instance.get_physical_device_format_properties(physical, format) }.optimal_tiling_features
        }),
        counts_fragments: enabled.pipeline_statistics_query == vk::TRUE,
        timestamp_period: properties.limits.timestamp_period,
    }
}

/// Whether the limits and format features of a device serve compute shaders of rays. Vulkan 1.3 asks for them.
fn computes(limits: &vk::PhysicalDeviceLimits, features: impl Fn(vk::Format) -> vk::FormatFeatureFlags) -> bool {
    let [x, y, _] = limits.max_compute_work_group_size;
    let has_groups = x.min(y) >= GROUP_SIDE && limits.max_compute_work_group_invocations >= GROUP_SIDE * GROUP_SIDE;
    let is_stored = |format: &Format| features(format.vk()).contains(vk::FormatFeatureFlags::STORAGE_IMAGE);
    has_groups && Format::STORED.iter().all(is_stored)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_groups_or_images_that_store_nothing_leave_rays_to_fragment_shaders() {
        let limits = |invocations, size| vk::PhysicalDeviceLimits {
            max_compute_work_group_invocations: invocations,
            max_compute_work_group_size: size,
            ..Default::default()
        };
        let (least, all) = (limits(128, [128, 128, 64]), vk::FormatFeatureFlags::STORAGE_IMAGE); // of Vulkan 1.3
        assert!(computes(&least, |_| all));
        assert!(!computes(&limits(63, [128; 3]), |_| all) && !computes(&limits(128, [64, 4, 1]), |_| all));
        let lacking = |missing| move |format| if format == missing { vk::FormatFeatureFlags::default() } else { all };
        for format in Format::STORED {
            assert!(!computes(&least, lacking(format.vk())), "{format:?}");
        }
    }
}
