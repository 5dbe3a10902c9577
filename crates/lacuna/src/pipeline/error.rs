//! Why a run ends early.

use crate::ExitCode;
use std::fmt;

/// A run that could not be finished: what to print, and how the process ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunError {
    /// How the process ends.
    pub exit: ExitCode,
    /// One sentence: what is wrong, where, and what to do.
    pub message: String,
}

impl RunError {
    pub(crate) fn failed(message: impl Into<String>) -> Self {
        Self { exit: ExitCode::Failed, message: message.into() }
    }

    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self { exit: ExitCode::Usage, message: message.into() }
    }

    pub(crate) fn input_output(message: impl Into<String>) -> Self {
        Self { exit: ExitCode::InputOutput, message: message.into() }
    }

    /// The limit does not hold what is named: a tile, or the holes of a cell.
    pub(crate) fn memory_too_small(what: &str, needed_bytes: u64, left_bytes: u64, least_bytes: u64) -> Self {
        let mebibytes = |bytes: u64| bytes.div_ceil(1 << 20);
        let message = format!(
            "{} needs about {} MiB, but the memory limit leaves {} MiB; give at least --memory {}MiB",
            what.escape_debug(),
            mebibytes(needed_bytes),
            mebibytes(left_bytes),
            mebibytes(least_bytes),
        );
        Self { exit: ExitCode::MemoryTooSmall, message }
    }
}

impl fmt::Display for RunError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for RunError {}
