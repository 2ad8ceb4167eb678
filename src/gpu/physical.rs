//! Choice of the physical device, its properties and features.

use super::commands::GROUP_SIDE;
use super::{Format, GpuError, Named};
use ash::vk;
use std::ffi::c_char;

/// Properties of a device.
#[derive(Clone, Debug, Default, PartialEq)]
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
    /// Largest 1D image, texels.
    pub max_line: u32,
    /// Most sampled images of a stage.
    pub max_sampled_images: u32,
    /// Most samplers of a stage.
    pub max_samplers: u32,
    /// Formats of 16 bits that shaders cannot read: their texels are stored as 32-bit floats.
    pub unread: Vec<Format>,
    /// Formats that the device cannot filter linearly, as they are stored.
    pub unfiltered: Vec<Format>,
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
    /// Bits of a timestamp; the higher ones are 0, and the count begins anew.
    pub timestamp_bits: u32,
}

impl DeviceInfo {
    /// Whether derivatives are wrong along the edges of triangles: those of llvmpipe from Mesa 25 on.
    pub fn misses_neighbors(&self) -> bool {
        let version = self.driver.strip_prefix("llvmpipe Mesa ").and_then(|rest| rest.split('.').next()?.parse().ok());
        version.is_some_and(|major: u32| major >= 25)
    }

    /// Device and driver in one line.
    pub fn title(&self) -> String {
        format!("{} ({})", self.name, self.driver)
    }
}

impl DeviceInfo {
    /// Adds the properties of the queue family that is used.
    pub(super) fn with_queue(mut self, family: &vk::QueueFamilyProperties) -> DeviceInfo {
        self.computes &= family.queue_flags.contains(vk::QueueFlags::COMPUTE);
        self.timestamp_bits = family.timestamp_valid_bits;
        if self.timestamp_bits == 0 {
            self.timestamp_period = 0.0;
        }
        self
    }

    /// Milliseconds between two timestamps, also where the count began anew in between.
    pub(super) fn milliseconds(&self, ticks: [u64; 2]) -> f64 {
        let mask = u64::MAX.checked_shr(64 - self.timestamp_bits.min(64)).unwrap_or(0);
        (ticks[1].wrapping_sub(ticks[0]) & mask) as f64 * f64::from(self.timestamp_period) * 1e-6
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
    let (supported, present) = unsafe {
        (
            instance.get_physical_device_features(physical),
            instance.enumerate_device_extension_properties(physical).named("vkEnumerateDeviceExtensionProperties")?,
        )
    };
    let mut extensions = extensions.to_vec();
    // A device that is not quite Vulkan, such as MoltenVK, wants to be told that its user knows.
    const SUBSET: &std::ffi::CStr = ash::khr::portability_subset::NAME;
    if present.iter().any(|own| own.extension_name_as_c_str() == Ok(SUBSET)) {
        extensions.push(SUBSET.as_ptr());
    }
    let (features, mut features13) = (optional_features(&supported), required_features());
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_features(&features)
        .enabled_extension_names(&extensions)
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
    let mut candidates = Vec::new();
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
        let draws = |family: &usize| queues[*family].queue_flags.contains(vk::QueueFlags::GRAPHICS);
        let family = (0..queues.len()).find(|family| draws(family) && fits(physical, *family as u32));
        let named = device_info.name.to_lowercase().contains(&wanted.to_lowercase());
        let is_new = properties.api_version >= vk::API_VERSION_1_3;
        candidates.push(Candidate {
            name: device_info.name.clone(),
            api: device_info.api.clone(),
            is_new,
            has_queue: family.is_some(),
        });
        if let (Some(family), true, true) = (family, named, is_new) {
            let rank = match properties.device_type {
                vk::PhysicalDeviceType::DISCRETE_GPU => 0,
                vk::PhysicalDeviceType::INTEGRATED_GPU => 1,
                vk::PhysicalDeviceType::VIRTUAL_GPU => 2,
                _ => 3,
            };
            fitting.push((rank, physical, family as u32, device_info.with_queue(&queues[family])));
        }
    }
    let best = fitting.into_iter().min_by_key(|candidate| candidate.0);
    let (_, physical, family, device_info) = best.ok_or_else(|| no_device(wanted, &candidates))?;
    Ok((physical, family, device_info))
}

/// A device that the driver reports.
struct Candidate {
    name: String,
    api: String,
    /// Whether it has Vulkan 1.3.
    is_new: bool,
    /// Whether it has a queue that serves.
    has_queue: bool,
}

/// Why none of the devices serves.
fn no_device(wanted: &str, candidates: &[Candidate]) -> GpuError {
    let is_named = |own: &&Candidate| own.name.to_lowercase().contains(&wanted.to_lowercase());
    let names = |serves: &dyn Fn(&Candidate) -> bool| -> String {
        let serving = candidates.iter().filter(|own| serves(own)).map(|own| own.name.as_str());
        serving.collect::<Vec<_>>().join(", ")
    };
    // Of several with the name, the newest says what is missing.
    match candidates.iter().filter(is_named).max_by_key(|own| own.is_new) {
        Some(Candidate { name, is_new: true, .. }) => GpuError::NoQueue { device: name.clone() },
        Some(Candidate { name, api, .. }) => GpuError::OldDevice { device: name.clone(), api: api.clone() },
        None if candidates.is_empty() => GpuError::NoDriver,
        None => match names(&|own| own.is_new && own.has_queue) {
            serving if serving.is_empty() => match names(&|own| own.is_new) {
                new if new.is_empty() => GpuError::OldDevice { device: names(&|_| true), api: "below 1.3".into() },
                new => GpuError::NoQueue { device: new },
            },
            serving => GpuError::NoDevice { wanted: wanted.into(), found: serving },
        },
    }
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
    let features = |format: Format| {
        // SAFETY: the physical device belongs to the instance.
        unsafe { instance.get_physical_device_format_properties(physical, format.vk()) }.optimal_tiling_features
    };
    let reads = |format: &Format| features(*format).contains(vk::FormatFeatureFlags::SAMPLED_IMAGE);
    let unread: Vec<Format> =
        Format::SAMPLED.into_iter().filter(|own| own.widened().is_some() && !reads(own)).collect();
    let stored = |format: Format| format.widened().filter(|_| unread.contains(&format)).unwrap_or(format);
    let filters =
        |format: &Format| features(stored(*format)).contains(vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR);
    let unfiltered = Format::SAMPLED.into_iter().filter(|format| !filters(format)).collect();
    let version = properties.api_version;
    let (major, minor, patch) =
        (vk::api_version_major(version), vk::api_version_minor(version), vk::api_version_patch(version));
    DeviceInfo {
        name: text(properties.device_name_as_c_str()),
        driver: format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str()))
            .trim()
            .into(),
        api: format!("{major}.{minor}.{patch}"),
        cpu: properties.device_type == vk::PhysicalDeviceType::CPU,
        max_volume: properties.limits.max_image_dimension3_d,
        max_image: properties.limits.max_image_dimension2_d,
        max_line: properties.limits.max_image_dimension1_d,
        max_sampled_images: properties.limits.max_per_stage_descriptor_sampled_images,
        max_samplers: properties.limits.max_per_stage_descriptor_samplers,
        unfiltered,
        unread,
        max_anisotropy: if enabled.sampler_anisotropy == vk::TRUE {
            properties.limits.max_sampler_anisotropy
        } else {
            1.0
        },
        sample_shading: enabled.sample_rate_shading == vk::TRUE,
        computes: computes(&properties.limits, features),
        counts_fragments: enabled.pipeline_statistics_query == vk::TRUE,
        timestamp_period: properties.limits.timestamp_period,
        timestamp_bits: u64::BITS,
    }
}

/// Whether the limits and format features of a device serve compute shaders of rays. Vulkan 1.3 asks for them.
fn computes(limits: &vk::PhysicalDeviceLimits, features: impl Fn(Format) -> vk::FormatFeatureFlags) -> bool {
    let [x, y, _] = limits.max_compute_work_group_size;
    let has_groups = x.min(y) >= GROUP_SIDE && limits.max_compute_work_group_invocations >= GROUP_SIDE * GROUP_SIDE;
    let is_stored = |format: &Format| features(*format).contains(vk::FormatFeatureFlags::STORAGE_IMAGE);
    has_groups && Format::STORED.iter().all(is_stored)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weak_compute_limits_leave_rays_to_fragment_shaders() {
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
            assert!(!computes(&least, lacking(format)), "{format:?}");
        }
    }

    #[test]
    fn a_missing_device_has_a_remedy_that_can_work() {
        let device = |name: &str, api: &str, has_queue| Candidate {
            name: name.into(),
            api: api.into(),
            is_new: api.starts_with("1.3"),
            has_queue,
        };
        let said = |wanted: &str, all: &[Candidate]| no_device(wanted, all).to_string();
        let old = [device("Iris 6100", "1.2.0", true)];
        for wanted in ["", "iris"] {
            let text = said(wanted, &old);
            assert!(text.starts_with("Iris 6100 has Vulkan 1.2.0, and 1.3 is needed: update its driver"), "{text}");
            assert!(text.contains("llvmpipe") && text.contains("apt") && text.contains("dnf"), "{text}");
        }
        let both = [device("Iris 6100", "1.2.0", true), device("llvmpipe", "1.3.230", true)];
        assert!(said("iris", &both).contains("1.3 is needed"));
        assert!(
            said("radeon", &both).contains("found: llvmpipe; set HYPERTEXTURE_DEVICE"),
            "an old device is no remedy"
        );
        assert!(said("radeon", &old).contains("1.3 is needed"));
        for wanted in ["", "radeon"] {
            let text = said(wanted, &[device("compute card", "1.3.0", false), device("Iris 6100", "1.2.0", true)]);
            assert!(text.starts_with("compute card has no queue for graphics"), "{text}");
        }
        assert_eq!(no_device("", &[]), GpuError::NoDriver);
    }

    #[test]
    fn derivatives_are_right_before_mesa_25() {
        let of = |driver: &str| DeviceInfo { driver: driver.into(), ..DeviceInfo::default() }.misses_neighbors();
        assert!(of("llvmpipe Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)") && of("llvmpipe Mesa 26.1.6 (LLVM 19.1.7)"));
        assert!(!of("llvmpipe Mesa 22.3.6 (LLVM 15.0.6)") && !of("SwiftShader driver") && !of("radv Mesa 25.0.7"));
    }

    #[test]
    fn timestamps_of_few_bits_begin_anew() {
        let of = |timestamp_bits| DeviceInfo { timestamp_bits, timestamp_period: 2.0, ..DeviceInfo::default() };
        assert_eq!(of(64).milliseconds([u64::MAX - 499_999, 500_000]), 2.0);
        assert_eq!(of(36).milliseconds([(1 << 36) - 1_000_000, 1_000_000]), 4.0);
        assert_eq!(of(36).milliseconds([5_000_000, 6_000_000]), 2.0);
        assert_eq!(of(0).milliseconds([1, 2]), 0.0);
    }
}
