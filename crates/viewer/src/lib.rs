//! The live window.
//!
//! Role: [`run`] shows a scene that the mouse turns and the panels change, and the modules of its effect while they are
//! edited. A thread of its own renders pictures, through [`hypertexture::render`] as everywhere; the window shows the newest one
//! and waits for none.
//! Invariants: every picture is one that [`hypertexture::render::Renderer`] has made, of a scene that
//! [`hypertexture::scene::Scene::check`] accepts; a change that it refuses is one line of text and nothing else. The thread of the
//! window submits nothing but what egui draws, and computes no field.

mod answers;
mod app;
#[doc(hidden)] // for the tests of this crate
pub mod author;
mod canvas;
#[doc(hidden)] // for the tests of this crate
pub mod compare;
mod densities;
mod display;
mod error;
mod finals;
mod fonts;
mod host;
mod input;
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
mod progressive;
mod screen;
mod script;
mod status;
#[doc(hidden)] // for the tests of this crate
pub mod tempo;
mod trackball;
mod unread;
#[doc(hidden)] // for the tests of this crate
pub mod unsaved;
mod worker;

pub use app::Start;
pub use display::NO_WINDOW;
pub use error::ViewError;
pub use host::run;
pub use trackball::Trackball;
