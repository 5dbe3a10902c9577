//! Ctrl-C and SIGTERM as one flag that workers read between tiles, and as an end at once where nothing is being written.

use crate::ExitCode;
use lacuna_schedule::StopFlag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Raised when the user asks the run to stop.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    stop: StopFlag,
    terminate: Arc<AtomicBool>,
    /// True while a signal may end the process at once.
    at_once: Arc<AtomicBool>,
}

impl Interrupt {
    /// A flag that SIGINT and SIGTERM raise. The second signal ends the process at once.
    ///
    /// # Errors
    /// The system refuses the handlers.
    pub fn on_signals() -> std::io::Result<Self> {
        let interrupt = Self::default();
        for (signal, exit) in [
            (signal_hook::consts::SIGINT, ExitCode::Interrupted),
            (signal_hook::consts::SIGTERM, ExitCode::Terminated),
        ] {
            let at_once = Arc::clone(&interrupt.at_once);
            signal_hook::flag::register_conditional_shutdown(signal, exit.code().into(), at_once)?;
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

    /// Runs work that writes no file: a signal meanwhile ends the process at once, with the same exit code. So long
    /// kernels need not look at the flag.
    pub(crate) fn end_at_once_during<T>(&self, work: impl FnOnce() -> T) -> T {
        self.at_once.store(true, Ordering::SeqCst);
        let result = work();
        self.at_once.store(false, Ordering::SeqCst);
        result
    }

    /// True if it was SIGTERM.
    #[must_use]
    pub fn is_terminate(&self) -> bool {
        self.terminate.load(Ordering::Relaxed)
    }
}
