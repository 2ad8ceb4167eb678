//! The work around a command: checks of its scene, its object, the device, and its end.

mod device;
mod ending;
mod faults;
mod files;
mod frame_object;
mod prepared;

pub(crate) use device::{checked, gpu_error, start, try_in_sandbox, with_device};
pub(crate) use ending::{FAILED, Failed, INTERRUPTED, Interrupted, stop_flag};
pub(crate) use faults::{fault_line, say_fault};
pub(crate) use files::{check_folder, make_folder};
pub(crate) use frame_object::FrameObject;
pub(crate) use prepared::{CheckedScene, Outputs, Preparation, Prepared};
