//! Final pictures, rendered by a child process one after another.

mod order;
mod queue;

pub(crate) use order::{ExportOrder, GRID, Kind, Motion, VIDEO_BACKGROUND, is_installed};
pub use order::{JOB, RenderAnswer, RenderJob};
pub(crate) use queue::Exports;
