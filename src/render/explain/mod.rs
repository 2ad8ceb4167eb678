//! Explanations of a picture: its inputs, settings without effect, and warnings.

mod describe;
mod unused_settings;
mod warnings;

pub use describe::{describe_frame, octaves_held};
pub use unused_settings::{same_pictures, unused_overrides, unused_settings};
pub use warnings::{eye_inside, loop_note, warnings};
