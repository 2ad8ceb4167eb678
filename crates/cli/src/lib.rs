//! The command line: arguments to calls of the library, errors to one line and an exit code.

mod arguments;
mod commands;
mod program;
mod session;
mod terminal;

pub use commands::gallery;
pub use program::main;
