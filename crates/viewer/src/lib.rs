//! The window.
//!
//! Role: [`run`] shows a scene with panels, mouse control and an editor for its modules. A render thread draws pictures through
//! [`hypertexture::render`]; the window shows the newest one and never waits for one.
//! Invariants: every picture comes from [`hypertexture::render::Renderer`], of a scene that
//! [`hypertexture::scene::Scene::check`] accepts; a refused change has no effect but one line of text. The thread of the window
//! submits only the draws of egui, and computes no field.

mod app;
pub mod author;
mod background;
mod canvas;
mod coarse;
pub mod command;
pub mod compare;
mod densities;
mod display;
mod error;
mod event_loop;
mod finals;
mod fonts;
mod input;
mod input_latency;
pub mod inspect;
mod keys;
mod lesson;
mod load;
mod mean;
pub mod message;
pub mod model;
mod painting;
pub mod panels;
pub mod playback;
mod progressive;
mod reader;
mod screen;
mod script;
mod status;
mod trackball;
pub mod unsaved;
mod unused_settings;
mod window_state;
mod worker;

pub use app::Start;
pub use display::NO_WINDOW;
pub use error::ViewError;
pub use event_loop::run;
pub use finals::{JOB as FINAL_JOB, RenderAnswer, RenderJob};
pub use trackball::Trackball;
