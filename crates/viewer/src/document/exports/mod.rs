//! Final pictures, rendered by a child process one after another.

mod order;
mod print;
mod queue;

pub(crate) use order::{ExportOrder, GRID, Kind, Motion, VIDEO_BACKGROUND, is_installed};
pub use order::{JOB, RenderAnswer, RenderJob};
pub(crate) use print::{Print, longest_side, up_of_print};
pub(crate) use queue::{Exports, Written};
