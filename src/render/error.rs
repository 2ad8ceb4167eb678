//! Errors of rendering.

use crate::field::FieldError;
use crate::gpu::GpuError;
use crate::render::variant::VariantError;
use crate::shape::ShapeError;

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
