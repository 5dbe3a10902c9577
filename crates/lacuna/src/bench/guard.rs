//! Compares a bench with an earlier one: memory and time relative to a copy, never seconds, which are the machine's.

use super::result::{BenchResult, Row, RowOutcome};

/// What may be lost before it counts: a third.
const TOLERANCE: f64 = 4.0 / 3.0;

/// What got worse than in the baseline by more than a third, or no longer ends as it did; empty if nothing did. Rows that
/// the baseline does not have are not compared; a row that only the baseline has is said to be missing.
#[must_use]
pub fn worsened(now: &BenchResult, baseline: &BenchResult) -> Vec<String> {
    baseline.rows.iter().flat_map(|old| compare(now, old)).collect()
}

fn compare(now: &BenchResult, old: &Row) -> Vec<String> {
    let name = format!("{} {} {} -j {}", old.series, old.scene, old.method, old.threads);
    let is_same = |r: &&Row| {
        r.series == old.series && r.scene == old.scene && r.method == old.method && r.threads == old.threads
    };
    let Some(new) = now.rows.iter().find(is_same) else {
        return vec![format!("{name}: was not measured, the baseline has it")];
    };
    if old.outcome != RowOutcome::Done || old.memory_limit_bytes.is_none() {
        return Vec::new();
    }
    if new.outcome != RowOutcome::Done {
        return vec![format!("{name}: {}", new.outcome.words())];
    }
    let mebibytes = |row: &Row| row.peak_rss_bytes.map(|b| b as f64 / f64::from(1 << 20));
    let ratio = |row: &Row| row.ratio_to_copy.map(|d| d.median);
    let figures = [
        ("peak memory in MiB", mebibytes(old), mebibytes(new)),
        ("time over that of a copy", ratio(old), ratio(new)),
    ];
    let worse = |(what, old, new): (&str, Option<f64>, Option<f64>)| {
        let (old, new) = (old?, new?);
        (new > old * TOLERANCE)
            .then(|| format!("{name}: {what} is {new:.2}, more than a third above {old:.2}"))
    };
    figures.into_iter().filter_map(worse).collect()
}

#[cfg(test)]
mod tests {
    use super::worsened;
    use crate::bench::{BenchResult, Distribution, Row, RowOutcome};

    fn one(method: &str, mebibytes: u64, ratio: f64) -> BenchResult {
        let row = Row {
            series: "s".to_owned(),
            scene: "t".to_owned(),
            method: method.to_owned(),
            threads: 2,
            memory_limit_bytes: (method != "copy").then_some(1 << 30),
            outcome: RowOutcome::Done,
            message: None,
            runs: 3,
            wall_s: None,
            cpu_s: None,
            peak_rss_bytes: Some(mebibytes << 20),
            read_bytes: None,
            written_bytes: None,
            cells_per_s: None,
            ratio_to_copy: Distribution::of(&[ratio]),
            holes: Default::default(),
            samples: Vec::new(),
        };
        BenchResult { rows: vec![row], ..BenchResult::default() }
    }

    #[test]
    fn a_third_is_the_limit() {
        let old = one("field", 90, 3.0);
        for (mebibytes, ratio, expected) in
            [(90, 3.0, 0), (120, 4.0, 0), (121, 4.0, 1), (120, 4.01, 1), (200, 9.0, 2), (1, 0.1, 0)]
        {
            let found = worsened(&one("field", mebibytes, ratio), &old);
            assert_eq!(found.len(), expected, "{mebibytes} MiB, {ratio}: {found:?}");
        }
    }

    #[test]
    fn copies_are_not_judged_and_missing_rows_are_named() {
        assert!(worsened(&one("copy", 900, 30.0), &one("copy", 90, 3.0)).is_empty());
        assert!(worsened(&one("layered", 9, 3.0), &one("field", 90, 3.0))[0].contains("was not measured"));
        let mut stopped = one("field", 90, 3.0);
        stopped.rows[0].outcome = RowOutcome::TimeLimit;
        assert!(worsened(&stopped, &one("field", 90, 3.0))[0].contains("time limit"));
        assert!(worsened(&one("field", 900, 30.0), &stopped).is_empty(), "nothing to compare with");
    }
}
