//! The verb: makes the scenes, runs the rounds, writes tables and pictures.

use super::config::{BenchConfig, SceneSpec};
use super::guard::worsened;
use super::measure::{End, measure};
use super::pictures::pictures;
use super::result::{BenchResult, MachineFacts, RESULT_VERSION, Row, RowOutcome, Sample};
use super::rounds::{Ground, run_count, run_rounds};
use super::scene_store::{MadeScene, find, make, plan, tiles_folder};
use super::table::markdown;
use crate::config::Machine;
use crate::progress::Progress;
use crate::{ExitCode, Interrupt, RunError};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What the command line asks for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BenchOptions {
    /// The configuration file.
    pub config: PathBuf,
    /// Where scenes, tables and pictures go.
    pub out: PathBuf,
    /// `bench.json` of an earlier run to compare with.
    pub baseline: Option<PathBuf>,
    /// Make this scene of the configuration and end: what the bench starts itself with, so that its own memory stays
    /// small while scenes are made.
    pub only_make: Option<String>,
}

/// What a bench found.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchOutcome {
    /// The tables in Markdown.
    pub tables: String,
    /// What got worse than in the baseline.
    pub worsened: Vec<String>,
    /// [`ExitCode::Done`]; [`ExitCode::Failed`] if something got worse; [`ExitCode::Finished`] if a method failed
    /// otherwise than at a limit.
    pub exit: ExitCode,
}

/// Measures what the configuration asks for and writes `bench.json`, `samples.json`, `bench.md` and pictures into the
/// output folder, where the scenes stay for the next run.
///
/// # Errors
/// A configuration or baseline that cannot be used; scenes that cannot be made; files that cannot be written; the
/// user's wish to stop.
pub fn bench(
    options: &BenchOptions,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<BenchOutcome, RunError> {
    let machine = Machine::detect();
    let config = BenchConfig::read(&options.config, &machine).map_err(|e| RunError::usage(e.to_string()))?;
    let store = options.out.join("scenes");
    if let Some(name) = &options.only_make {
        return make_one(&config, &store, name);
    }
    let baseline = options.baseline.as_deref().map(read_baseline).transpose()?;
    std::fs::create_dir_all(&store).map_err(|e| failed_at(&store, &e))?;
    let program = std::env::current_exe()
        .map_err(|e| RunError::failed(format!("the path of this program is not known: {e}")))?;
    let scenes = make_missing(&config, options, &store, &program, interrupt, progress)?;
    let rows = measure_all(&config, &scenes, options, &program, interrupt, progress)?;
    progress.finish();
    let result = BenchResult {
        version: RESULT_VERSION,
        lacuna: env!("CARGO_PKG_VERSION").to_owned(),
        machine: MachineFacts { threads: machine.threads, memory_bytes: machine.memory_bytes },
        scenes,
        rows,
    };
    let tables = write_all(&result, &options.out)?;
    let worsened = baseline.map_or_else(Vec::new, |b| worsened(&result, &b));
    let has_failed = result.rows.iter().any(|r| r.outcome == RowOutcome::Failed);
    let exit = match (worsened.is_empty(), has_failed) {
        (false, _) => ExitCode::Failed,
        (true, true) => ExitCode::Finished,
        (true, false) => ExitCode::Done,
    };
    Ok(BenchOutcome { tables, worsened, exit })
}

fn failed_at(path: &Path, e: &dyn std::fmt::Display) -> RunError {
    RunError::input_output(format!("{}: {e}", path.display()))
}

fn read_baseline(path: &Path) -> Result<BenchResult, RunError> {
    let wrong = |e: &dyn std::fmt::Display| {
        RunError::usage(format!("{}: no bench.json of an earlier run: {e}", path.display()))
    };
    let text = std::fs::read_to_string(path).map_err(|e| wrong(&e))?;
    serde_json::from_str(&text).map_err(|e| wrong(&e))
}

fn make_one(config: &BenchConfig, store: &Path, name: &str) -> Result<BenchOutcome, RunError> {
    let mut specs = config.series.iter().flat_map(|s| &s.scenes);
    let unknown = || RunError::usage(format!("{}: no such scene in the configuration", name.escape_debug()));
    make(store, specs.find(|s| s.folder_name() == name).ok_or_else(unknown)?)?;
    Ok(BenchOutcome { tables: String::new(), worsened: Vec::new(), exit: ExitCode::Done })
}

/// Every scene of the configuration once.
fn distinct_scenes(config: &BenchConfig) -> Vec<&SceneSpec> {
    let mut specs: Vec<&SceneSpec> = Vec::new();
    for spec in config.series.iter().flat_map(|s| &s.scenes) {
        if !specs.contains(&spec) {
            specs.push(spec);
        }
    }
    specs
}

/// Makes the scenes that are not there, each in a process of its own.
fn make_missing(
    config: &BenchConfig,
    options: &BenchOptions,
    store: &Path,
    program: &Path,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<Vec<MadeScene>, RunError> {
    let specs = distinct_scenes(config);
    // Before hours of making: the last scene's mistake is told now.
    for spec in &specs {
        plan(spec)?;
    }
    progress.start("make", specs.len() as u64, 0);
    let mut made = Vec::new();
    for spec in specs {
        if find(store, spec)?.is_none() {
            let mut command = Command::new(program);
            command.arg("bench").arg(&options.config).arg("--out").arg(&options.out);
            command.args(["--make", &spec.folder_name(), "--quiet"]);
            make_in_child(&mut command, &options.out, interrupt)?;
        }
        let missing = || failed_at(store, &format!("{} was not made", spec.folder_name()));
        made.push(find(store, spec)?.ok_or_else(missing)?);
        progress.advance(0);
    }
    Ok(made)
}

fn make_in_child(command: &mut Command, out: &Path, interrupt: &Interrupt) -> Result<(), RunError> {
    let said = tempfile::NamedTempFile::new_in(out).map_err(|e| failed_at(out, &e))?;
    command.stdin(Stdio::null()).stdout(Stdio::null());
    command.stderr(said.reopen().map_err(|e| failed_at(out, &e))?);
    let exit = match measure(command, f64::INFINITY, &interrupt.stop_flag())?.end {
        End::Exit(Some(0)) => return Ok(()),
        End::Stopped => return Err(stopped(interrupt)),
        End::Exit(Some(code)) if code == i32::from(ExitCode::InputOutput.code()) => ExitCode::InputOutput,
        End::Exit(_) | End::TimeLimit => ExitCode::Failed,
    };
    let words = std::fs::read_to_string(said.path()).unwrap_or_default();
    Err(RunError { exit, message: words.trim().trim_start_matches("lacuna: ").to_owned() })
}

/// The error for a user who asked to stop.
fn stopped(interrupt: &Interrupt) -> RunError {
    let exit = if interrupt.is_terminate() { ExitCode::Terminated } else { ExitCode::Interrupted };
    let message = "stopped; the scenes that were made are used again by the same command".to_owned();
    RunError { exit, message }
}

fn measure_all(
    config: &BenchConfig,
    scenes: &[MadeScene],
    options: &BenchOptions,
    program: &Path,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<Vec<Row>, RunError> {
    let runs: usize = config.series.iter().map(|s| s.scenes.len() * run_count(s)).sum();
    progress.start("bench", runs as u64, 0);
    let pairs = config.series.iter().flat_map(|series| series.scenes.iter().map(move |spec| (series, spec)));
    let mut rows = Vec::new();
    for (series, spec) in pairs {
        let Some(made) = scenes.iter().find(|m| m.spec == *spec) else { continue };
        let tiles = tiles_folder(&options.out.join("scenes"), spec);
        let ground = Ground { program, tiles: &tiles, out: &options.out, made };
        let found = run_rounds(series, &ground, &interrupt.stop_flag(), progress)?;
        rows.extend(found.ok_or_else(|| stopped(interrupt))?);
    }
    Ok(rows)
}

/// Memory over time of a row.
#[derive(Serialize)]
struct RowSamples<'a> {
    series: &'a str,
    scene: &'a str,
    method: &'a str,
    threads: usize,
    samples: &'a [Sample],
}

/// Writes everything and returns the tables.
fn write_all(result: &BenchResult, out: &Path) -> Result<String, RunError> {
    let samples: Vec<RowSamples<'_>> = result
        .rows
        .iter()
        .map(|r| RowSamples {
            series: &r.series,
            scene: &r.scene,
            method: &r.method,
            threads: r.threads,
            samples: &r.samples,
        })
        .collect();
    let json = |value: serde_json::Result<String>| value.map_err(|e| RunError::failed(e.to_string()));
    let tables = markdown(result);
    let mut files = vec![
        ("bench.json".to_owned(), json(serde_json::to_string_pretty(result))? + "\n"),
        ("samples.json".to_owned(), json(serde_json::to_string(&samples))? + "\n"),
        ("bench.md".to_owned(), tables.clone()),
    ];
    files.extend(pictures(result));
    for (name, text) in files {
        let path = out.join(name);
        std::fs::write(&path, text).map_err(|e| failed_at(&path, &e))?;
    }
    Ok(tables)
}
