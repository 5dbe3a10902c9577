//! The system allocator with a count of the bytes in use and of their peak.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicI64, Ordering::Relaxed};

/// A thread reports to the shared count only after this many bytes, so that small allocations touch no shared line.
const BATCH_BYTES: i64 = 64 << 10;

static CURRENT: AtomicI64 = AtomicI64::new(0);
static PEAK: AtomicI64 = AtomicI64::new(0);

thread_local! {
    // Constant and without a destructor: reading it never allocates, which an allocator must not do.
    static PENDING: Cell<i64> = const { Cell::new(0) };
}

/// The system allocator, counting. Install it in the binary:
///
/// ```
/// #[global_allocator]
/// static ALLOCATOR: lacuna_system::CountingAllocator = lacuna_system::CountingAllocator;
/// ```
///
/// Each thread keeps up to 64 KiB of difference to itself, so current and peak are right to 64 KiB for each thread that
/// ever ran. Mapped pages, thread stacks and the allocator's own slack are not seen: for these, see
/// [`peak_rss_bytes`](crate::peak_rss_bytes).
#[derive(Clone, Copy, Debug, Default)]
pub struct CountingAllocator;

// SAFETY: every call is handed to `System` unchanged, and its answer is returned unchanged; counting neither allocates
// nor unwinds.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract of `GlobalAlloc::alloc`, which is also that of `System`.
        let block = unsafe { System.alloc(layout) };
        count_if(block, layout.size(), 0);
        block
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as in `alloc`.
        let block = unsafe { System.alloc_zeroed(layout) };
        count_if(block, layout.size(), 0);
        block
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the caller got `block` from this allocator with this layout, so `System` made it.
        unsafe { System.dealloc(block, layout) };
        count(-signed(layout.size()));
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        // SAFETY: as in `dealloc`; `new_size` is the caller's promise, passed on.
        let moved = unsafe { System.realloc(block, layout, new_size) };
        count_if(moved, new_size, layout.size());
        moved
    }
}

/// Bytes that are allocated now; 0 if [`CountingAllocator`] is not installed.
#[must_use]
pub fn allocated_bytes() -> u64 {
    flush();
    unsigned(CURRENT.load(Relaxed))
}

/// Largest number of bytes allocated at one time since the start or the last [`reset_peak_allocated`].
#[must_use]
pub fn peak_allocated_bytes() -> u64 {
    flush();
    unsigned(PEAK.load(Relaxed))
}

/// Makes the present allocation the peak, so that the next reading is the peak of what follows.
pub fn reset_peak_allocated() {
    flush();
    PEAK.store(CURRENT.load(Relaxed), Relaxed);
}

/// Counts a change of size, unless the allocation failed.
fn count_if(block: *mut u8, new_size: usize, old_size: usize) {
    if !block.is_null() {
        count(signed(new_size) - signed(old_size));
    }
}

/// Adds to the thread's own count; reports when the batch is full.
fn count(change: i64) {
    let batch = PENDING.try_with(|pending| {
        let sum = pending.get() + change;
        let full = sum.abs() >= BATCH_BYTES;
        pending.set(if full { 0 } else { sum });
        if full { sum } else { 0 }
    });
    // Without its own count (a thread at its very end) the thread reports at once.
    match batch.unwrap_or(change) {
        0 => {}
        sum => report(sum),
    }
}

/// Reports what the calling thread still keeps to itself.
fn flush() {
    report(PENDING.try_with(Cell::take).unwrap_or(0));
}

fn report(change: i64) {
    let now = CURRENT.fetch_add(change, Relaxed) + change;
    PEAK.fetch_max(now, Relaxed);
}

/// A layout's size is at most `isize::MAX`.
fn signed(size: usize) -> i64 {
    size as i64
}

/// Another thread may have reported a release before the allocation was: below zero reads as zero.
fn unsigned(bytes: i64) -> u64 {
    u64::try_from(bytes).unwrap_or(0)
}
