//! The result on the terminal: 80 columns.

use super::attention::{Attention, attention};
use super::kind::HoleKind;
use super::model::Report;
use super::numbers;
use super::summary::KindCount;
use crate::logging::shown;
use std::fmt::Write;

/// Width of the table.
const COLUMNS: usize = 80;

/// The paper's table (kinds of holes that were found; words first, letter second), what to look at first, and how the
/// run went. `report_place` is where the report lies; empty if it was not written.
#[must_use]
pub fn table(report: &Report, report_place: &str) -> String {
    let mut text = String::new();
    counts(&mut text, report);
    first_looks(&mut text, &attention(report));
    closing(&mut text, report, report_place);
    text
}

fn counts(text: &mut String, report: &Report) {
    if report.summary.found == 0 {
        text.push_str("No holes found.\n");
        return;
    }
    line(text, &heading());
    line(text, &"-".repeat(COLUMNS));
    let mut group = "";
    for kind in HoleKind::ALL {
        let row = report.summary.by_type.get(kind);
        if row.found == 0 {
            continue;
        }
        let its_group = group_of(kind);
        if its_group != group {
            line(text, its_group);
            group = its_group;
        }
        let indent = if its_group.is_empty() { "" } else { "  " };
        line(text, &cells(&format!("{indent}{}", kind.words()), row));
    }
    line(text, &"-".repeat(COLUMNS));
    line(text, &cells("all", &total(report)));
}

fn group_of(kind: HoleKind) -> &'static str {
    match kind {
        HoleKind::Closed => "",
        HoleKind::Internal(_) => "open",
        HoleKind::External(_) => "open, at the edge of the area",
    }
}

fn total(report: &Report) -> KindCount {
    let summary = &report.summary;
    KindCount {
        found: summary.found,
        filled: summary.filled,
        skipped: summary.skipped,
        failed: summary.failed,
        area_m2: summary.by_type.0.iter().map(|row| row.area_m2).sum(),
    }
}

fn heading() -> String {
    format!("{:<30}{:>9}{:>9}{:>9}{:>9}{:>14}", "hole", "found", "filled", "skipped", "failed", "area m2")
}

fn cells(name: &str, row: &KindCount) -> String {
    let number = |n: u64| if n == 0 { "-".to_owned() } else { numbers::grouped(n) };
    format!(
        "{name:<30}{:>9}{:>9}{:>9}{:>9}{:>14}",
        number(row.found),
        number(row.filled),
        number(row.skipped),
        number(row.failed),
        numbers::area(row.area_m2)
    )
}

fn first_looks(text: &mut String, list: &[Attention]) {
    if list.is_empty() {
        return;
    }
    text.push_str("\nLook first at\n");
    for one in list {
        let id = one.id.as_ref().map_or_else(String::new, |id| format!("{id}: "));
        wrapped(text, &format!("  {:<9}", one.topic), &format!("{id}{}", one.text));
    }
}

fn closing(text: &mut String, report: &Report, report_place: &str) {
    let changed = numbers::grouped(report.changed_tiles.len() as u64);
    let tiles = numbers::count(report.scene.cells, "tile", "tiles");
    let time = numbers::seconds(report.stages.iter().map(|stage| stage.seconds).sum());
    let peak = numbers::bytes(report.peak_rss_bytes);
    let limit = numbers::bytes(report.memory_limit_bytes);
    text.push('\n');
    line(text, &format!("Changed {changed} of {tiles} in {time}; peak memory {peak} of {limit}."));
    if !report_place.is_empty() {
        wrapped(text, "Report: ", report_place);
    }
}

fn line(text: &mut String, content: &str) {
    let _ = writeln!(text, "{}", content.trim_end());
}

/// A paragraph whose lines after the first are indented under its head. Words longer than a line stand alone, whole.
fn wrapped(text: &mut String, head: &str, body: &str) {
    let indent = " ".repeat(head.chars().count());
    let mut current = head.to_owned();
    let mut is_empty = true;
    for word in shown(body).split(' ') {
        if !is_empty && current.chars().count() + 1 + word.chars().count() > COLUMNS {
            line(text, &current);
            current = indent.clone();
            is_empty = true;
        }
        if !is_empty {
            current.push(' ');
        }
        current.push_str(word);
        is_empty = false;
    }
    line(text, &current);
}
