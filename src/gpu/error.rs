//! Errors of Vulkan and of the device.

use ash::vk;

/// Commands that install a Vulkan driver, also without a GPU.
#[cfg(target_os = "macos")]
const DRIVER: &str = "with Homebrew: brew install molten-vk vulkan-loader";
#[cfg(not(target_os = "macos"))]
const DRIVER: &str = "also without a GPU; Debian, Ubuntu: sudo apt install libvulkan1 mesa-vulkan-drivers; Fedora: sudo dnf install \
                      vulkan-loader mesa-vulkan-drivers; Arch: sudo pacman -S vulkan-icd-loader vulkan-swrast";

/// Errors of Vulkan and of the device.
#[allow(missing_docs, reason = "the names of the fields describe them")]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// The Vulkan loader is not installed.
    #[error("no Vulkan loader ({0}); install one and a driver, {DRIVER}")]
    NoLoader(String),
    /// No Vulkan driver is installed.
    #[error("no Vulkan driver; install one, {DRIVER}")]
    NoDriver,
    /// No device has the name.
    #[error("no device whose name contains `{wanted}`; found: {found}; set HYPERTEXTURE_DEVICE to one of them")]
    NoDevice { wanted: String, found: String },
    /// The device has an older version of Vulkan.
    #[error(
        "{device} has Vulkan {api}, and 1.3 is needed: update its driver, or set HYPERTEXTURE_DEVICE to another device, such as \
         llvmpipe ({DRIVER})"
    )]
    OldDevice { device: String, api: String },
    /// The device has no queue for graphics.
    #[error(
        "{device} has no queue for graphics: set HYPERTEXTURE_DEVICE to another device, such as llvmpipe ({DRIVER})"
    )]
    NoQueue { device: String },
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
        "the Vulkan validation layer is not installed; Debian, Ubuntu: sudo apt install vulkan-validationlayers; Fedora: sudo dnf \
         install vulkan-validation-layers; Arch: sudo pacman -S vulkan-validation-layers"
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
    #[error("the device did not finish `{what}` within {seconds} s: it hangs, or lower quality.samples or image.size")]
    Timeout { what: String, seconds: u64 },
    /// The program was asked to end while the device worked.
    #[error("interrupted: the device had not finished `{what}`")]
    Interrupted { what: String },
    /// A Vulkan call failed.
    #[error("{call} failed: {result}")]
    Call { call: &'static str, result: vk::Result },
}

impl GpuError {
    /// Whether the device is lost with everything on it, or hangs and is left as it is. Another one may be opened.
    pub fn is_lost(&self) -> bool {
        matches!(self, GpuError::Call { result: vk::Result::ERROR_DEVICE_LOST, .. }) || self.is_timeout()
    }

    /// Whether the device did not finish in time.
    pub fn is_timeout(&self) -> bool {
        matches!(self, GpuError::Timeout { .. })
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
