//! Final pictures, rendered by a child process.

mod order;

pub(crate) use order::{BEHIND, GRID, Kind, Motion, Order, Rendering, is_installed};
pub use order::{JOB, RenderAnswer, RenderJob};
