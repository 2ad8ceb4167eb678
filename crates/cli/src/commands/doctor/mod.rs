//! Diagnosis of the device, with remedies.

mod bench;
mod drivers;
mod examine;
mod finding;
#[cfg(test)]
mod hang_tests;
mod probes;

pub(crate) use examine::examine;
