//! Settings: names, values, flags, and the macros that declare tables of settings.

mod declare;
mod kind;
mod value;

pub(crate) use declare::{choices, settings};
pub use kind::{Changes, Filled, Flag, Kind, Range, Setting};
pub(crate) use kind::{number, numbers, whole, wholes};
pub use value::float;
