//! Loaded objects of a scene.

mod hit;
mod load;
mod millimeters;
mod request;

pub use load::Subject;
pub use millimeters::{Millimeters, UnitOrigin, settle_lengths};
pub(crate) use request::field_margin;
pub(crate) use request::{Recipe, opened};
pub use request::{SubjectRequest, open, request};
