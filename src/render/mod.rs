//! From a scene to a picture: the frame pipeline, read top to bottom.
//!
//! Role: [`Subject::load`] turns the object of a scene into a distance field; [`render`] turns scene and subject into a
//! [`Frame`]. Invariant: every picture that a person sees comes through [`render`].

mod bind;
mod cells;
mod coming;
mod cpu_inputs;
mod density;
mod depth;
mod doubts;
mod encoded;
mod half_angle;
mod ignored;
mod inputs;
mod item;
mod light_space;
mod made;
mod marks;
mod noise_blocks;
#[doc(hidden)] // for the tests of this crate
pub mod pace;
#[doc(hidden)] // for the tests of this crate
pub mod pass;
mod pixels;
mod polygonize;
mod prepared;
mod renderer;
mod shadow;
mod shot;
mod sight;
mod sparse;
mod sub_frame;
mod subject;
mod table;
#[doc(hidden)] // for the tests of this crate
pub mod texture;
mod tiles;
mod values;
pub mod variant;
mod view;
mod watch;

pub use cells::Found;
pub use cells::link as link_cells;
pub use cells::{LOOKED_UP, bounded};
pub use cpu_inputs::{Blocks, CpuInputs};
pub use density::{Along, densities, density_along};
pub use depth::check_depth;
pub use doubts::doubts;
pub use ignored::{all_alike, idle, ignored};
pub use made::{made_with, octaves_held};
pub use pixels::put;
pub use polygonize::{PolygonizeError, Polygons, polygonize};
pub use renderer::{Renderer, render};
pub use shadow::{Transmittance, transmittance};
pub use sight::Sight;
pub use sparse::Sparse;
pub use subject::{Subject, Wanted, field_margin, open, request};
pub use view::half_height;
pub use watch::{FINITE, Fault, watch};

use crate::field::FieldError;
use crate::gpu::GpuError;
use crate::render::variant::VariantError;
use crate::shape::ShapeError;
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

/// An image that a program reads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Read {
    /// What it holds.
    pub name: String,
    /// Texels along each axis.
    pub size: [u32; 3],
    /// Channels of a texel.
    pub channels: u32,
    /// Bits of a channel.
    pub bits: u32,
    /// Bytes on the device.
    pub bytes: u64,
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
    pub images: Vec<Read>,
    /// Bytes of images on the device.
    pub device_bytes: u64,
    /// What the bricks of a volume save; `None` where the volume is stored as a whole.
    pub sparse: Option<Sparse>,
    /// The cells of empty space; `None` where none would be left out.
    #[serde(default)]
    pub cells: Option<Found>,
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

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The input cannot be read.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The distance field cannot be computed.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The scene has no valid program.
    #[error(transparent)]
    Variant(#[from] VariantError),
    /// The device refuses.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A scene asks for what pre-classification cannot do.
    #[error("effect.classify = {0}: needs {1}; use classify = \"post\"")]
    Classification(String, &'static str),
    /// A table holds what changes from moment to moment.
    #[error(
        "modules of opacity and softness whose values a table holds read parameters and iso-values alone; use effect.classify = \"post\""
    )]
    Table,
    /// A module of a table cannot be evaluated.
    #[error("a table of opacity or softness: {0}")]
    Exact(#[from] crate::eval::ExactError),
    /// Eye and light do not look through the slices in one order.
    #[error("light.method = \"half_angle\": {0}; {1}, or use light.method = \"volume\"")]
    HalfAngle(&'static str, &'static str),
    /// A program reads what the subject was loaded without.
    #[error("the subject has no {0}, which the program reads; load it with the scene that is rendered")]
    Missing(&'static str),
    /// The program has a block member that the renderer does not know.
    #[error("`{0}` is in no block of interface.glsl; declare it with `// @param` in a module")]
    Unfilled(String),
    /// What a picture in a host's command buffer cannot be.
    #[error(
        "a picture that is recorded for a host has one sample of each pixel and no light that goes from slice to slice; use {0}"
    )]
    Recorded(&'static str),
    /// A scene without a depth.
    #[error("rays that bend, and slices that are looked at from the side, have no depth; use {0}")]
    Depth(&'static str),
    /// Something more urgent is to be drawn: see [`Renderer::stop_where`].
    #[error("the picture was stopped before it was finished")]
    Stopped,
    /// What a worker says.
    #[error("{0}")]
    Worker(String),
    /// A worker has ended by the scene.
    #[error("{0}; what else there is to draw goes on")]
    Ended(String),
    /// A target that the device has, and that was read back wrong.
    #[error("the picture holds {count} values that are not finite, the first at pixel {x}, {y}: {cause}")]
    NotFinite {
        /// How many.
        count: usize,
        /// Column of the first.
        x: usize,
        /// Row of the first.
        y: usize,
        /// Where they come from, or what to do.
        cause: String,
    },
    /// Loops that a device cuts.
    #[error(
        "{place}: the loops of one {whose} make more than {turns} turns{with}; devices cut them there, and the picture would not be that of the module; {}",
        if *whose == "sample" { "end the loop sooner" } else { "end the loop sooner, or take fewer samples" }
    )]
    Loop {
        /// File and line.
        place: String,
        /// What makes the turns: `sample`, `ray`, `ray of the light`.
        whose: &'static str,
        /// Turns after which devices cut.
        turns: u64,
        /// The values of the parameters of the module.
        with: String,
    },
}

/// `constant_id` of the octaves in `glsl/octave_constants.glsl`.
pub const OCTAVES_ID: u32 = 0;
