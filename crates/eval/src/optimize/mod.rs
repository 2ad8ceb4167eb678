//! Optimization of lowered code, and allocation of its registers.

pub(crate) mod allocate;
pub(crate) mod bool_fold;
pub(crate) mod flatten;
pub(crate) mod tidy;
