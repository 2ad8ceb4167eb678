//! The pixel inspector: value, f64 reference, density along the ray, and the modules that contribute.
//!
//! Role: the pictures on the screen, and a search in the background -> a report on one pixel. Invariant: a search is
//! cancelled when another pixel, another scene or none is selected.

mod inspector;
mod search;
mod window;
mod worst;

pub(crate) use inspector::Inspector;

#[cfg(test)]
mod tests;
