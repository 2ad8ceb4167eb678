//! Run times of pictures and fields on a device, their floors, and changes since a saved run.
//!
//! Role: [`suite()`] lists the rows, [`measure`] times them, and [`Bench`] is saved, read and compared. Invariant: a ratio is
//! of interleaved runs; no run is dropped.

mod report;
mod roofline;
mod run;
mod suite;
mod timed;

pub use report::{Change, Mismatch, changes, table};
pub use roofline::{Counts, Peaks};
pub use suite::{Row, Work, library, stages, suite};
pub use timed::{Against, Bench, Floor, Timed, measure};

#[cfg(test)]
mod tests;
