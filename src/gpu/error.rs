//! Errors of Vulkan and of the device.

use ash::vk;

/// Errors of Vulkan and of the device.
#[allow(missing_docs, reason = "the names of the fields describe them")]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// The Vulkan loader is not installed.
    #[error("no Vulkan loader ({0}); on Debian or Ubuntu: sudo apt install libvulkan1 mesa-vulkan-drivers")]
    NoLoader(String),
    /// No Vulkan driver is installed.
    #[error("no Vulkan driver; on Debian or Ubuntu, also without a GPU: sudo apt install mesa-vulkan-drivers")]
    NoDriver,
    /// No suitable device.
    #[error(
        "no Vulkan 1.3 device whose name contains `{wanted}`; found: {found}; set HYPERTEXTURE_DEVICE to one of them"
    )]
    NoDevice { wanted: String, found: String },
    /// The address space of this process is too small for a driver.
    #[error(
        "{left} MiB of addresses are left to this process (`ulimit -v`), and a Vulkan driver takes some {needed} MiB here; raise \
         that limit"
    )]
    Addresses { left: u64, needed: u64 },
    /// No device can draw into a window.
    #[error("no Vulkan driver here can draw into a window; rendering to a file needs none")]
    NoPresent,
    /// The window system provides no handle.
    #[error("the window cannot be drawn into: {0}")]
    Window(String),
    /// The validation layer is requested and not installed.
    #[error(
        "the Vulkan validation layer is not installed; on Debian or Ubuntu: sudo apt install vulkan-validationlayers"
    )]
    NoValidation,
    /// The device lacks something that the settings need.
    #[error("{device} cannot do {what}: {remedy}")]
    Unsupported { device: String, what: String, remedy: String },
    /// An image or buffer is larger than the device allows.
    #[error("{what} needs {asked}, and {device} allows {limit}; lower the resolution")]
    TooLarge { device: String, what: String, asked: String, limit: String },
    /// Device memory is exhausted.
    #[error("{what} needs {bytes} bytes of device memory, which could not be had: {reason}; lower the resolution")]
    Memory { what: String, bytes: u64, reason: String },
    /// The device did not finish in time.
    #[error("the device did not finish `{what}` within {seconds} s; lower quality.samples or image.size")]
    Timeout { what: String, seconds: u64 },
    /// A Vulkan call failed.
    #[error("{call} failed: {result}")]
    Call { call: &'static str, result: vk::Result },
}

impl GpuError {
    /// Whether the device is lost with everything on it. Another one may be opened.
    pub fn is_lost(&self) -> bool {
        matches!(self, GpuError::Call { result: vk::Result::ERROR_DEVICE_LOST, .. })
    }

    /// Error of a call on a lost device.
    pub fn lost() -> GpuError {
        GpuError::Call { call: "vkQueueSubmit2", result: vk::Result::ERROR_DEVICE_LOST }
    }
}

/// Adds the name of the failed call to its result.
pub(super) trait Named<T> {
    fn named(self, call: &'static str) -> Result<T, GpuError>;
}

impl<T> Named<T> for Result<T, vk::Result> {
    fn named(self, call: &'static str) -> Result<T, GpuError> {
        self.map_err(|result| GpuError::Call { call, result })
    }
}
