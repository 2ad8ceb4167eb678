//! Settings: names, values, flags, typed access to their fields, and the macros that declare tables of settings.

mod declare;
mod kind;
mod node;
mod value;

pub(crate) use declare::{choices, settings};
pub use kind::{ChangeSet, Changes, Filled, Flag, Kind, Range, Setting, Unit};
pub(crate) use kind::{number, numbers, whole, wholes};
pub use node::{Leaf, Moment, Node};
pub(crate) use node::{of, only, push_name};
pub use value::float;
