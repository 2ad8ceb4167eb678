//! A picture on disk compared with its own scene: whether the scene gives it here, and how accurate it is.

mod check;
mod rerender;
mod verdict;

pub use check::{CheckError, CheckOptions, GroundTruth, PixelTruth, check};
pub use verdict::Verdict;
