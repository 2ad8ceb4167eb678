//! Errors of rendering.

use crate::field::FieldError;
use crate::gpu::GpuError;
use crate::render::variant::VariantError;
use crate::shape::ShapeError;

/// Error of rendering.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The input cannot be read.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The distance field cannot be computed.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A length with a unit, for an object without one.
    #[error("{name} = {text}: {object} has no unit; give its longest side, such as --scale-to 60mm")]
    NoUnit {
        /// The field.
        name: String,
        /// Its value.
        text: String,
        /// The object.
        object: String,
    },
    /// The object is too small for its scale to be a number.
    #[error(
        "{0}: its longest side is {1:e} units, which f32 cannot scale to an object; it must be 1e-37 or more: scale the file"
    )]
    Tiny(String, f32),
    /// The scene has no valid program.
    #[error(transparent)]
    Variant(#[from] VariantError),
    /// A Vulkan call failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The scene and pre-classification are incompatible.
    #[error("effect.classify = {0}: needs {1}; use classify = \"post\"")]
    Classification(String, &'static str),
    /// A tabulated module reads values that change with the picture.
    #[error(
        "tabulated modules of opacity and softness may read only parameters and iso-values; use effect.classify = \"post\""
    )]
    Table,
    /// A tabulated module cannot be evaluated.
    #[error("a table of opacity or softness: {0}")]
    Exact(#[from] crate::eval::ExactError),
    /// Eye and light do not pass the slices in one order.
    #[error("light.method = \"half_angle\": {0}; {1}, or use light.method = \"volume\"")]
    HalfAngle(&'static str, &'static str),
    /// The program reads data that the subject was loaded without.
    #[error("the subject has no {0}, which the program reads; load it with the scene that is rendered")]
    Missing(&'static str),
    /// The program has a block member without a value.
    #[error("`{0}` is in no block of interface.glsl; declare it with `// @param` in a module")]
    Unfilled(String),
    /// The setting is not available for recorded pictures.
    #[error("recorded pictures support neither several samples per pixel nor half-angle slices; use {0}")]
    Recorded(&'static str),
    /// The scene has no depth.
    #[error("bent rays, a slice stack viewed from the side and an eye far away have no depth; use {0}")]
    Depth(&'static str),
    /// The setting is not available to other hosts.
    #[error("{0}: a page or another program cannot draw it; use {1}")]
    Portable(&'static str, &'static str),
    /// The caller stopped the picture: see [`Renderer::stop_where`](crate::render::Renderer::stop_where).
    #[error("the picture was stopped before it was finished")]
    Stopped,
    /// Message of a worker process.
    #[error("{0}")]
    Worker(String),
    /// The scene crashed a worker process.
    #[error("{0}; other scenes are still drawn")]
    Ended(String),
    /// The picture has non-finite pixels.
    #[error("the picture holds {count} values that are not finite, the first at pixel {x}, {y}: {cause}")]
    NotFinite {
        /// Number of non-finite pixels.
        count: usize,
        /// Column of the first.
        x: usize,
        /// Row of the first.
        y: usize,
        /// Cause or advice.
        cause: String,
    },
    /// A custom module computes with an undefined value; with file and line.
    #[error("{0}")]
    Undefined(String),
    /// A custom module cannot be evaluated before it is drawn.
    #[error("{modules}: it cannot be tried, so it is not drawn: {reason}; write that part in another way")]
    Untried {
        /// The modules.
        modules: String,
        /// The part that the evaluator lacks.
        reason: Box<crate::eval::ExactError>,
    },
    /// The loops of a custom module exceed the limit of some devices.
    #[error(
        "{place}: the loops of one {whose} make more than {turns} turns{with}; devices cut them there, and the picture would not be that of the module; {}",
        if *whose == "sample" { "end the loop sooner" } else { "end the loop sooner, or take fewer samples" }
    )]
    Loop {
        /// File and line.
        place: String,
        /// Owner of the loops: `sample`, `ray`, `ray of the light`.
        whose: &'static str,
        /// Limit of iterations.
        turns: u64,
        /// Values of the module's parameters.
        with: String,
    },
}
