//! Repairs in processes of their own, so that each has its own peak of memory.

use anyhow::{Context, Result, ensure};
use clap::Parser;
use lacuna::cli::Cli;
use lacuna::config::{MethodName, Settings};
use lacuna::progress::Progress;
use lacuna::{ExitCode, Interrupt, RunError};
use serde::Serialize;
use std::path::Path;
use std::process::Command;

/// The methods, in the order of the tables.
pub const METHODS: [MethodName; 3] = [MethodName::Field, MethodName::Layered, MethodName::Aggregate];

/// The hidden verb with which the tool starts itself.
pub const VERB: &str = "repair-one";

/// Time and memory of a run, all stages counted in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    /// Wall-clock time, seconds.
    pub seconds: f64,
    /// Highest resident memory, MiB.
    pub peak_mib: f64,
}

/// Repairs `scene` into `out` in a new process of this program.
///
/// # Errors
/// The sentence with which the run ended, if it wrote nothing.
pub fn repair(method: MethodName, scene: &Path, out: &Path, area: &str) -> Result<Cost> {
    let program = std::env::current_exe().context("the path of this program")?;
    let run = Command::new(program).arg(VERB).arg(method.word()).args([scene, out]).arg(area).output()?;
    let code = run.status.code().unwrap_or(-1);
    let said = String::from_utf8_lossy(&run.stderr);
    ensure!(code == 0 || code == 3, "exit {code}: {}", said.trim().lines().last().unwrap_or_default());
    cost(&out.join("lacuna/report.json"))
}

fn cost(report: &Path) -> Result<Cost> {
    let text = std::fs::read_to_string(report).with_context(|| report.display().to_string())?;
    let report: serde_json::Value = serde_json::from_str(&text)?;
    let stages = report["stages"].as_array().map_or(&[][..], Vec::as_slice);
    Ok(Cost {
        seconds: stages.iter().filter_map(|s| s["seconds"].as_f64()).sum(),
        peak_mib: report["peak_rss_bytes"].as_f64().unwrap_or(0.0) / f64::from(1 << 20),
    })
}

/// What the hidden verb does: `METHOD SCENE OUT AREA`, as `lacuna repair` would.
#[must_use]
pub fn repair_here(arguments: &[String]) -> (ExitCode, Option<String>) {
    let [method, scene, out, area] = arguments else {
        return (ExitCode::Usage, Some(format!("{VERB} takes METHOD SCENE OUT AREA")));
    };
    let line = ["lacuna", "repair", scene, out, "--method", method, "--area", area];
    let run = || -> Result<ExitCode, RunError> {
        let usage = |message: String| RunError { exit: ExitCode::Usage, message };
        let cli = Cli::try_parse_from(line).map_err(|e| usage(e.to_string()))?;
        let settings = Settings::resolve(&cli).map_err(|e| usage(e.to_string()))?;
        let interrupt = Interrupt::on_signals().map_err(|e| usage(e.to_string()))?;
        Ok(lacuna::repair(&settings, &interrupt, &Progress::silent())?.exit)
    };
    match run() {
        Ok(exit) => (exit, None),
        Err(error) => (error.exit, Some(error.message)),
    }
}
