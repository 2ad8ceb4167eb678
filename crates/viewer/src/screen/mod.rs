//! The picture on the screen, or two that are compared.

mod compare;
mod pictures;

pub use compare::{CompareMode, Comparison};
pub(crate) use pictures::{Encoded, Frame, Screen, behind, encode_srgb};
