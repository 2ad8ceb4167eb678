//! The fastest settings of a scene within an error.
//!
//! Role: scene and bound -> the same scene with other accuracy settings. Steps: 1. Candidates whose bound is above the error are left
//! out. 2. Each method is drawn small with ever more samples, and held against the f64 reference in some pixels, until it
//! should fit. 3. The fastest that should fit is drawn whole, and held against the reference in a random sample of its pixels that
//! grows until an upper bound of its error is within the one asked for. 4. Its error corrects the expectation of the next.
//! Invariants: all candidates have the truth of the scene; a stated error is an upper bound; a refusal is of pictures that were
//! tried to their limit. Source: the protocol of numerical work-precision diagrams.

mod bound;
mod candidates;
mod fastest;
mod reference_sample;
mod sample;
mod search;
mod store;
mod whole;

pub use bound::{ErrorBound, Kept, Pick, PickError, Verified};
pub use fastest::{pick, remembered};
