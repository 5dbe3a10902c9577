//! How the process ends.

use std::fmt;

/// Exit codes of the command line (product.md, "Command line").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExitCode {
    /// The verb did what was asked; deliberate skips are no failures.
    Done = 0,
    /// The run failed as a whole, or `verify` found a broken promise.
    Failed = 1,
    /// The command line or the configuration is wrong, or the output folder is refused; nothing was written.
    Usage = 2,
    /// The run finished, but tiles or holes failed (`--fail-on`); the report says which and why.
    Finished = 3,
    /// Input or output: unreadable scene, full disk.
    InputOutput = 4,
    /// The memory limit is too small for a tile, or for what is kept of all; said before a tile is written.
    MemoryTooSmall = 5,
    /// Another run holds the output folder.
    Busy = 75,
    /// Stopped by SIGINT (Ctrl-C); the same command goes on where it stopped.
    Interrupted = 130,
    /// Stopped by SIGTERM; the same command goes on where it stopped.
    Terminated = 143,
}

impl ExitCode {
    /// The number the shell sees.
    #[must_use]
    pub fn code(self) -> u8 {
        self as u8
    }
}

impl fmt::Display for ExitCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "exit code {}", self.code())
    }
}

impl From<ExitCode> for std::process::ExitCode {
    fn from(code: ExitCode) -> Self {
        Self::from(code.code())
    }
}
