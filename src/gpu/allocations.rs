//! Allocations of a thread, counted for tests.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    /// Allocations of this thread so far.
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

/// The allocator of the system, which counts.
struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

impl Counting {
    fn count() {
        COUNT.with(|count| count.set(count.get() + 1));
    }
}

// SAFETY: the system allocates; the counter is a constant of its thread until set, and allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        Counting::count();
        // SAFETY: the caller's layout.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        Counting::count();
        // SAFETY: the caller's layout.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        Counting::count();
        // SAFETY: the caller's block, which the system has allocated.
        unsafe { System.realloc(block, layout, size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the caller's block, which the system has allocated.
        unsafe { System.dealloc(block, layout) }
    }
}

/// The result of a function, and how often this thread allocated memory in it.
pub(crate) fn allocations<T>(of: impl FnOnce() -> T) -> (T, u64) {
    let before = COUNT.with(Cell::get);
    let result = of();
    (result, COUNT.with(Cell::get) - before)
}

#[test]
fn allocations_of_this_thread_are_counted() {
    let all = || std::thread::spawn(|| vec![vec![0u8; 10]; 100].len()).join().unwrap();
    let ((), none) = allocations(|| ());
    let (_, some) = allocations(all);
    assert_eq!(none, 0);
    assert!((1..100).contains(&some), "{some}");
}
