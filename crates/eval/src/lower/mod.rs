//! Lowering of a module of naga to instructions over registers.

mod expr;
pub mod faults;
pub mod function;
mod io;
mod math;
mod ops;
mod statement;
mod types;
mod walk;
mod watch;
pub mod words;
