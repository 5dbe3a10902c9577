//! Ctrl-C and SIGTERM as one flag that workers read between tiles.

use lacuna_schedule::StopFlag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Raised when the user asks the run to stop.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    stop: StopFlag,
    terminate: Arc<AtomicBool>,
}

impl Interrupt {
    /// A flag that SIGINT and SIGTERM raise. The second signal ends the process at once.
    ///
    /// # Errors
    /// The system refuses the handlers.
    pub fn on_signals() -> std::io::Result<Self> {
        let interrupt = Self::default();
        for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
            signal_hook::flag::register_conditional_default(signal, interrupt.stop.shared())?;
            signal_hook::flag::register(signal, interrupt.stop.shared())?;
        }
        signal_hook::flag::register(signal_hook::consts::SIGTERM, Arc::clone(&interrupt.terminate))?;
        Ok(interrupt)
    }

    /// The flag that workers read.
    #[must_use]
    pub fn stop_flag(&self) -> StopFlag {
        self.stop.clone()
    }

    /// True if it was SIGTERM.
    #[must_use]
    pub fn is_terminate(&self) -> bool {
        self.terminate.load(Ordering::Relaxed)
    }
}
