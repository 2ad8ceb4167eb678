//! Lowering of a module of naga to instructions over registers.

mod expr;
pub mod function;
mod io;
mod math;
mod ops;
mod statement;
mod types;
mod walk;
pub mod words;
