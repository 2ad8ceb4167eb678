//! Explanations of a picture: its inputs, settings without effect, and warnings.

mod describe;
mod unused_settings;
mod warnings;

pub use describe::{made_with, octaves_held};
pub use unused_settings::{all_alike, idle, ignored};
pub use warnings::doubts;
