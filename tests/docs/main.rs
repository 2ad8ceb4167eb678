//! What pages say of the code is true.

mod layers;
mod names;
mod papers;
mod readme;
#[cfg(unix)]
mod setup;
