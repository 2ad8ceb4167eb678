//! Computations on threads of their own, polled once a frame.
//!
//! Invariant: a computation whose [`Background`] is dropped ends where it next looks at [`Task::is_cancelled`] or calls
//! [`Task::report`].

use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{self, TryRecvError};
use std::task::Poll;
use std::thread::{self, Builder, JoinHandle};

/// Stack of a thread, in bytes. Lower: the recursive walk over a program overflows it.
const STACK: usize = 16 << 20;

/// Wakes the window from another thread.
pub(crate) type Notify = Arc<dyn Fn() + Send + Sync>;

/// A notification without effect, for an owner that polls by itself.
pub(crate) fn silent() -> Notify {
    Arc::new(|| ())
}

/// A computation on a thread, which yields any number of values. Dropping it cancels the computation.
pub(crate) struct Background<T> {
    cancelled: Arc<AtomicBool>,
    progress: Arc<AtomicU32>,
    values: mpsc::Receiver<T>,
    thread: Option<JoinHandle<()>>,
}

/// The side of a [`Background`] that the computation sees.
pub(crate) struct Task<T> {
    cancelled: Arc<AtomicBool>,
    progress: Arc<AtomicU32>,
    values: mpsc::Sender<T>,
    notify: Notify,
}

impl<T: Send + 'static> Background<T> {
    /// Starts `work`. `notify` is called for each value and at the end.
    pub(crate) fn start(notify: &Notify, work: impl FnOnce(&Task<T>) + Send + 'static) -> Background<T> {
        let (mut background, sender) = Background::idle();
        let (cancelled, progress) = (background.cancelled.clone(), background.progress.clone());
        let (task, notify) = (Task { cancelled, progress, values: sender, notify: notify.clone() }, notify.clone());
        let run = move || {
            catch_cancellation(|| work(&task));
            drop(task); // before the window is woken, which polls for the end
            notify();
        };
        match Builder::new().stack_size(STACK).spawn(run) {
            Ok(thread) => background.thread = Some(thread),
            Err(error) => log::warn!("cannot start a thread: {error}"),
        }
        background
    }

    fn idle() -> (Background<T>, mpsc::Sender<T>) {
        let (sender, values) = mpsc::channel();
        let (cancelled, progress) = (Arc::default(), Arc::default());
        (Background { cancelled, progress, values, thread: None }, sender)
    }

    /// A computation that ends only by cancellation, and its cancel flag.
    #[cfg(test)]
    pub(crate) fn endless() -> (Background<T>, Arc<AtomicBool>) {
        let (background, sender) = Background::idle();
        std::mem::forget(sender);
        let cancelled = background.cancelled.clone();
        (background, cancelled)
    }

    /// The next value; `Ready(None)` after the last one, and after a panic of the computation.
    pub(crate) fn poll(&self) -> Poll<Option<T>> {
        match self.values.try_recv() {
            Ok(value) => Poll::Ready(Some(value)),
            Err(TryRecvError::Empty) => Poll::Pending,
            Err(TryRecvError::Disconnected) => Poll::Ready(None),
        }
    }

    /// Waits for the end of the thread; `Err` if it panicked.
    pub(crate) fn join(mut self) -> thread::Result<()> {
        self.thread.take().map_or(Ok(()), JoinHandle::join)
    }
}

impl<T> Background<T> {
    /// Cancels the computation; its values remain to be polled.
    pub(crate) fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// The fraction of the work that is done.
    pub(crate) fn progress(&self) -> f32 {
        f32::from_bits(self.progress.load(Ordering::Relaxed))
    }
}

impl<T> Drop for Background<T> {
    fn drop(&mut self) {
        self.cancel();
    }
}

impl<T> Task<T> {
    /// Sends a value to the window.
    pub(crate) fn send(&self, value: T) {
        // The receiver is gone if the computation was cancelled.
        let _ = self.values.send(value);
        (self.notify)();
    }

    /// Whether the task was cancelled.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Reports progress, and unwinds out of the computation if it was cancelled.
    pub(crate) fn report(&self, fraction: f32) {
        self.progress.store(fraction.to_bits(), Ordering::Relaxed);
        cancel_if(self.is_cancelled());
    }
}

/// The payload that unwinds out of a cancelled computation.
struct Cancelled;

/// Unwinds to [`catch_cancellation`] if `cancelled`. Computations that span threads have no other way out; their partial
/// results are dropped.
pub(crate) fn cancel_if(cancelled: bool) {
    if cancelled {
        panic::resume_unwind(Box::new(Cancelled));
    }
}

/// Runs `work`; `None` if [`cancel_if`] ended it.
pub(crate) fn catch_cancellation<T>(work: impl FnOnce() -> T) -> Option<T> {
    match panic::catch_unwind(AssertUnwindSafe(work)) {
        Ok(done) => Some(done),
        Err(reason) if reason.is::<Cancelled>() => None,
        Err(reason) => panic::resume_unwind(reason),
    }
}
