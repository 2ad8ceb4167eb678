//! The render thread: the newest scene first, as previews while it moves, and progressively refined while it rests.

mod background_renderer;
mod handle;
mod job;
mod mean;
mod pick;
mod progressive;
mod refine;
mod render_thread;
mod renderers;
mod repaint;
mod shared;
mod status;
mod stroke_budget;
mod validity;

pub(crate) use handle::Worker;
pub(crate) use job::{Event, Job, LoadedScene, is_same_scene};
pub(crate) use renderers::pose_of;
pub(crate) use status::{Cost, Figures, Stage};
