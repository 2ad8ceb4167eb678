//! The window: the event loop, the display, and the surface that egui draws on.

mod canvas;
mod display;
mod event_loop;
mod fonts;
mod reader;
mod state;

pub use display::NO_WINDOW;
pub use event_loop::run;
