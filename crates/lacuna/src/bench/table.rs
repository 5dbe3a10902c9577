//! The result as tables in Markdown.

use super::result::{BenchResult, Row, RowOutcome};
use super::scene_store::MadeScene;
use crate::report::HoleKind;
use std::fmt::Write;

/// One section a series: time and memory of every row, then holes filled by kind, then what went wrong.
#[must_use]
pub fn markdown(result: &BenchResult) -> String {
    let gibibytes = result.machine.memory_bytes as f64 / f64::from(1 << 30);
    let mut text = format!(
        "lacuna {}, {} threads, {gibibytes:.1} GiB. Medians over the rounds; peak: the highest of all. \
         x copy: time over that of a copy in the same round.\n",
        result.lacuna, result.machine.threads
    );
    for series in result.series() {
        let rows: Vec<&Row> = result.rows.iter().filter(|r| r.series == series).collect();
        let _ = writeln!(text, "\n## {series}\n");
        costs(&mut text, result, &rows);
        successes(&mut text, result, &rows);
        complaints(&mut text, &rows);
    }
    text
}

fn costs(text: &mut String, result: &BenchResult, rows: &[&Row]) {
    text.push_str(
        "| km2 | cells | million triangles | method | threads | seconds (least to most) | CPU s | peak MiB | limit MiB \
         | read MiB | written MiB | cells/s | x copy |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- \
         | --- | --- |\n",
    );
    for row in rows {
        let Some(scene) = result.scene_of(row) else { continue };
        let cells = [
            plain(scene.area_km2, 2),
            scene.cells.to_string(),
            plain(scene.triangles as f64 * 1e-6, 2),
            row.method.clone(),
            row.threads.to_string(),
            time(row),
            or_dash(row.cpu_s, 2),
            mebibytes(row.peak_rss_bytes),
            mebibytes(row.memory_limit_bytes),
            mebibytes(row.read_bytes),
            mebibytes(row.written_bytes),
            or_dash(row.cells_per_s, 2),
            or_dash(row.ratio_to_copy.map(|d| d.median), 2),
        ];
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
}

/// Seconds, or how the run ended.
fn time(row: &Row) -> String {
    let Some(wall) = row.wall_s else { return "-".to_owned() };
    match row.outcome {
        RowOutcome::Done if row.runs > 1 => {
            format!("{:.2} ({:.2} to {:.2})", wall.median, wall.least, wall.most)
        }
        RowOutcome::Done => format!("{:.2}", wall.median),
        other => format!("{} after {:.2}", other.words(), wall.most),
    }
}

/// Filled of the holes that the tiles show, by kind, once a method: what is filled does not depend on the threads.
/// Nothing for series without repairs.
fn successes(text: &mut String, result: &BenchResult, rows: &[&Row]) {
    let mut repairs: Vec<&Row> = Vec::new();
    for row in rows.iter().filter(|r| r.memory_limit_bytes.is_some()) {
        if !repairs.iter().any(|r| r.scene == row.scene && r.method == row.method) {
            repairs.push(row);
        }
    }
    let kinds: Vec<&str> = HoleKind::ALL
        .iter()
        .map(|k| k.key())
        .filter(|key| repairs.iter().any(|r| result.scene_of(r).is_some_and(|s| s.holes.contains_key(*key))))
        .collect();
    if kinds.is_empty() {
        return;
    }
    let _ = writeln!(text, "\nFilled, of the holes that the tiles show (one a cell):\n");
    let _ = writeln!(text, "| km2 | method | {} | all |", kinds.join(" | "));
    let _ = writeln!(text, "| {}--- |", "--- | ".repeat(kinds.len() + 2));
    for row in repairs {
        let Some(scene) = result.scene_of(row) else { continue };
        let mut cells = vec![plain(scene.area_km2, 2), row.method.clone()];
        cells.extend(kinds.iter().map(|kind| share(row, scene, &[kind])));
        cells.push(share(row, scene, &kinds));
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
}

/// `filled of shown (percent)` over some kinds, and how many were left on purpose.
fn share(row: &Row, scene: &MadeScene, kinds: &[&str]) -> String {
    let shown: u64 = kinds.iter().filter_map(|k| scene.holes.get(*k)).sum();
    if row.outcome != RowOutcome::Done || shown == 0 {
        return "-".to_owned();
    }
    let counts = || kinds.iter().filter_map(|k| row.holes.get(*k));
    let (filled, left) = (counts().map(|c| c.filled).sum::<u64>(), counts().map(|c| c.skipped).sum::<u64>());
    let on_purpose = if left > 0 { format!(", {left} left on purpose") } else { String::new() };
    format!("{filled} of {shown} ({:.0} %){on_purpose}", 100.0 * filled as f64 / shown as f64)
}

fn complaints(text: &mut String, rows: &[&Row]) {
    let said = rows.iter().filter_map(|r| Some((r, r.message.as_ref()?)));
    for (k, (row, message)) in said.enumerate() {
        let blank = if k == 0 { "\n" } else { "" };
        let _ = writeln!(text, "{blank}* {}, {}, {} threads: {message}", row.scene, row.method, row.threads);
    }
}

fn plain(value: f64, digits: usize) -> String {
    format!("{value:.digits$}")
}

fn or_dash(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |v| plain(v, digits))
}

fn mebibytes(bytes: Option<u64>) -> String {
    or_dash(bytes.map(|b| b as f64 / f64::from(1 << 20)), 0)
}
