//! Lines about faults of custom modules.

use crate::terminal::say;
use hypertexture::render::{FINITE, ModuleFault};

/// The line about values of a custom module that are NaN or infinite; empty without a fault.
pub(crate) fn fault_line(fault: Option<&ModuleFault>) -> String {
    fault.map_or(String::new(), |fault| format!("module     {fault}; {FINITE}\n"))
}

/// Reports NaN or infinite values of a custom module.
pub(crate) fn say_fault(fault: Option<ModuleFault>) {
    say(&fault_line(fault.as_ref()));
}
