//! Runs everything of a series: in each round every method once, from round to round in another order.

use super::config::Series;
use super::measure::{End, Measurement, measure};
use super::result::{Distribution, HoleCount, Row, RowOutcome};
use super::scene_store::MadeScene;
use crate::config::MethodName;
use crate::progress::Progress;
use crate::report::{HoleKind, Report};
use crate::{ExitCode, RunError};
use lacuna_schedule::StopFlag;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

/// What takes its turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Contestant {
    /// `cp -R`, then every file flushed to disk: the least that a repair has to do.
    Copy,
    /// `cat` of all files: the least that a scan has to do.
    Read,
    /// lacuna.
    Repair { method: MethodName, threads: usize },
}

/// All files copied, then flushed file by file: others' unwritten data are not this run's.
const COPY: &str = r#"cp -R -- "$1" "$2" && find "$2" -type f -exec sync {} +"#;
const READ: &str = r#"find "$1" -type f -exec cat {} + > /dev/null"#;

impl Contestant {
    fn all_of(series: &Series) -> Vec<Self> {
        let mut all = if series.references { vec![Self::Copy, Self::Read] } else { Vec::new() };
        for &method in &series.methods {
            all.extend(series.threads.iter().map(|&threads| Self::Repair { method, threads }));
        }
        all
    }

    fn word(self) -> &'static str {
        match self {
            Self::Copy => "copy",
            Self::Read => "read",
            Self::Repair { method, .. } => method.word(),
        }
    }

    fn threads(self) -> usize {
        if let Self::Repair { threads, .. } = self { threads } else { 1 }
    }
}

/// How many runs a scene of a series takes.
pub(super) fn run_count(series: &Series) -> usize {
    series.repeats * Contestant::all_of(series).len()
}

/// Where the rounds of one scene happen.
pub(super) struct Ground<'a> {
    /// The lacuna program.
    pub(super) program: &'a Path,
    /// The scene's tiles.
    pub(super) tiles: &'a Path,
    /// Where each run gets a folder of its own, which is removed after it.
    pub(super) out: &'a Path,
    /// What is known of the scene.
    pub(super) made: &'a MadeScene,
}

/// One run with what it left.
struct Run {
    measurement: Measurement,
    outcome: RowOutcome,
    message: Option<String>,
    holes: BTreeMap<String, HoleCount>,
}

/// Runs all rounds on one scene and returns a row for each method and number of threads.
///
/// A method that met a limit or failed does not run again. `None`: the user asked to stop.
///
/// # Errors
/// A program that cannot be started, a folder that cannot be written.
pub(super) fn run_rounds(
    series: &Series,
    ground: &Ground<'_>,
    stop: &StopFlag,
    progress: &Progress,
) -> Result<Option<Vec<Row>>, RunError> {
    let contestants = Contestant::all_of(series);
    let mut rounds: Vec<Vec<Option<Run>>> = Vec::new();
    let mut is_out = vec![false; contestants.len()];
    for round in 0..series.repeats {
        let mut runs: Vec<Option<Run>> = contestants.iter().map(|_| None).collect();
        for turn in 0..contestants.len() {
            // Another first one each round, so that nobody always finds what the same neighbour left in the caches.
            let k = (turn + round) % contestants.len();
            if !is_out[k] {
                let Some(run) = run_once(contestants[k], series, ground, stop)? else { return Ok(None) };
                tracing::info!(
                    series = series.name,
                    scene = ground.made.name,
                    method = contestants[k].word(),
                    threads = contestants[k].threads(),
                    seconds = run.measurement.wall_s,
                    "run"
                );
                is_out[k] = run.outcome != RowOutcome::Done;
                runs[k] = Some(run);
            }
            progress.advance(0);
        }
        rounds.push(runs);
    }
    let copies: Vec<Option<f64>> = rounds.iter().map(|runs| wall_of_copy(&contestants, runs)).collect();
    let row = |k: usize| row(contestants[k], series, ground.made, &rounds, &copies, k);
    Ok(Some((0..contestants.len()).filter_map(row).collect()))
}

fn wall_of_copy(contestants: &[Contestant], runs: &[Option<Run>]) -> Option<f64> {
    let place = contestants.iter().position(|c| *c == Contestant::Copy)?;
    runs[place].as_ref().filter(|r| r.outcome == RowOutcome::Done).map(|r| r.measurement.wall_s)
}

fn run_once(
    contestant: Contestant,
    series: &Series,
    ground: &Ground<'_>,
    stop: &StopFlag,
) -> Result<Option<Run>, RunError> {
    let failed = |e: std::io::Error| RunError::input_output(format!("{}: {e}", ground.out.display()));
    let folder = tempfile::Builder::new().prefix("run-").tempdir_in(ground.out).map_err(failed)?;
    let out = folder.path().join("out");
    let said = folder.path().join("stderr.txt");
    let mut command = command_of(contestant, series, ground, &out);
    command.stdin(Stdio::null()).stdout(Stdio::null());
    command.stderr(std::fs::File::create(&said).map_err(failed)?);
    let measurement = measure(&mut command, series.time_limit_s, stop)?;
    let outcome = match measurement.end {
        End::Stopped => return Ok(None),
        End::TimeLimit => RowOutcome::TimeLimit,
        End::Exit(Some(code)) => outcome_of(code),
        End::Exit(None) => RowOutcome::Failed,
    };
    // The terminal stops the child itself.
    if stop.is_stopped() {
        return Ok(None);
    }
    let mut run = Run { measurement, outcome, message: None, holes: BTreeMap::new() };
    if outcome == RowOutcome::Failed || outcome == RowOutcome::MemoryLimit {
        run.message = Some(last_words(&said, run.measurement.end));
    } else if let (RowOutcome::Done, Contestant::Repair { .. }) = (outcome, contestant) {
        let report = read_report(&out.join("lacuna/report.json"))?;
        run.holes = holes_of(&report);
        run.measurement.peak_rss_bytes = run.measurement.peak_rss_bytes.max(Some(report.peak_rss_bytes));
    }
    Ok(Some(run))
}

fn command_of(contestant: Contestant, series: &Series, ground: &Ground<'_>, out: &Path) -> Command {
    let shell = |script: &str| {
        let mut command = Command::new("sh");
        command.args(["-c", script, "sh"]).args([ground.tiles, out]);
        command
    };
    match contestant {
        Contestant::Copy => shell(COPY),
        Contestant::Read => shell(READ),
        Contestant::Repair { method, threads } => {
            let mut command = Command::new(ground.program);
            command.arg("repair").args([ground.tiles, out]);
            command.args(["--method", method.word(), "--threads", &threads.to_string()]);
            command.args(["--memory", &format!("{}B", series.memory_limit_bytes)]);
            command.args(["--quiet", "--progress", "none"]);
            command
        }
    }
}

/// Exit code 3 is a finished run in which holes failed: the counts show them.
fn outcome_of(code: i32) -> RowOutcome {
    match code {
        0 => RowOutcome::Done,
        c if c == i32::from(ExitCode::Finished.code()) => RowOutcome::Done,
        c if c == i32::from(ExitCode::MemoryTooSmall.code()) => RowOutcome::MemoryLimit,
        _ => RowOutcome::Failed,
    }
}

fn last_words(file: &Path, end: End) -> String {
    let text = std::fs::read_to_string(file).unwrap_or_default();
    let line = text.trim().lines().last().unwrap_or_default().to_owned();
    match end {
        End::Exit(Some(code)) => format!("exit {code}: {line}"),
        _ => format!("ended by a signal: {line}"),
    }
}

fn read_report(path: &Path) -> Result<Report, RunError> {
    let failed = |e: &dyn std::fmt::Display| RunError::input_output(format!("{}: {e}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| failed(&e))?;
    Report::from_json(&text).map_err(|e| failed(&e))
}

fn holes_of(report: &Report) -> BTreeMap<String, HoleCount> {
    let count = |kind: HoleKind| {
        let row = report.summary.by_type.get(kind);
        (kind.key().to_owned(), HoleCount { found: row.found, filled: row.filled, skipped: row.skipped })
    };
    HoleKind::ALL.into_iter().map(count).filter(|(_, c)| c.found > 0).collect()
}

/// The row of the contestant at place `k`, if it ran at all.
fn row(
    contestant: Contestant,
    series: &Series,
    made: &MadeScene,
    rounds: &[Vec<Option<Run>>],
    copies: &[Option<f64>],
    k: usize,
) -> Option<Row> {
    let runs: Vec<&Run> = rounds.iter().filter_map(|runs| runs[k].as_ref()).collect();
    let last = runs.last()?;
    let is_done = last.outcome == RowOutcome::Done;
    let median = |value: fn(&Measurement) -> Option<f64>| {
        let values: Vec<f64> = runs.iter().filter_map(|r| value(&r.measurement)).collect();
        Distribution::of(&values)
    };
    let bytes = |d: Option<Distribution>| d.map(|d| d.median.round() as u64);
    let wall_s = median(|m| Some(m.wall_s));
    let in_round = |(runs, copy): (&Vec<Option<Run>>, &Option<f64>)| {
        Some(runs[k].as_ref()?.measurement.wall_s / copy.filter(|s| *s > 0.0)?)
    };
    let ratios: Vec<f64> = rounds.iter().zip(copies).filter_map(in_round).collect();
    Some(Row {
        series: series.name.clone(),
        scene: made.name.clone(),
        method: contestant.word().to_owned(),
        threads: contestant.threads(),
        memory_limit_bytes: match contestant {
            Contestant::Repair { .. } => Some(series.memory_limit_bytes),
            Contestant::Copy | Contestant::Read => None,
        },
        outcome: last.outcome,
        message: last.message.clone(),
        runs: runs.len(),
        wall_s,
        cpu_s: median(|m| m.cpu_s).map(|d| d.median),
        peak_rss_bytes: runs.iter().filter_map(|r| r.measurement.peak_rss_bytes).max(),
        read_bytes: bytes(median(|m| m.read_bytes.map(|b| b as f64))),
        written_bytes: bytes(median(|m| m.written_bytes.map(|b| b as f64))),
        cells_per_s: wall_s.filter(|w| is_done && w.median > 0.0).map(|w| made.cells as f64 / w.median),
        ratio_to_copy: Distribution::of(&ratios).filter(|_| is_done),
        holes: last.holes.clone(),
        samples: runs[0].measurement.samples.clone(),
    })
}
