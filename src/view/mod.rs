//! The live window.
//!
//! Role: [`run`] shows a scene that the mouse turns and the panels change. A thread of its own renders pictures, through
//! [`crate::render`] as everywhere; the window shows the newest one and waits for none.
//! Invariants: every picture is one that [`crate::render::Renderer`] has made; the thread of the window submits nothing
//! but what egui draws, and computes no field.

mod app;
mod error;
mod host;
mod keys;
mod load;
mod progressive;
mod screen;
mod script;
mod stand_in;
mod status;
mod trackball;
mod worker;

pub use app::{Start, run};
pub use error::ViewError;
pub use stand_in::{model, panels};
pub use trackball::Trackball;
