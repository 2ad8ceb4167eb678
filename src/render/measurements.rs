//! A rendered picture and the measurements of its rendering.

use crate::render::cells::CellStats;
use crate::render::inputs::{ImageInfo, Sparse};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A picture and its measurements.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Premultiplied linear RGBA, row by row from the top.
    pub pixels: Vec<[f32; 4]>,
    /// Measurements of its rendering.
    pub measurements: Measurements,
}

/// Measurements of a frame.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Measurements {
    /// Slots and modules of the program.
    pub modules: String,
    /// Whether compute shaders traced the rays.
    #[serde(default)]
    pub is_compute: bool,
    /// Whether rays found and shaded matter in one phase.
    #[serde(default)]
    pub is_direct: bool,
    /// Files of its objects besides those that the scene names.
    #[serde(default)]
    pub others: Vec<PathBuf>,
    /// Whether the program was linked at build time.
    pub shipped: bool,
    /// Parts that the scene did not need.
    #[serde(deserialize_with = "crate::render::variant::parts")]
    pub left_out: Vec<&'static str>,
    /// Octaves of the turbulence: effective and requested; `None` without turbulence.
    pub octaves: Option<[u32; 2]>,
    /// Slices, or samples of a ray at most.
    pub slices: u32,
    /// Distance between slices or samples, object units.
    pub step: f32,
    /// Shaded fragments including those of the early-exit passes, if the device counts them.
    pub fragments: Option<u64>,
    /// Time to link, compile and first use the program, milliseconds.
    pub compile_ms: f64,
    /// Time of the slices or rays on the device, milliseconds.
    pub gpu_ms: f64,
    /// Time of the shadow volume on the device, milliseconds; `None` without shadows, 0 for a reused volume.
    pub shadow_ms: Option<f64>,
    /// Time of a reused shadow volume in its own picture, milliseconds.
    #[serde(default)]
    pub shadow_before_ms: f64,
    /// Longest submission, milliseconds.
    pub longest_ms: f64,
    /// Wall-clock time except loading the subject, milliseconds; includes the preparation.
    pub total_ms: f64,
    /// CPU time of all threads of this process, milliseconds; `None` if the system does not report it.
    #[serde(default)]
    pub processor_ms: Option<f64>,
    /// Setting in place of one that the device cannot serve, in words.
    #[serde(default)]
    pub replaced: Option<String>,
    /// Images that the program reads.
    #[serde(default)]
    pub images: Vec<ImageInfo>,
    /// Bytes of images on the device.
    pub device_bytes: u64,
    /// Memory saved by bricks; `None` for a dense volume.
    pub sparse: Option<Sparse>,
    /// Statistics of empty cells; `None` if the picture would not profit from cells.
    #[serde(default)]
    pub cells: Option<CellStats>,
    /// Largest error of a stored distance, object units; 0 for a formula.
    pub quantization: f32,
    /// Radius beyond which radial warps are clamped although their formula has matter there; object units.
    pub held_beyond: Option<f32>,
}

impl Measurements {
    /// Time on the device, milliseconds.
    pub fn device_ms(&self) -> f64 {
        self.gpu_ms + self.shadow_ms.unwrap_or(0.0)
    }

    /// Time on the device including a reused shadow volume, milliseconds.
    pub fn alone_ms(&self) -> f64 {
        self.device_ms() + self.shadow_before_ms
    }
}
