//! Vulkan, and the only `unsafe` of the crate.
//!
//! Role: small safe owners around the parts of Vulkan 1.3 that the renderer uses (dynamic rendering, synchronization2),
//! through `ash` and `gpu-allocator`. This layer knows pixels, buffers and pipelines, but no scene. `docs/notes/drivers.md`
//! lists the quirks of drivers.
//! Invariants:
//! - every resource frees itself and keeps the [`Gpu`] alive until then, so that the device is destroyed last;
//! - [`Gpu::submit`] waits for its submission, so resources that its commands borrow outlive their use; a device that does not
//!   finish in time is leaked with all its resources;
//! - a host waits for its own commands: a [`Recording`] owns the resources that they use;
//! - the CPU reads device data through [`Image::read`], which makes the writes visible first.

#![allow(unsafe_code)]

#[cfg(test)]
pub(crate) mod allocations;
mod bind_set;
mod buffer;
#[cfg(feature = "window")]
mod canvas;
mod commands;
mod covered;
mod device;
#[cfg(feature = "window")]
mod encoder;
pub mod ending;
mod error;
mod faults;
mod format;
mod host;
mod image;
mod instance;
mod memory;
mod messages;
mod physical;
mod pipeline;
mod sampler;
mod submit;
#[cfg(feature = "window")]
mod surface;
#[cfg(test)]
mod validation_tests;
#[cfg(feature = "window")]
mod window;

pub use ash;
pub use bind_set::{BindSet, Binding, BindingKind, Resource};
pub use buffer::{Buffer, BufferUse};
#[cfg(feature = "window")]
pub use canvas::{Batch, Canvas, CanvasTexture, Presented, Vertex};
pub use commands::{Area, Commands, Draw, Load, Target};
pub use device::{Gpu, Options};
#[cfg(feature = "window")]
pub use encoder::Encoder;
pub use error::GpuError;
use error::Named;
pub use format::Format;
pub use host::{HostCommands, HostDevice, HostTarget, Recording};
pub use image::{Dimension, Image, ImageUse, Uploads};
pub use messages::Messages;
pub use physical::{DeviceInfo, optional_features, required_features};
pub use pipeline::{Blend, Marks, Pipeline, PipelineDescription};
pub use sampler::{Address, Sampler};
pub use submit::Submitted;

#[cfg(feature = "window")]
pub use window::{WindowHandle, has_keyboard_data, has_library, on_broken_display};
