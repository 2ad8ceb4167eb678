//! Messages of the validation layer, collected so that tests can fail on them.

use super::{GpuError, Named};
use ash::vk;
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex};

/// Messages of the validation layer, shared so that they outlive the device.
#[derive(Clone, Default)]
pub struct Messages(Arc<Mutex<Vec<String>>>);

impl Messages {
    /// Removes and returns the messages so far.
    pub fn take(&self) -> Vec<String> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner()))
    }

    fn push(&self, message: String) {
        log::error!("{message}");
        hypertexture_support::faults::note(&message);
        self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push(message);
    }
}

/// Debug messenger of an instance; must be destroyed before it.
pub(super) struct Messenger {
    functions: ash::ext::debug_utils::Instance,
    handle: vk::DebugUtilsMessengerEXT,
}

impl Messenger {
    pub(super) fn new(entry: &ash::Entry, instance: &ash::Instance, to: &Messages) -> Result<Messenger, GpuError> {
        let functions = ash::ext::debug_utils::Instance::new(entry, instance);
        // SAFETY: `instance` enabled VK_EXT_debug_utils; the pointer handed over is that of the Arc's content, which
        // the caller keeps alive beside the instance for longer than this registration.
        let handle = unsafe { functions.create_debug_utils_messenger(&create_info(to), None) }
            .named("vkCreateDebugUtilsMessengerEXT")?;
        Ok(Messenger { functions, handle })
    }

    /// Destroys the messenger.
    pub(super) fn destroy(&self) {
        // SAFETY: called once, from the drop of the device's owner, before the instance is destroyed.
        unsafe { self.functions.destroy_debug_utils_messenger(self.handle, None) };
    }
}

/// Subscribes to warnings and errors of validation.
pub(super) fn create_info(to: &Messages) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    use vk::{DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type};
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        .message_type(Type::VALIDATION | Type::PERFORMANCE)
        .pfn_user_callback(Some(on_message))
        .user_data(Arc::as_ptr(&to.0).cast_mut().cast())
}

// SAFETY: the signature is the one Vulkan prescribes; it is only registered together with the user data above.
unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    if data.is_null() || user.is_null() {
        return vk::FALSE;
    }
    // SAFETY: Vulkan passes valid data for the length of the call, whose strings end with a zero byte; the user data
    // is the content of an Arc that is alive while the registration is, counted up here for the length of the call.
    let (messages, id, text) = unsafe {
        let user = user.cast::<Mutex<Vec<String>>>().cast_const();
        Arc::increment_strong_count(user);
        let text = |pointer: *const std::ffi::c_char| match pointer.is_null() {
            true => String::new(),
            false => CStr::from_ptr(pointer).to_string_lossy().into_owned(),
        };
        (Messages(Arc::from_raw(user)), text((*data).p_message_id_name), text((*data).p_message))
    };
    // Ids of the layer; drivers may report through the same channel.
    if ["VUID-", "SYNC-", "UNASSIGNED-"].iter().any(|prefix| id.starts_with(prefix)) {
        messages.push(format!("{id}: {text}"));
    } else {
        log::warn!("{id}: {text}");
    }
    vk::FALSE
}
