//! The window.
//!
//! Role: [`run`] shows a scene with panels, mouse control and an editor for its modules. A render thread draws pictures through
//! [`hypertexture::render`]; the window shows the newest one and never waits for one.
//! Invariants: every picture comes from [`hypertexture::render::Renderer`], of a scene that
//! [`hypertexture::scene::Scene::check`] accepts; a refused change has no effect but one line of text. The thread of the window
//! submits only the draws of egui, and computes no field.

mod app;
#[doc(hidden)] // for the tests of this crate
pub mod author;
mod background;
mod canvas;
mod coarse;
#[doc(hidden)] // for the tests of this crate
pub mod compare;
mod densities;
mod display;
mod error;
mod event_loop;
mod finals;
mod fonts;
mod input;
mod input_latency;
#[doc(hidden)] // for the tests of this crate
pub mod inspect;
mod keys;
mod lesson;
mod load;
mod mean;
#[doc(hidden)] // for the tests of this crate
pub mod message;
#[doc(hidden)] // for the tests of this crate
pub mod model;
mod painting;
#[doc(hidden)] // for the tests of this crate
pub mod panels;
#[doc(hidden)] // for the tests of this crate
pub mod playback;
mod progressive;
mod screen;
mod script;
mod status;
mod trackball;
#[doc(hidden)] // for the tests of this crate
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
