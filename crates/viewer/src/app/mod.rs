//! Input to the scene, the scene to the render thread, and pictures to the screen.

mod frame;
mod framing;
mod gizmo;
#[cfg(test)]
mod hand;
mod inspect;
mod jobs;
#[cfg(test)]
mod monkey;
mod mouse;
mod objects;
mod overlay;
mod paint;
mod perform;
mod receive;
mod state;
mod submit;
#[cfg(test)]
mod tests;

pub(crate) use state::App;
pub use state::Start;
