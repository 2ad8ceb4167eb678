//! The program: its command line, the panels of its window, and the window on a display of its own. One program of tests, so
//! that long ones run beside short ones.
#![allow(clippy::unwrap_used, reason = "a test fails where a file, a control or a process is not as described")]

#[path = "../../../tests/common/mod.rs"]
mod common;
#[path = "common/program.rs"]
mod program;

mod cli;
#[cfg(feature = "viewer")]
mod panels;
#[cfg(feature = "viewer")]
mod view;
