//! Fields of a scene: their settings, their identities, and their text in files and on the command line.

mod command;
mod document;
mod field;
mod file;
mod length;
pub mod schema;
pub(in crate::scene) mod setting;

pub use command::{option_text, value_text};
pub use document::{Boolean, FieldId, Material, MaterialField, ParameterValue, Picture, PictureField, Scene};
pub use field::parse_value;
#[cfg(feature = "window")]
pub use file::MAX_BYTES;
pub use file::{load, load_given, parse, to_text};
pub use length::Length;
