//! Evaluates SPIR-V on the CPU: in f64, in intervals and in affine forms.
//!
//! A fragment shader is the code that a GPU runs. Here the same SPIR-V gives its value in f64, bounds over a box of inputs
//! ([`Interval`]), bounds along a segment ([`Affine`]), and bounds that include the rounding of devices ([`F32Interval`]).
//! A formula is written once, in the shader; its error, its bounds and its empty regions follow from it.
//!
//! # Stages
//! 1. [`Program::read`]: replaces specialization constants, parses the words with naga and lowers them to scalar
//!    instructions over registers. Functions are inlined and dead code is eliminated; loops and branches stay.
//! 2. [`Program::bind`]: takes uniform blocks, images and samplers. Expressions of uniforms are computed once.
//! 3. [`BoundProgram::run`]: runs each instruction as one vectorized loop over a block of lanes. Lanes that diverge run one
//!    after another and are joined where control flow meets.
//!
//! # Guarantees
//! - f64: elementary operations are correctly rounded; functions of GLSL are those of the standard library.
//! - An [`Interval`] holds the results for every point of its box, rounded outward; an [`Affine`] form those for every
//!   position on its segment, except subnormal numbers. An undecided comparison takes both branches; a loop without a known
//!   bound gives the whole line.
//! - Evaluation is pure, and results do not depend on the grouping of lanes. A construct outside the covered part of SPIR-V is an error
//!   with the name, file and line of the construct.
//!
//! # Example
//! ```
//! use hypertexture_eval::{Inputs, Interval, Invocations, Program};
//! use hypertexture_glsl::{Library, Linker, Slots, Stage};
//!
//! let text = "#version 450
//!     layout(location = 0) in vec4 place;
//!     layout(location = 0) out vec4 value;
//!     void main() { float r = dot(place.xy, place.xy); value = vec4(r < 1.0 ? 1.0 - r : 0.0); }";
//! let library = Library::new([("hill.frag".to_string(), text.to_string())]);
//! let spirv = Linker::new()?.link(&library, "hill.frag", Stage::Fragment, &["hill.frag"], &Slots::new())?;
//!
//! let program = Program::read(&spirv, &[])?;
//! let inputs = Inputs::default();
//! let bound = program.bind(&inputs)?;
//! fn at<N: Copy>(x: N, y: N) -> Invocations<N> {
//!     Invocations { fragment_coordinates: vec![], varyings: [(0, vec![[x, y, x, y]])].into() }
//! }
//! assert_eq!(bound.run(&at(0.5, 0.0))?[&0][0][0], 0.75);
//!
//! let hill = bound.run(&at(Interval::of(0.0, 0.5), Interval::of(0.0, 0.5)))?[&0][0][0];
//! assert!(hill.contains(1.0) && hill.contains(0.5) && !hill.contains(0.4));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bind;
mod code;
mod error;
mod evaluate;
mod fingerprint;
mod integer_splits;
mod lower;
mod number;
mod numbers;
mod optimize;
mod program;
mod pyramid;
mod run;
mod split_bounds;
mod texture;
mod uniforms;

pub use bind::BoundProgram;
pub use error::ExactError;
pub use evaluate::{Evaluate, Invocations, Measured};
pub use fingerprint::Fingerprint;
pub use lower::faults::{FAULTS, Fault, Watch};
pub use lower::words::specialized;
pub use number::{Domain, Number};
pub use numbers::affine::Affine;
pub use numbers::f32_interval::F32Interval;
pub use numbers::interval::Interval;
pub use numbers::segment_bounds::SegmentBounds;
pub use program::{Inputs, Program};
pub use run::single::Overflow;
pub use texture::{Texture, Wrap};
