//! Threads and memory of `verify`.

use crate::{ExitCode, Interrupt, RunError};
use lacuna_schedule::{Job, JobResult, MemoryBudget, Pool};

/// Runs the checks of tiles in parallel, under the memory limit.
pub(super) struct Work<'a> {
    pool: Pool,
    budget: MemoryBudget,
    interrupt: &'a Interrupt,
}

impl<'a> Work<'a> {
    /// `threads` = 0: one a processor.
    pub(super) fn new(threads: usize, limit_bytes: u64, interrupt: &'a Interrupt) -> Result<Self, RunError> {
        let pool =
            Pool::new(threads).map_err(|e| RunError { exit: ExitCode::Failed, message: e.to_string() })?;
        Ok(Self { pool, budget: MemoryBudget::new(limit_bytes), interrupt })
    }

    /// Calls `work` for 0..count; results in that order. `bytes` says how much memory a call takes.
    pub(super) fn each<T: Send>(
        &self,
        count: usize,
        bytes: impl Fn(usize) -> u64,
        work: impl Fn(usize) -> T + Sync,
    ) -> Result<Vec<T>, RunError> {
        let jobs: Vec<Job> = (0..count).map(|k| Job { key: k as u64, bytes: bytes(k) }).collect();
        let stop = self.interrupt.stop_flag();
        let results = self.pool.run(&jobs, &self.budget, &stop, work, |_| {}).map_err(|e| RunError {
            exit: ExitCode::MemoryTooSmall,
            message: format!(
                "checking a tile needs about {0} MiB, which is more than the memory limit; give at least --memory {0}MiB",
                e.needed_bytes.div_ceil(1 << 20)
            ),
        })?;
        results.into_iter().map(|result| self.finished(result)).collect()
    }

    fn finished<T>(&self, result: JobResult<T>) -> Result<T, RunError> {
        match result {
            JobResult::Done(value) => Ok(value),
            JobResult::Panicked(message) => Err(RunError {
                exit: ExitCode::Failed,
                message: format!("a fault of the program while checking: {message}"),
            }),
            JobResult::Stopped => Err(RunError {
                exit: if self.interrupt.is_terminate() {
                    ExitCode::Terminated
                } else {
                    ExitCode::Interrupted
                },
                message: "stopped; nothing was written".to_owned(),
            }),
        }
    }
}
