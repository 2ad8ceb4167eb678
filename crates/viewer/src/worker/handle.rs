//! The window's handle of the render thread.

use super::job::{Event, Job, LoadedScene};
use super::render_thread::RenderThread;
use super::shared::Shared;
use crate::background::Notify;
use crate::document::author::Gate;
use hypertexture::gpu::Gpu;
use hypertexture_measure::pick::ErrorBound;
use std::sync::atomic::Ordering;
use std::sync::{Arc, mpsc};
use std::thread::{self, JoinHandle};

/// The handle; dropping it ends the thread.
pub(crate) struct Worker {
    shared: Arc<Shared>,
    pub(crate) events: mpsc::Receiver<Event>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread, which calls `notify` after each event.
    pub(crate) fn start(gpu: Gpu, gate: Arc<Gate>, budget_ms: f64, notify: Notify) -> Worker {
        let shared = Arc::new(Shared::default());
        let (sender, events) = mpsc::channel();
        let own = shared.clone();
        let thread = thread::spawn(move || {
            let send = move |event| {
                // The window may be closed.
                let _ = sender.send(event);
                notify();
            };
            RenderThread::new(gpu, gate, own, budget_ms, Box::new(send)).run();
        });
        Worker { shared, events, thread: Some(thread) }
    }

    /// Replaces the current job.
    pub(crate) fn show(&self, job: Job) {
        self.shared.newest.store(job.number, Ordering::Relaxed);
        self.shared.inbox().job = Some(job);
        self.shared.wake.notify_one();
    }

    /// Notes that the window shows the picture of a job.
    pub(crate) fn shown(&self, number: u64) {
        self.shared.shown.store(number, Ordering::Relaxed);
    }

    /// Searches for the fastest settings within an error, which interrupts the current picture.
    pub(crate) fn pick(&self, variant: LoadedScene, bound: ErrorBound) {
        self.shared.stop.store(false, Ordering::Relaxed);
        self.shared.newest.store(u64::MAX, Ordering::Relaxed);
        self.shared.inbox().search = Some((variant, bound));
        self.shared.wake.notify_one();
    }

    /// Whether the thread has ended: the device is lost, or it has panicked.
    pub(crate) fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Stops the search.
    pub(crate) fn stop(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.shared.quit.store(true, Ordering::Relaxed);
        self.stop();
        drop(self.shared.inbox()); // after a check of the inbox that would miss the wake
        self.shared.wake.notify_one();
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            log::error!("the thread that renders has failed");
        }
    }
}
