//! What was measured: one row a scene, method and number of threads, medians over the rounds.

use super::scene_store::MadeScene;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Version of the layout of `bench.json`.
pub(super) const RESULT_VERSION: u32 = 1;

/// Everything that one bench measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BenchResult {
    /// Version of the layout.
    pub version: u32,
    /// Version of lacuna.
    pub lacuna: String,
    /// Where it ran.
    pub machine: MachineFacts,
    /// The scenes, each once.
    pub scenes: Vec<MadeScene>,
    /// In the order of the configuration.
    pub rows: Vec<Row>,
}

/// What the machine gives a process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MachineFacts {
    /// Processors.
    pub threads: usize,
    /// Memory of the machine or its control group, bytes.
    pub memory_bytes: u64,
}

/// How the runs of a row ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RowOutcome {
    /// As they should.
    Done,
    /// The memory limit is too small for the method (exit code 5).
    MemoryLimit,
    /// Stopped at the bench's time limit.
    TimeLimit,
    /// Another error.
    Failed,
}

impl RowOutcome {
    /// Words for the tables.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::MemoryLimit => "needs more than the memory limit",
            Self::TimeLimit => "stopped at the time limit",
            Self::Failed => "failed",
        }
    }
}

/// Least, middle and largest value over the rounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distribution {
    /// Least.
    pub least: f64,
    /// Median: the mean of the two in the middle if the number is even.
    pub median: f64,
    /// Largest.
    pub most: f64,
}

impl Distribution {
    /// Of some values; `None` of none.
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (least, most) = (*sorted.first()?, *sorted.last()?);
        let median = f64::midpoint(sorted[(sorted.len() - 1) / 2], sorted[sorted.len() / 2]);
        Some(Self { least, median, most })
    }
}

/// Holes of one kind, one a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HoleCount {
    /// Found by the run.
    pub found: u64,
    /// Of these, filled.
    pub filled: u64,
    /// Of these, left alone on purpose, as holes at the edge of the area are.
    pub skipped: u64,
}

/// A method, or `copy` or `read`, on a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The series.
    pub series: String,
    /// The scene's name.
    pub scene: String,
    /// `field`, `layered`, `aggregate`, `copy` or `read`.
    pub method: String,
    /// Worker threads; 1 for `copy` and `read`.
    pub threads: usize,
    /// `--memory`, bytes; `None` for `copy` and `read`.
    pub memory_limit_bytes: Option<u64>,
    /// How the runs ended.
    pub outcome: RowOutcome,
    /// What the program said, if they did not end as they should.
    pub message: Option<String>,
    /// Number of runs.
    pub runs: usize,
    /// Wall-clock time, seconds.
    pub wall_s: Option<Distribution>,
    /// Processor time of all threads, seconds; the median.
    pub cpu_s: Option<f64>,
    /// Highest resident memory of all runs, bytes.
    pub peak_rss_bytes: Option<u64>,
    /// Handed to the program by read calls, bytes; the median.
    pub read_bytes: Option<u64>,
    /// Taken from the program by write calls, bytes; the median.
    pub written_bytes: Option<u64>,
    /// Cells a second of wall-clock time.
    pub cells_per_s: Option<f64>,
    /// Wall-clock time over that of `copy` in the same round.
    pub ratio_to_copy: Option<Distribution>,
    /// Holes by kind (`closed`, `I-A` ...), of methods that finished.
    pub holes: BTreeMap<String, HoleCount>,
    /// Memory over time of the run in the first round; in `samples.json`, not in `bench.json`.
    #[serde(skip)]
    pub samples: Vec<Sample>,
}

/// Resident memory at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Since the start of the run, seconds.
    pub at_s: f64,
    /// Resident memory, bytes.
    pub rss_bytes: u64,
}

impl BenchResult {
    /// The scene of a row.
    #[must_use]
    pub fn scene_of(&self, row: &Row) -> Option<&MadeScene> {
        self.scenes.iter().find(|s| s.name == row.scene)
    }

    /// The series, in the order of the rows.
    #[must_use]
    pub fn series(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.rows.iter().map(|r| r.series.as_str()).collect();
        names.dedup();
        names
    }
}

#[cfg(test)]
mod tests {
    use super::Distribution;

    #[test]
    fn the_median_is_in_the_middle() {
        let of = |values: &[f64]| Distribution::of(values).map(|d| (d.least, d.median, d.most));
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[3.0]), Some((3.0, 3.0, 3.0)));
        assert_eq!(of(&[9.0, 1.0, 2.0]), Some((1.0, 2.0, 9.0)));
        assert_eq!(of(&[4.0, 1.0, 2.0, 9.0]), Some((1.0, 3.0, 9.0)));
    }
}
