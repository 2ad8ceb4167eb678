//! The window.
//!
//! Role: [`run`] shows a scene that the mouse turns and the panels change, and the modules of its effect while they are
//! edited. A thread of its own renders pictures, through [`hypertexture::render`] as everywhere; the window shows the newest one
//! and waits for none.
//! Invariants: every picture is one that [`hypertexture::render::Renderer`] has made, of a scene that
//! [`hypertexture::scene::Scene::check`] accepts; a change that it refuses is one line of text and nothing else. The thread of the
//! window submits nothing but what egui draws, and computes no field.

mod app;
#[doc(hidden)] // for the tests of this crate
pub mod author;
mod background;
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
mod load;
#[doc(hidden)] // for the tests of this crate
pub mod message;
#[doc(hidden)] // for the tests of this crate
pub mod model;
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
mod worker;

pub use app::Start;
pub use display::NO_WINDOW;
pub use error::ViewError;
pub use event_loop::run;
pub use trackball::Trackball;
