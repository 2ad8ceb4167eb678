//! Rules of a scene: checks of its values, and what its modules determine of its program.

pub(in crate::scene) mod check;
mod check_quality;
pub(in crate::scene) mod header;
mod loops;
mod reach;
mod slots;
mod strategy;

pub(crate) use loops::SHADOW_SAMPLES;
pub use reach::Reach;
pub use strategy::Repeat;
