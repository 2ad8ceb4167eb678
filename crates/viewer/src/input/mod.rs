//! Input: commands, keys, the trackball, and the events of a frame.

mod command;
pub(crate) mod keys;
mod passes;
pub(crate) mod trackball;

pub use command::Command;
pub(crate) use passes::passes;
