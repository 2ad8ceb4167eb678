//! The instance: loader, validation layer and its messages.

use super::messages::{Messages, Messenger, create_info};
use super::{GpuError, Named};
use ash::vk;

/// Owner of the Vulkan instance and of the registration of its messages.
pub(super) struct Instance {
    pub(super) raw: ash::Instance,
    messenger: Option<Messenger>,
    pub(super) messages: Messages,
    _entry: ash::Entry,
}

impl Instance {
    pub(super) fn new(validation: bool) -> Result<Instance, GpuError> {
        // SAFETY: the loader is the system's Vulkan library, which has no requirement on when it is loaded.
        let entry = unsafe { ash::Entry::load() }.map_err(|error| GpuError::NoLoader(error.to_string()))?;
        let messages = Messages::default();
        let raw = create_instance(&entry, validation, &messages)?;
        let mut instance = Instance { raw, messenger: None, messages, _entry: entry };
        if validation {
            instance.messenger = Some(Messenger::new(&instance._entry, &instance.raw, &instance.messages)?);
        }
        Ok(instance)
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some(messenger) = &self.messenger {
            messenger.destroy();
        }
        // SAFETY: all that was made from the instance is gone: its owners are fields before it, or hold it alive.
        unsafe { self.raw.destroy_instance(None) };
    }
}

fn create_instance(entry: &ash::Entry, validation: bool, messages: &Messages) -> Result<ash::Instance, GpuError> {
    const LAYER: &std::ffi::CStr = c"VK_LAYER_KHRONOS_validation";
    let application = vk::ApplicationInfo::default().application_name(c"hypertexture").api_version(vk::API_VERSION_1_3);
    let mut info = vk::InstanceCreateInfo::default().application_info(&application);
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let mut messenger = create_info(messages);
    let layers = [LAYER.as_ptr()];
    let extensions = [ash::ext::debug_utils::NAME.as_ptr()];
    if validation {
        // SAFETY: the loader is alive.
        let present =
            unsafe { entry.enumerate_instance_layer_properties() }.named("vkEnumerateInstanceLayerProperties")?;
        if !present.iter().any(|layer| layer.layer_name_as_c_str() == Ok(LAYER)) {
            return Err(GpuError::NoValidation);
        }
        info = info.enabled_layer_names(&layers).enabled_extension_names(&extensions);
        info = info.push_next(&mut features).push_next(&mut messenger);
    }
    // SAFETY: every pointer in `info` outlives the call.
    unsafe { entry.create_instance(&info, None) }.map_err(|result| match result {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => GpuError::NoDriver,
        result => GpuError::Call { call: "vkCreateInstance", result },
    })
}
