//! Measurements on a device: the cases of `verify` and `stress`, the f64 reference, and picks within an error.
#![allow(clippy::unwrap_used, reason = "a test fails where a picture is not as described")]

#[path = "../../../../tests/common/mod.rs"]
mod common;
#[allow(dead_code, reason = "other tests use the rest of it")]
#[path = "../../../../tests/common/random_scene.rs"]
mod random_scene;

mod pick;
mod reference;
mod stress;
mod truths;
