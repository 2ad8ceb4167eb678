//! The window.
//!
//! Role: [`run`] shows a scene with panels, mouse control and an editor for its modules. A render thread draws pictures through
//! [`hypertexture::render`]; the window shows the newest one and never waits for one.
//! Invariants: every picture comes from [`hypertexture::render::Renderer`], of a scene that
//! [`hypertexture::scene::Scene::check`] accepts; a refused change has no effect but one line of text. The thread of the window
//! submits only the draws of egui, and computes no field.

mod app;
mod background;
pub mod document;
mod error;
mod facts;
pub mod input;
mod inspect;
mod lesson;
mod load;
pub mod message;
pub mod panels;
pub mod playback;
pub mod screen;
mod script;
mod window;
mod worker;

pub use app::Start;
pub use document::exports::{JOB as FINAL_JOB, RenderAnswer, RenderJob};
pub use error::ViewError;
pub use window::{NO_WINDOW, run};
