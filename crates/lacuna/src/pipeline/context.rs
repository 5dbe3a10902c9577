//! What all stages of a run share: settings, threads, memory, the stop flag, progress, and the clock.

use super::error::{RunError, Shortage};
use crate::config::Settings;
use crate::progress::Progress;
use crate::report::StageRecord;
use crate::{ExitCode, Interrupt};
use lacuna_schedule::{MemoryBudget, Pool, StopFlag};
use lacuna_tile::{ReadOptions, UpAxis};
use std::sync::atomic::{AtomicU64, Ordering};
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
    /// True if tiles are drawn while they are in memory, for the pictures of a report.
    pub(crate) draws: bool,
    /// What the last budget stood beside.
    held_bytes: AtomicU64,
    /// The most that any stage needs for one tile, as far as headers tell.
    tile_bytes: AtomicU64,
}

impl<'a> Context<'a> {
    pub(crate) fn new(
        settings: &'a Settings,
        interrupt: &'a Interrupt,
        progress: &'a Progress,
    ) -> Result<Self, RunError> {
        let left = settings.run.memory_limit_bytes.saturating_sub(BASE_BYTES);
        Ok(Self {
            settings,
            pool: Pool::new(settings.run.threads).map_err(|e| RunError::failed(e.to_string()))?,
            budget: MemoryBudget::new(left),
            stop: interrupt.stop_flag(),
            interrupt,
            progress,
            held_bytes: AtomicU64::new(BASE_BYTES),
            tile_bytes: AtomicU64::new(0),
            draws: true,
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

    /// The context of a run that writes no tile, so that nobody asks what was in them; `draws` if a report shows them.
    pub(crate) fn only_looking(mut self, draws: bool) -> Self {
        self.read_options.skip_hash = true;
        self.draws = draws;
        self
    }

    /// Gives freed memory back where the limit is near: what a tile leaves free the next one takes without a page fault.
    pub(crate) fn trim_if_tight(&self) {
        let resident = lacuna_system::current_rss_bytes().unwrap_or(u64::MAX);
        if resident > self.settings.run.memory_limit_bytes / 2 {
            lacuna_system::trim();
        }
    }

    /// What the limit leaves beside what is in memory now and `kept_bytes` that a stage will keep.
    pub(crate) fn budget_beside(&self, kept_bytes: u64) -> MemoryBudget {
        lacuna_system::trim();
        let resident = lacuna_system::current_rss_bytes().unwrap_or(BASE_BYTES).max(BASE_BYTES);
        let held = resident.saturating_add(kept_bytes);
        self.held_bytes.store(held, Ordering::Relaxed);
        MemoryBudget::new(self.settings.run.memory_limit_bytes.saturating_sub(held))
    }

    /// True if the run fills and writes, and does not only look.
    pub(crate) fn writes_tiles(&self) -> bool {
        self.settings.scene.output.is_some() && !self.settings.run.dry_run
    }

    /// Remembers what the largest tile needs, so that a limit which is asked for later holds it too.
    pub(crate) fn expect_tile(&self, needed_bytes: u64) {
        self.tile_bytes.fetch_max(needed_bytes, Ordering::Relaxed);
    }

    /// The error for a job that a stage's budget (of `left_bytes`) does not hold, with a limit that would.
    pub(crate) fn memory_too_small(&self, what: &str, needed_bytes: u64, left_bytes: u64) -> RunError {
        let limit_bytes = self.settings.run.memory_limit_bytes;
        // A budget of nothing does not tell how far below nothing it would have been.
        let held_bytes = self.held_bytes.load(Ordering::Relaxed).max(limit_bytes.saturating_sub(left_bytes));
        let most = needed_bytes.max(self.tile_bytes.load(Ordering::Relaxed));
        let least_bytes = limit_for(held_bytes, most);
        RunError::memory_too_small(what, &Shortage { needed_bytes, held_bytes, limit_bytes, least_bytes })
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

/// A limit for work beside what is held, with room for what differs from run to run.
pub(crate) fn limit_for(held_bytes: u64, needed_bytes: u64) -> u64 {
    held_bytes.saturating_add(needed_bytes).saturating_add(SLACK_BYTES)
}

/// Measures the stages of a run.
#[derive(Default)]
pub(crate) struct Stages {
    pub(crate) records: Vec<StageRecord>,
}

impl Stages {
    /// Runs one stage and records its time and peak memory.
    pub(crate) fn measure<T>(&mut self, name: &str, stage: impl FnOnce() -> T) -> T {
        let clock = Stopwatch::start();
        let result = stage();
        self.records.push(clock.stop(name));
        result
    }
}

/// Wall-clock and processor time since a stage began.
#[derive(Clone, Copy)]
pub(crate) struct Stopwatch {
    start: Instant,
    cpu_seconds: f64,
}

impl Stopwatch {
    pub(crate) fn start() -> Self {
        Self { start: Instant::now(), cpu_seconds: lacuna_system::cpu_seconds().unwrap_or(0.0) }
    }

    /// The record of the stage that ends now.
    pub(crate) fn stop(self, name: &str) -> StageRecord {
        StageRecord {
            name: name.to_owned(),
            seconds: self.start.elapsed().as_secs_f64(),
            cpu_seconds: lacuna_system::cpu_seconds().unwrap_or(0.0) - self.cpu_seconds,
            peak_rss_bytes: lacuna_system::peak_rss_bytes().unwrap_or(0),
        }
    }
}
