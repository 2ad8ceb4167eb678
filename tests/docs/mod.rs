//! Statements of the pages about the code are true.

mod layers;
mod names;
mod papers;
mod readme;
#[cfg(unix)]
mod releases;
#[cfg(unix)]
mod setup;
