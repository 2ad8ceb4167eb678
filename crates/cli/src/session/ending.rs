//! Ends of a command before its time: signals, and reports with failures.

use hypertexture::gpu::ending;
use std::error::Error;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// Exit code of an interrupted program, by the convention of shells: 128 + SIGINT.
pub const INTERRUPTED: u8 = 130;

/// Exit code of a report that holds failures.
pub const FAILED: u8 = 1;

/// Time for what a command writes at its end, once a signal has ended its wait for a device. Lower: the report of a
/// loaded machine is lost. Higher: a command that hangs for another reason ends late.
const GRACE: Duration = Duration::from_secs(3);

/// An interrupt by the user or a scheduler, with the finished frames.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Interrupted(pub String);

/// A report that holds failures; it was written.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Failed(pub String);

/// Flag of the first signal: the current frame is finished, unless the device does not answer. The second signal ends
/// the process at once; files stay whole.
pub(crate) fn stop_flag() -> Result<Arc<AtomicBool>, Box<dyn Error>> {
    static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    if let Some(stop) = STOP.get() {
        return Ok(stop.clone());
    }
    let stop = Arc::new(AtomicBool::new(false));
    let flag = stop.clone();
    ctrlc::set_handler(move || {
        ending::begin(INTERRUPTED, GRACE, || ());
        flag.store(true, Ordering::Relaxed);
    })
    .map_err(|error| format!("no handler for Ctrl-C: {error}"))?;
    Ok(STOP.get_or_init(|| stop).clone())
}
