//! Lowering of a module of naga to instructions over registers.

mod expr;
pub(crate) mod faults;
pub(crate) mod function;
mod io;
mod math;
mod ops;
mod statement;
mod types;
mod walk;
mod watch;
pub(crate) mod words;
