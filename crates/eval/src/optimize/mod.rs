//! Optimization of lowered code, and allocation of its registers.

pub mod allocate;
pub mod bool_fold;
pub mod flatten;
pub mod tidy;
