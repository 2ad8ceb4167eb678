//! Diagnosis of the device, with remedies.

mod examine;
mod finding;
mod probes;

pub use examine::examine;
pub use finding::{Diagnosis, Finding};
