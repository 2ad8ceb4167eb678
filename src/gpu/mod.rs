//! Vulkan, and the only `unsafe` of the crate.
//!
//! Role: small safe owners around the parts of Vulkan 1.3 that the renderer uses (dynamic rendering,
//! synchronization2), through `ash` and `gpu-allocator`. This layer knows pixels, buffers and pipelines, and no scene.
//! Invariants:
//! - every owner frees itself, and holds the [`Gpu`] alive until then: the device goes last;
//! - [`Gpu::submit`] waits for what it submitted, so a resource borrowed by its commands outlives their use; a device that
//!   does not finish in time is left alone, with all that was made from it;
//! - commands of a host are waited for by the host: a [`Recording`] owns what they use;
//! - a host read of device data goes through [`Image::read`], which makes the writes visible first.

#![allow(unsafe_code)]

mod commands;
mod device;
mod faults;
mod format;
mod host;
mod instance;
mod memory;
mod messages;
#[cfg(feature = "window")]
mod overlay;
mod pipeline;
mod sampler;
#[cfg(feature = "window")]
mod surface;
#[cfg(test)]
mod validation_tests;
#[cfg(feature = "window")]
mod window;

pub use ash;
pub use commands::{Area, Commands, Draw, Load, Submitted, Target};
pub use device::{DeviceInfo, Gpu, Options, optional_features, required_features};
pub use format::Format;
pub use host::{HostCommands, HostDevice, HostTarget, Recording};
pub use memory::{Buffer, BufferUse, Dimension, Image, ImageUse, Uploads};
pub use messages::Messages;
#[cfg(feature = "window")]
pub use overlay::{Canvas, Presented};
pub use pipeline::{BindSet, Binding, BindingKind, Blend, Marks, Pipeline, PipelineDescription, Resource};
pub use sampler::{Address, Sampler};

#[cfg(feature = "window")]
pub use window::{WindowHandle, has_keyboard_data, has_library, on_broken_display};

use ash::vk;

/// Why the device does not do what is asked of it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// The Vulkan loader is not installed.
    #[error("no Vulkan loader ({0}); on Debian or Ubuntu: sudo apt install libvulkan1 mesa-vulkan-drivers")]
    NoLoader(String),
    /// No Vulkan driver is installed.
    #[error("no Vulkan driver; on Debian or Ubuntu, also without a GPU: sudo apt install mesa-vulkan-drivers")]
    NoDriver,
    /// No device fits.
    #[error(
        "no Vulkan 1.3 device whose name contains `{wanted}`; found: {found}; set HYPERTEXTURE_DEVICE to one of them"
    )]
    NoDevice {
        /// Part of a name; empty for any.
        wanted: String,
        /// Names of the devices present.
        found: String,
    },
    /// The addresses of this process are limited to fewer than a driver takes.
    #[error(
        "{left} MiB of addresses are left to this process (`ulimit -v`), and a Vulkan driver takes some {needed} MiB here; raise \
         that limit"
    )]
    Addresses {
        /// What is left.
        left: u64,
        /// What is needed.
        needed: u64,
    },
    /// No device can draw into a window.
    #[error("no Vulkan driver here can draw into a window; rendering to a file needs none")]
    NoPresent,
    /// The window system gives no handle.
    #[error("the window cannot be drawn into: {0}")]
    Window(String),
    /// The validation layer is asked for and not installed.
    #[error(
        "the Vulkan validation layer is not installed; on Debian or Ubuntu: sudo apt install vulkan-validationlayers"
    )]
    NoValidation,
    /// The device lacks something the settings ask for.
    #[error("{device} cannot do {what}: {remedy}")]
    Unsupported {
        /// The device.
        device: String,
        /// What is missing.
        what: String,
        /// What to do.
        remedy: String,
    },
    /// An image or buffer is larger than the device allows.
    #[error("{what} needs {asked}, and {device} allows {limit}; lower the resolution")]
    TooLarge {
        /// The device.
        device: String,
        /// Name of the resource.
        what: String,
        /// Size asked for.
        asked: String,
        /// The limit.
        limit: String,
    },
    /// Device memory is exhausted.
    #[error("{what} needs {bytes} bytes of device memory, which could not be had: {reason}; lower the resolution")]
    Memory {
        /// Name of the resource.
        what: String,
        /// Bytes asked for.
        bytes: u64,
        /// What the allocator says.
        reason: String,
    },
    /// The device did not finish in time.
    #[error("the device did not finish `{what}` within {seconds} s; lower quality.samples or image.size")]
    Timeout {
        /// Name of the work.
        what: String,
        /// The limit.
        seconds: u64,
    },
    /// A Vulkan call failed.
    #[error("{call} failed: {result}")]
    Call {
        /// The call.
        call: &'static str,
        /// Its result.
        result: vk::Result,
    },
}

impl GpuError {
    /// Whether the device is gone, with all that was on it: another one may be opened.
    pub fn is_lost(&self) -> bool {
        matches!(self, GpuError::Call { result: vk::Result::ERROR_DEVICE_LOST, .. })
    }

    /// What a call says when the device is gone.
    pub fn lost() -> GpuError {
        GpuError::Call { call: "vkQueueSubmit2", result: vk::Result::ERROR_DEVICE_LOST }
    }
}

/// Names the call that failed.
trait Named<T> {
    fn named(self, call: &'static str) -> Result<T, GpuError>;
}

impl<T> Named<T> for Result<T, vk::Result> {
    fn named(self, call: &'static str) -> Result<T, GpuError> {
        self.map_err(|result| GpuError::Call { call, result })
    }
}
