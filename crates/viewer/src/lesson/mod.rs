//! The lesson: the samples of a ray, the soft region under its modules, and turbulence, of the scene on the screen.
//!
//! Role: the current job, and studies in the background -> a window with diagrams. Invariant: a lesson changes the scene only
//! by its controls, so that every state of it can be saved.

mod plot;
mod state;
mod strategies;
mod study;
mod window;

pub(crate) use state::Lesson;
