//! Diagnosis of the device, with remedies.

mod examine;
mod finding;
#[cfg(test)]
mod hang_tests;
mod probes;

pub use examine::examine;
pub use finding::{Diagnosis, Finding};
