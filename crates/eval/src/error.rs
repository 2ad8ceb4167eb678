//! Errors of the evaluator.

/// Errors of reading, binding and running a program.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExactError {
    /// The SPIR-V cannot be read.
    #[error("the SPIR-V cannot be read: {0}")]
    Spirv(String),
    /// A construct outside the covered part of SPIR-V.
    #[error("the exact evaluator does not cover {construct} ({place})")]
    Uncovered {
        /// Name of the construct.
        construct: String,
        /// File and line.
        place: String,
    },
    /// A binding without an input.
    #[error("binding {binding} needs {what}; add it to `Inputs`")]
    Missing {
        /// Number of the binding.
        binding: u32,
        /// Kind of input: a block, an image or a sampler.
        what: &'static str,
    },
    /// A binding whose input has the wrong size or shape.
    #[error("binding {binding} has {found}, but the program needs {needed}")]
    Unfit {
        /// Number of the binding.
        binding: u32,
        /// Shape of the input.
        found: String,
        /// Shape that the program needs.
        needed: String,
    },
    /// Invocations of different lengths, without a varying, or not in quads.
    #[error("{0}")]
    Invocations(String),
    /// A loop without an end.
    #[error("a loop has not ended after {turns} turns ({place})")]
    Endless {
        /// Iterations of the loop and of those around it.
        turns: u64,
        /// File and line.
        place: String,
    },
}
