//! The wish to stop, shared by everybody who may have it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that starts lowered and, once raised, stays so. Clones share it.
///
/// It is read between jobs, and may be read inside long work; a job that runs is not interrupted by it.
#[derive(Clone, Debug, Default)]
pub struct StopFlag {
    raised: Arc<AtomicBool>,
}

impl StopFlag {
    /// A lowered flag.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks everybody to stop.
    pub fn stop(&self) {
        self.raised.store(true, Ordering::Release);
    }

    /// Shall we stop?
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.raised.load(Ordering::Acquire)
    }

    /// The flag itself, for a signal handler that can only set an atomic.
    #[must_use]
    pub fn shared(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.raised)
    }
}
