//! Utilities of every layer: atomic file writes, a disk cache, child processes under limits, random numbers, text for people.

pub mod disk_cache;
#[doc(hidden)] // for tests
pub mod faults;
mod files;
pub mod jobs;
pub mod memory;
pub mod open;
pub mod random;
pub mod threads;
#[doc(hidden)] // for tests
pub mod validation_lock;
pub mod watchdog;
pub mod words;

pub use faults::file as may_fail;
pub use files::{destination, free_space, probe, sweep, write_whole, write_whole_by};
pub use words::{quoted, significant};
