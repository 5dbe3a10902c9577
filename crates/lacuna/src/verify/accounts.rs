//! Promises 6, 7 and 8 as far as the report and the marks in the tiles tell: memory, sums, reasons, whole clusters.

use super::originals::Mark;
use super::verdict::Findings;
use crate::report::{HoleRecord, Outcome, Report, Summary};
use std::collections::{BTreeMap, BTreeSet};

/// Allowed above the memory limit.
const SLACK_BYTES: u64 = 64 << 20;

/// Promise 6: the peak that the run measured stays under its limit.
pub(super) fn check_memory(report: &Report) -> Findings {
    let mut findings = Findings::default();
    findings.count("MiB limit", report.memory_limit_bytes >> 20);
    findings.count("MiB peak", report.peak_rss_bytes >> 20);
    if report.peak_rss_bytes > report.memory_limit_bytes.saturating_add(SLACK_BYTES) {
        findings.offend(format!(
            "the run took {} MiB, its limit was {} MiB + 64",
            report.peak_rss_bytes >> 20,
            report.memory_limit_bytes >> 20
        ));
    }
    findings
}

/// Promise 7: the report accounts for every hole.
pub(super) fn check_sums(report: &Report) -> Findings {
    let mut findings = Findings::default();
    findings.count("holes", report.holes.len() as u64);
    let summary = &report.summary;
    if summary.found != summary.filled + summary.skipped + summary.failed {
        findings.offend(format!(
            "report: {} found, but {} filled + {} skipped + {} failed",
            summary.found, summary.filled, summary.skipped, summary.failed
        ));
    }
    let counted = Summary::from_holes(&report.holes);
    let numbers = |s: &Summary| [s.found, s.filled, s.skipped, s.failed];
    if numbers(&counted) != numbers(summary) {
        findings.offend("report: the sums are not those of its holes");
    }
    let rows = |s: &Summary| s.by_type.0.map(|row| [row.found, row.filled, row.skipped, row.failed]);
    if rows(&counted) != rows(summary) {
        findings.offend("report: the sums by type are not those of its holes");
    }
    for hole in &report.holes {
        if hole.outcome != Outcome::Filled && hole.reason.as_ref().is_none_or(|r| r.trim().is_empty()) {
            findings.offend(format!("{}: {} without a reason", hole.id, hole.outcome.word()));
        }
    }
    findings
}

/// Promise 8 in the report: a cluster's holes have its outcome, and each hole's cluster is there.
pub(super) fn check_clusters(report: &Report) -> Findings {
    let mut findings = Findings::default();
    findings.count("clusters", report.clusters.len() as u64);
    let clusters: BTreeMap<&str, Outcome> =
        report.clusters.iter().map(|c| (c.id.as_str(), c.outcome)).collect();
    for hole in &report.holes {
        match clusters.get(hole.cluster.as_str()) {
            None => findings.offend(format!("{}: the report has no cluster {}", hole.id, hole.cluster)),
            Some(outcome) if *outcome != hole.outcome => findings.offend(format!(
                "{}: {}, but its cluster is {}",
                hole.id,
                hole.outcome.word(),
                outcome.word()
            )),
            Some(_) => {}
        }
    }
    findings
}

/// Promise 8 in one tile: each filled hole has its patch there, and each patch belongs to a filled hole. `holes` are the
/// report's holes of this tile, `patch_triangles` what its files hold beside the delivered triangles.
pub(super) fn check_marks(
    tile: &str,
    holes: &[&HoleRecord],
    marks: &[Mark],
    patch_triangles: u64,
) -> Findings {
    let mut findings = Findings::default();
    let mut marked: BTreeMap<&str, u64> = BTreeMap::new();
    marks.iter().for_each(|m| *marked.entry(m.hole.as_str()).or_default() += m.triangles);
    let filled: Vec<&&HoleRecord> = holes.iter().filter(|h| h.outcome == Outcome::Filled).collect();
    findings.count("patches marked", marked.len() as u64);
    for hole in &filled {
        match marked.get(hole.id.as_str()) {
            None => {
                findings.offend(format!("{tile}: no patch of {}, which the report calls filled", hole.id))
            }
            Some(count) if *count != hole.patch_triangles => findings.offend(format!(
                "{tile} ({}): {count} triangles are marked, the report has {}",
                hole.id, hole.patch_triangles
            )),
            Some(_) => {}
        }
    }
    let known: BTreeSet<&str> = filled.iter().map(|h| h.id.as_str()).collect();
    for hole in marked.keys().filter(|hole| !known.contains(**hole)) {
        findings.offend(format!("{tile}: a patch of {hole}, which the report does not call filled here"));
    }
    let sum: u64 = marked.values().sum();
    if sum != patch_triangles {
        findings.offend(format!("{tile}: {patch_triangles} new triangles, but the marks count {sum}"));
    }
    findings
}
