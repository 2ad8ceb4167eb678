//! One test at a time has devices under validation.
//!
//! The layer of Debian 12 (1.3.239) keeps instances and devices in a table without a lock: now and then it crashes where one
//! thread opens or closes a device while another one uses its own (KhronosGroup/Vulkan-ValidationLayers, issue 4391).
//! Devices without validation are not in that table.

use std::cell::Cell;
use std::sync::{Mutex, MutexGuard, PoisonError};

static TURN: Mutex<()> = Mutex::new(());

thread_local! {
    static IS_HELD: Cell<bool> = const { Cell::new(false) };
}

/// Held by the test whose turn it is, for longer than its devices.
pub struct Alone {
    _turn: MutexGuard<'static, ()>,
}

impl Alone {
    /// Waits for the other tests.
    pub fn enter() -> Alone {
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        IS_HELD.set(true);
        Alone { _turn: turn }
    }

    /// Whether it is the turn of this thread.
    pub fn is_held() -> bool {
        IS_HELD.get()
    }
}

impl Drop for Alone {
    fn drop(&mut self) {
        IS_HELD.set(false);
    }
}
