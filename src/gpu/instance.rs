//! The instance: loader, validation layer and its messages.

use super::messages::{Messages, Messenger, create_info};
use super::{GpuError, Named};
use ash::vk;
use hypertexture_support::memory;
use std::ffi::{CStr, c_char};
use std::thread::available_parallelism;

/// MiB of address space for the loader, lavapipe and LLVM, and for each of their threads. With less, they end the process
/// (`docs/notes/drivers.md`).
const ADDRESS_SPACE: [u64; 2] = [560, 8];

/// Checks that the address space is large enough for a driver.
fn check_address_space() -> Result<(), GpuError> {
    let [driver, thread] = ADDRESS_SPACE;
    let needed = driver + thread * available_parallelism().map_or(1, |count| count.get() as u64);
    match memory::addresses().map(|bytes| bytes >> 20) {
        Some(left) if left < needed => Err(GpuError::Addresses { left, needed }),
        _ => Ok(()),
    }
}

/// The Vulkan instance, with its debug messenger and the surface of its window, if any.
pub(super) struct Instance {
    #[cfg(feature = "window")]
    pub(super) surface: Option<super::window::WindowSurface>,
    pub(super) raw: ash::Instance,
    /// Whether a host owns and destroys it.
    hosted: bool,
    messenger: Option<Messenger>,
    pub(super) messages: Messages,
    pub(super) entry: ash::Entry,
}

impl Instance {
    /// Creates an instance with these extensions.
    pub(super) fn new(validation: bool, extensions: &[*const c_char]) -> Result<Instance, GpuError> {
        #[cfg(test)]
        assert!(
            !validation || hypertexture_support::validation_lock::ValidationLock::is_held(),
            "a test with validation begins with ValidationLock::acquire()"
        );
        let entry = Instance::loader()?;
        let messages = Messages::default();
        let raw = create_instance(&entry, validation, extensions, &messages)?;
        let mut instance = Instance {
            #[cfg(feature = "window")]
            surface: None,
            raw,
            hosted: false,
            messenger: None,
            messages,
            entry,
        };
        if validation {
            instance.messenger = Some(Messenger::new(&instance.entry, &instance.raw, &instance.messages)?);
        }
        Ok(instance)
    }

    /// The Vulkan library of the system.
    pub(super) fn loader() -> Result<ash::Entry, GpuError> {
        check_address_space()?;
        // SAFETY: the library has no requirements for loading.
        unsafe { ash::Entry::load() }.map_err(|error| GpuError::NoLoader(error.to_string()))
    }

    /// Wraps the instance of a host, which has its own messages.
    pub(super) fn of_host(entry: ash::Entry, raw: ash::Instance) -> Instance {
        Instance {
            #[cfg(feature = "window")]
            surface: None,
            raw,
            hosted: true,
            messenger: None,
            messages: Messages::default(),
            entry,
        }
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        #[cfg(feature = "window")]
        drop(self.surface.take());
        if let Some(messenger) = &self.messenger {
            messenger.destroy();
        }
        // SAFETY: all objects of the instance are destroyed: their owners are earlier fields, or keep it alive.
        unsafe {
            if !self.hosted {
                self.raw.destroy_instance(None);
            }
        }
    }
}

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Whether the loader hides devices that are not quite Vulkan, such as MoltenVK, unless it is asked for them.
fn hides_devices(entry: &ash::Entry) -> Result<bool, GpuError> {
    // SAFETY: the loader is alive.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(None) }
        .named("vkEnumerateInstanceExtensionProperties")?;
    Ok(extensions.iter().any(|of| of.extension_name_as_c_str() == Ok(ash::khr::portability_enumeration::NAME)))
}

/// Whether the layer has settings. Such versions check accesses by shaders only on demand (`docs/notes/drivers.md`).
fn layer_has_settings(entry: &ash::Entry) -> Result<bool, GpuError> {
    // SAFETY: the loader is alive and the layer exists.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(Some(LAYER)) }
        .named("vkEnumerateInstanceExtensionProperties")?;
    Ok(extensions.iter().any(|of| of.extension_name_as_c_str() == Ok(ash::ext::layer_settings::NAME)))
}

fn create_instance(
    entry: &ash::Entry,
    validation: bool,
    extensions: &[*const c_char],
    messages: &Messages,
) -> Result<ash::Instance, GpuError> {
    let application = vk::ApplicationInfo::default().application_name(c"hypertexture").api_version(vk::API_VERSION_1_3);
    let mut info = vk::InstanceCreateInfo::default().application_info(&application);
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let yes = vk::TRUE;
    let mut accesses = [vk::LayerSettingEXT::default()
        .layer_name(LAYER)
        .setting_name(c"syncval_shader_accesses_heuristic")
        .ty(vk::LayerSettingTypeEXT::BOOL32)];
    (accesses[0].value_count, accesses[0].p_values) = (1, (&raw const yes).cast()); // `values` counts bytes
    let mut settings = vk::LayerSettingsCreateInfoEXT::default().settings(&accesses);
    let mut messenger = create_info(messages);
    let layers = [LAYER.as_ptr()];
    let mut extensions = extensions.to_vec();
    if hides_devices(entry)? {
        extensions.push(ash::khr::portability_enumeration::NAME.as_ptr());
        info = info.flags(vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR);
    }
    if validation {
        // SAFETY: the loader is alive.
        let present =
            unsafe { entry.enumerate_instance_layer_properties() }.named("vkEnumerateInstanceLayerProperties")?;
        if !present.iter().any(|layer| layer.layer_name_as_c_str() == Ok(LAYER)) {
            return Err(GpuError::NoValidation);
        }
        extensions.push(ash::ext::debug_utils::NAME.as_ptr());
        info = info.enabled_layer_names(&layers);
        info = info.push_next(&mut features).push_next(&mut messenger);
        if layer_has_settings(entry)? {
            extensions.push(ash::ext::layer_settings::NAME.as_ptr());
            info = info.push_next(&mut settings);
        }
    }
    info = info.enabled_extension_names(&extensions);
    // SAFETY: every pointer in `info` outlives the call; the names of the extensions are those of ash.
    unsafe { entry.create_instance(&info, None) }.map_err(|result| match result {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => GpuError::NoDriver,
        vk::Result::ERROR_EXTENSION_NOT_PRESENT => GpuError::NoPresent,
        result => GpuError::Call { call: "vkCreateInstance", result },
    })
}
