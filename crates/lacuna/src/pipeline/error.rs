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
    pub(crate) fn memory_too_small(what: &str, shortage: &Shortage) -> Self {
        let mebibytes = |bytes: u64| bytes.div_ceil(1 << 20);
        let message = format!(
            "{} needs about {} MiB beside the {} MiB that the program holds, but the memory limit is {} MiB; \
             give at least --memory {}MiB",
            what.escape_debug(),
            mebibytes(shortage.needed_bytes),
            mebibytes(shortage.held_bytes),
            shortage.limit_bytes >> 20,
            mebibytes(shortage.least_bytes),
        );
        Self { exit: ExitCode::MemoryTooSmall, message }
    }
}

/// How much memory is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shortage {
    /// What the work that does not fit needs.
    pub(crate) needed_bytes: u64,
    /// What is in memory beside it: the program, surveys, patches.
    pub(crate) held_bytes: u64,
    /// `--memory`.
    pub(crate) limit_bytes: u64,
    /// A limit that this and all later stages fit into.
    pub(crate) least_bytes: u64,
}

impl fmt::Display for RunError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for RunError {}
