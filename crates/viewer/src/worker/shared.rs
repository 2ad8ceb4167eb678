//! State that the window and the render thread share.

use super::job::{Job, LoadedScene};
use hypertexture_measure::pick::ErrorBound;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard};
use std::thread;
use std::time::{Duration, Instant};

/// Longest wait for a preview to be shown: a hidden window shows none.
const MAX_WAIT: Duration = Duration::from_millis(40);
/// Interval between checks of this wait.
const POLL: Duration = Duration::from_micros(500);

#[derive(Default)]
pub(super) struct Shared {
    pub(super) inbox: Mutex<Inbox>,
    pub(super) wake: Condvar,
    /// Number of the newest job.
    pub(super) newest: AtomicU64,
    /// Whether the thread ends.
    pub(super) quit: AtomicBool,
    /// Whether the search stops.
    pub(super) stop: AtomicBool,
    /// The jobs of the last reported preview, and of the last shown picture.
    pub(super) reported: AtomicU64,
    pub(super) shown: AtomicU64,
}

#[derive(Default)]
pub(super) struct Inbox {
    pub(super) job: Option<Job>,
    pub(super) search: Option<(LoadedScene, ErrorBound)>,
}

impl Shared {
    pub(super) fn inbox(&self) -> MutexGuard<'_, Inbox> {
        self.inbox.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    pub(super) fn quits(&self) -> bool {
        self.quit.load(Ordering::Relaxed)
    }

    /// Waits until the window shows the last preview: on a CPU device, the next one would delay it.
    pub(super) fn wait_until_shown(&self) {
        let until = Instant::now() + MAX_WAIT;
        while self.shown.load(Ordering::Relaxed) < self.reported.load(Ordering::Relaxed) && Instant::now() < until {
            thread::sleep(POLL);
        }
    }

    /// Whether newer work waits than the job of this number.
    pub(super) fn is_stale(&self, number: u64) -> bool {
        self.quits() || self.newest.load(Ordering::Relaxed) != number
    }
}
