//! What all stages of a run share: settings, threads, memory, the stop flag, progress, and the clock.

use super::RunError;
use crate::config::Settings;
use crate::progress::Progress;
use crate::report::StageRecord;
use crate::{ExitCode, Interrupt};
use lacuna_schedule::{MemoryBudget, Pool, StopFlag};
use lacuna_tile::{ReadOptions, UpAxis};
use std::time::Instant;

/// What the program itself takes beside the tiles in work, bytes: code, plan, allocator slack.
pub(crate) const BASE_BYTES: u64 = 24 << 20;

/// What the memory in use may differ by from run to run, bytes.
const SLACK_BYTES: u64 = 8 << 20;

/// The stages that show progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StageKind {
    Scan,
    Fill,
    Seams,
    Write,
}

/// Shared by all stages of one run.
pub(crate) struct Context<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) pool: Pool,
    pub(crate) budget: MemoryBudget,
    pub(crate) stop: StopFlag,
    pub(crate) interrupt: &'a Interrupt,
    pub(crate) progress: &'a Progress,
    pub(crate) read_options: ReadOptions,
}

impl<'a> Context<'a> {
    pub(crate) fn new(
        settings: &'a Settings,
        interrupt: &'a Interrupt,
        progress: &'a Progress,
    ) -> Result<Self, RunError> {
        let limit = settings.run.memory_limit_bytes;
        let left = limit.saturating_sub(BASE_BYTES);
        if left == 0 {
            return Err(RunError::memory_too_small("the program itself", 0, 0, BASE_BYTES + (1 << 20)));
        }
        Ok(Self {
            settings,
            pool: Pool::new(settings.run.threads).map_err(|e| RunError::failed(e.to_string()))?,
            budget: MemoryBudget::new(left),
            stop: interrupt.stop_flag(),
            interrupt,
            progress,
            read_options: ReadOptions {
                up_axis: settings.scene.up_axis.map(|a| match a {
                    crate::config::UpAxis::Y => UpAxis::Y,
                    crate::config::UpAxis::Z => UpAxis::Z,
                }),
                max_bytes: settings.run.untrusted.then_some(4 << 30),
                ..ReadOptions::default()
            },
        })
    }

    /// What the limit leaves beside what is in memory now and `kept_bytes` that a stage will keep.
    pub(crate) fn budget_beside(&self, kept_bytes: u64) -> MemoryBudget {
        lacuna_system::trim();
        let resident = lacuna_system::current_rss_bytes().unwrap_or(BASE_BYTES).max(BASE_BYTES);
        MemoryBudget::new(
            self.settings.run.memory_limit_bytes.saturating_sub(resident.saturating_add(kept_bytes)),
        )
    }

    /// The error for a job that a stage's budget does not hold, with the limit that would.
    pub(crate) fn memory_too_small(&self, what: &str, needed_bytes: u64, left_bytes: u64) -> RunError {
        let taken = self.settings.run.memory_limit_bytes.saturating_sub(left_bytes);
        RunError::memory_too_small(
            what,
            needed_bytes,
            left_bytes,
            taken.saturating_add(needed_bytes).saturating_add(SLACK_BYTES),
        )
    }

    /// An error if the user asked to stop.
    pub(crate) fn check_stop(&self) -> Result<(), RunError> {
        if !self.stop.is_stopped() {
            return Ok(());
        }
        let exit = if self.interrupt.is_terminate() { ExitCode::Terminated } else { ExitCode::Interrupted };
        Err(RunError {
            exit,
            message: "stopped; nothing half-written is left, and the same command does the rest".to_owned(),
        })
    }
}

/// Measures the stages of a run.
#[derive(Default)]
pub(crate) struct Stages {
    pub(crate) records: Vec<StageRecord>,
}

impl Stages {
    /// Runs one stage and records its time and peak memory.
    pub(crate) fn measure<T>(&mut self, name: &str, stage: impl FnOnce() -> T) -> T {
        let (start, cpu) = (Instant::now(), lacuna_system::cpu_seconds().unwrap_or(0.0));
        let result = stage();
        self.records.push(StageRecord {
            name: name.to_owned(),
            seconds: start.elapsed().as_secs_f64(),
            cpu_seconds: lacuna_system::cpu_seconds().unwrap_or(0.0) - cpu,
            peak_rss_bytes: lacuna_system::peak_rss_bytes().unwrap_or(0),
        });
        result
    }
}
