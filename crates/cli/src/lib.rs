//! The command line: arguments to calls of the library, errors to one line and an exit code.

mod args;
mod bench;
mod brief;
mod compare;
mod convert;
mod depth_map;
#[cfg(all(test, feature = "viewer"))]
mod docs_tests;
pub mod doctor;
mod effects;
mod ending;
mod error_map;
mod explain;
mod export;
#[cfg(test)]
mod fault_tests;
mod faults;
mod field;
mod files;
mod flags;
mod frame_object;
mod frames;
pub mod gallery;
mod groom;
mod info;
#[cfg(all(test, feature = "viewer"))]
mod line_tests;
mod log;
mod manual;
mod merge;
mod mesh;
mod modules;
mod paper;
mod picture;
mod prepared;
mod program;
mod progress;
mod render;
#[cfg(feature = "viewer")]
mod render_job;
mod scene_arguments;
mod sequence;
mod session;
mod settings;
mod stress;
mod terminal;
mod validity;
mod verify;
#[cfg(feature = "viewer")]
mod view;
mod volume;

pub use ending::{FAILED, INTERRUPTED};
pub use program::main;
pub use session::start;
pub use terminal::say;

use progress::{announced, with_progress};
use session::{checked, try_in_sandbox, with_device};
use terminal::{absolute, aside, complain, say_json, silent};
