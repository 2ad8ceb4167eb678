//! Input to the scene, the scene to the render thread, and pictures to the screen.

mod actions;
mod frame;
mod gizmo;
mod inspect;
mod mouse;
mod objects;
mod overlay;
mod paint;
mod receive;
mod state;
mod submit;

pub(crate) use state::App;
pub use state::Start;
