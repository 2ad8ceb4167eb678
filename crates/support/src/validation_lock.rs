//! A lock for tests that open devices with validation.
//!
//! The validation layer of Debian 12 (1.3.239) keeps instances and devices in a table without a lock: it occasionally
//! crashes when one thread opens or closes a device while another uses its own (KhronosGroup/Vulkan-ValidationLayers,
//! issue 4391). Devices without validation are not in that table.

use std::cell::Cell;
use std::sync::{Mutex, MutexGuard, PoisonError};

static LOCK: Mutex<()> = Mutex::new(());

thread_local! {
    static IS_HELD: Cell<bool> = const { Cell::new(false) };
}

/// Guard that a test holds for longer than its devices.
pub struct ValidationLock {
    _guard: MutexGuard<'static, ()>,
}

impl ValidationLock {
    /// Waits for the other tests.
    pub fn acquire() -> ValidationLock {
        let guard = LOCK.lock().unwrap_or_else(PoisonError::into_inner);
        IS_HELD.set(true);
        ValidationLock { _guard: guard }
    }

    /// Whether this thread holds the lock.
    pub fn is_held() -> bool {
        IS_HELD.get()
    }
}

impl Drop for ValidationLock {
    fn drop(&mut self) {
        IS_HELD.set(false);
    }
}
