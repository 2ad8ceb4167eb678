//! A rendered picture and the measurements of its rendering.

use crate::render::cells::CellStats;
use crate::render::inputs::{ImageInfo, Sparse};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A picture and what it took.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Premultiplied linear RGBA, row by row from the top.
    pub pixels: Vec<[f32; 4]>,
    /// What it took.
    pub measurements: Measurements,
}

/// What a frame took.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Measurements {
    /// Slots and modules of the program.
    pub modules: String,
    /// Files that its objects were read from besides those that the scene names.
    #[serde(default)]
    pub others: Vec<PathBuf>,
    /// Whether the program was linked when the crate was built.
    pub shipped: bool,
    /// What the scene did not need.
    #[serde(deserialize_with = "crate::render::variant::parts")]
    pub left_out: Vec<&'static str>,
    /// Octaves that the turbulence of the scene has, and those that were asked for; `None` where none is read.
    pub octaves: Option<[u32; 2]>,
    /// Slices drawn, or samples of a ray at most.
    pub slices: u32,
    /// Distance between them, object units.
    pub step: f32,
    /// Fragments shaded, where the device counts them: those of the passes that mark pixels of slices too.
    pub fragments: Option<u64>,
    /// Milliseconds until the program was ready: linked, made a pipeline of, and used once.
    pub compile_ms: f64,
    /// Milliseconds of the slices or rays on the device.
    pub gpu_ms: f64,
    /// Milliseconds of the shadow volume on the device; `None` without shadows, 0 where that of an earlier picture serves.
    pub shadow_ms: Option<f64>,
    /// Milliseconds that this one took with that earlier picture.
    #[serde(default)]
    pub shadow_before_ms: f64,
    /// Longest submission, milliseconds.
    pub longest_ms: f64,
    /// Milliseconds of everything but loading the subject, wall clock: with what was made for the picture before.
    pub total_ms: f64,
    /// Milliseconds of the processor that this process took meanwhile, all threads; `None` where the system does not say.
    #[serde(default)]
    pub processor_ms: Option<f64>,
    /// The images that the program reads.
    #[serde(default)]
    pub images: Vec<ImageInfo>,
    /// Bytes of images on the device.
    pub device_bytes: u64,
    /// What the bricks of a volume save; `None` where the volume is stored as a whole.
    pub sparse: Option<Sparse>,
    /// The cells of empty space; `None` where none would be left out.
    #[serde(default)]
    pub cells: Option<CellStats>,
    /// Largest error of a stored distance, object units; 0 for a formula.
    pub quantization: f32,
    /// Radius beyond which warps along the radius hold their step, where their formula has matter there; object units.
    pub held_beyond: Option<f32>,
}

impl Measurements {
    /// Milliseconds on the device.
    pub fn device_ms(&self) -> f64 {
        self.gpu_ms + self.shadow_ms.unwrap_or(0.0)
    }

    /// Milliseconds on the device of the same picture drawn by itself: with its shadow volume.
    pub fn alone_ms(&self) -> f64 {
        self.device_ms() + self.shadow_before_ms
    }
}
