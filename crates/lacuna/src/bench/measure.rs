//! One run in a process of its own: how long, how much memory, how much read and written.

use super::result::Sample;
use crate::RunError;
use lacuna_schedule::StopFlag;
use lacuna_system::{WatchedChild, peak_rss_bytes, transferred_bytes};
use std::process::Command;
use std::time::{Duration, Instant};

/// How long the loop sleeps: what a wall-clock time may be too long by.
const TICK: Duration = Duration::from_millis(1);
/// Distance of memory samples in the first second and later: short runs peak in a few milliseconds.
const SAMPLING: [Duration; 2] = [Duration::from_millis(4), Duration::from_millis(50)];
/// Most samples that are kept of a run; of neighbours that are joined the higher one stays.
const MOST_SAMPLES: usize = 1000;

/// The kernel counts resident pages in batches: two figures of one process may differ by this much.
const INEXACT_BYTES: u64 = 1 << 20;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// With this exit code; `None`: a signal ended it.
    Exit(Option<i32>),
    /// It was stopped because it took too long.
    TimeLimit,
    /// The user asked to stop.
    Stopped,
}

/// What one run took.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Measurement {
    pub(super) end: End,
    pub(super) wall_s: f64,
    pub(super) cpu_s: Option<f64>,
    pub(super) peak_rss_bytes: Option<u64>,
    pub(super) read_bytes: Option<u64>,
    pub(super) written_bytes: Option<u64>,
    pub(super) samples: Vec<Sample>,
}

/// Runs a command to its end, its time limit, or until the user stops.
///
/// # Errors
/// The command cannot be started, or the system does not tell how it ended.
pub(super) fn measure(
    command: &mut Command,
    time_limit_s: f64,
    stop: &StopFlag,
) -> Result<Measurement, RunError> {
    let program = command.get_program().to_string_lossy().into_owned();
    let failed = |e: std::io::Error| RunError::failed(format!("{program}: cannot be run: {e}"));
    let before = transferred_bytes();
    let start = Instant::now();
    let mut child = WatchedChild::spawn(command).map_err(&failed)?;
    let mut watch = Watch::new(start);
    let mut stopped = None;
    let (usage, wall_s) = loop {
        let ended = child.poll().map_err(&failed)?;
        let wall_s = start.elapsed().as_secs_f64();
        if let Some(usage) = ended {
            break (usage, wall_s);
        }
        if stopped.is_none() {
            stopped = match (stop.is_stopped(), wall_s > time_limit_s) {
                (true, _) => Some(End::Stopped),
                (_, true) => Some(End::TimeLimit),
                _ => None,
            };
            if stopped.is_some() {
                child.kill().map_err(&failed)?;
            }
        }
        watch.look(&child);
        std::thread::sleep(TICK);
    };
    let moved = before.zip(transferred_bytes());
    // The system counts in what this process itself had resident when it started the child.
    let own_peak_bytes = peak_rss_bytes().map_or(u64::MAX, |bytes| bytes + INEXACT_BYTES);
    let told = usage.peak_rss_bytes.filter(|&bytes| bytes > own_peak_bytes);
    Ok(Measurement {
        end: stopped.unwrap_or(End::Exit(usage.status.code())),
        wall_s,
        cpu_s: usage.cpu_seconds,
        peak_rss_bytes: told.max(watch.peak_bytes),
        read_bytes: moved.map(|(b, a)| a.read_bytes.saturating_sub(b.read_bytes + watch.own_bytes)),
        written_bytes: moved.map(|(b, a)| a.written_bytes.saturating_sub(b.written_bytes)),
        samples: watch.samples,
    })
}

/// Memory of a child over time.
struct Watch {
    start: Instant,
    next: Duration,
    stretch: u32,
    peak_bytes: Option<u64>,
    /// Read from `/proc` by this process meanwhile: not the child's.
    own_bytes: u64,
    samples: Vec<Sample>,
}

impl Watch {
    fn new(start: Instant) -> Self {
        Self { start, next: Duration::ZERO, stretch: 1, peak_bytes: None, own_bytes: 0, samples: Vec::new() }
    }

    fn look(&mut self, child: &WatchedChild) {
        let now = self.start.elapsed();
        if now < self.next {
            return;
        }
        self.next = now + SAMPLING[usize::from(now > Duration::from_secs(1))] * self.stretch;
        let before = transferred_bytes();
        if let Some(memory) = child.resident() {
            self.peak_bytes = self.peak_bytes.max(Some(memory.peak_bytes));
            self.samples.push(Sample { at_s: now.as_secs_f64(), rss_bytes: memory.now_bytes });
        }
        let after = transferred_bytes();
        self.own_bytes += before.zip(after).map_or(0, |(b, a)| a.read_bytes - b.read_bytes);
        if self.samples.len() >= MOST_SAMPLES {
            self.samples = halved(&self.samples);
            self.stretch *= 2;
        }
    }
}

/// Half as many samples, of each two the higher one.
fn halved(samples: &[Sample]) -> Vec<Sample> {
    let higher = |pair: &[Sample]| pair.iter().copied().max_by_key(|s| s.rss_bytes);
    samples.chunks(2).filter_map(higher).collect()
}
