//! Progress of a stage of a computation.

use super::request::Progress;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Reports the fraction `from + (to - from) * done / total`.
pub(super) struct Stage<'a> {
    progress: Progress<'a>,
    from: f32,
    to: f32,
    total: usize,
    done: AtomicUsize,
}

impl<'a> Stage<'a> {
    pub(super) fn new(progress: Progress<'a>, from: f32, to: f32, total: usize) -> Stage<'a> {
        Stage { progress, from, to, total: total.max(1), done: AtomicUsize::new(0) }
    }

    /// Reports `steps` more as done.
    pub(super) fn advance(&self, steps: usize) {
        let done = (self.done.fetch_add(steps, Ordering::Relaxed) + steps).min(self.total);
        (self.progress)(self.from + (self.to - self.from) * done as f32 / self.total as f32);
    }
}
