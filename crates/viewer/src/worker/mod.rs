//! The render thread: the newest scene first, as previews while it moves, and progressively refined while it rests.

mod background_renderer;
mod handle;
mod job;
mod refine;
mod render_thread;
mod renderers;
mod shared;
mod task;
mod validity;

pub(crate) use handle::Worker;
pub(crate) use job::{Event, Job, Task, Variant};
pub(crate) use renderers::sight;
