//! The records of `report.json`, version 1: product.md fixes keys and their order; what stands besides is ours.
//!
//! Coordinates are scene coordinates (as in the files) unless a field says SRS. Lengths are metres, areas square
//! metres in plan, memory bytes, times seconds.

use super::kind::{HoleClass, HoleKind, HoleShape};
use super::round::{micro, micro_option, milli, milli_option, place};
use super::summary::Summary;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Version of the layout of `report.json`.
pub const REPORT_VERSION: u32 = 1;

/// What became of a hole or a cluster.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// The patch is in the tile.
    Filled,
    /// Left as it was, on purpose; the record gives the reason.
    Skipped,
    /// Should have been filled and could not be; the record gives the cause.
    Failed,
}

impl Outcome {
    /// The word that stands in the report.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Filled => "filled",
            Self::Skipped => "skipped",
            Self::Failed => "failed",
        }
    }
}

/// The whole report of one run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`REPORT_VERSION`].
    pub version: u32,
    /// Version of lacuna. A run fact: it is left out of the digest, as are the next-named four.
    pub lacuna: String,
    /// `field`, `layered` or `aggregate`.
    pub method: String,
    /// Worker threads (run fact).
    pub threads: usize,
    /// The memory limit in force (run fact).
    pub memory_limit_bytes: u64,
    /// Highest resident memory of the process (run fact).
    pub peak_rss_bytes: u64,
    /// What was read.
    pub scene: SceneRecord,
    /// Times and memory by stage, in running order (run fact).
    pub stages: Vec<StageRecord>,
    /// One record a cluster, in the plan's order.
    pub clusters: Vec<ClusterRecord>,
    /// One record a hole (one a cell), in the plan's order.
    pub holes: Vec<HoleRecord>,
    /// Counts over `holes`; made by [`Summary::from_holes`] alone.
    pub summary: Summary,
    /// What the check of the seams measured.
    pub seams: SeamRecord,
    /// The resolved settings that shape the output: no limit, thread count, path or time stands here.
    #[serde(default)]
    pub configuration: serde_json::Value,
    /// Loops that were looked at and are no holes (passages, courtyards, cuts ...), counted by kind.
    #[serde(default)]
    pub not_holes: BTreeMap<String, u64>,
    /// What is wrong with input tiles and was worked round or left out.
    #[serde(default)]
    pub defects: Vec<DefectRecord>,
    /// What the reader should know about the run as a whole.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Names of tiles that carry a patch, sorted.
    #[serde(default)]
    pub changed_tiles: Vec<String>,
    /// Paths, times and the rest of the run facts, left out of the digest.
    #[serde(default)]
    pub execution: Execution,
}

/// The scene as it was understood.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneRecord {
    /// Cells that have a tile.
    pub cells: u64,
    /// Triangles of all tiles.
    pub triangles: u64,
    /// Bytes of all mesh files.
    pub bytes: u64,
    /// Side of a cell.
    #[serde(with = "milli")]
    pub cell_size_m: f64,
    /// South-west corner of cell (0, 0).
    #[serde(with = "place")]
    pub origin_m: [f64; 2],
    /// `exact`, `overrun`, `ragged` or `overlap`.
    pub border_mode: String,
    /// How far tiles reach over their cell (overrun mode).
    #[serde(default, with = "milli_option")]
    pub overrun_m: Option<f64>,
    /// `PLY`, `OBJ`, `GLB`.
    #[serde(default)]
    pub format: String,
    /// Spatial reference system, as the scene or the settings name it, for example `EPSG:28992`.
    #[serde(default)]
    pub srs: Option<String>,
    /// What is added to scene coordinates to get SRS coordinates.
    #[serde(default)]
    pub srs_origin: Option<[f64; 3]>,
}

/// Time and memory of one stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageRecord {
    /// `scan`, `plan`, `close`, `fill`, `seams`, `write`, `report`.
    pub name: String,
    /// Wall-clock time.
    #[serde(with = "milli")]
    pub seconds: f64,
    /// Processor time of all threads.
    #[serde(with = "milli")]
    pub cpu_seconds: f64,
    /// Highest resident memory of the process up to the end of the stage.
    pub peak_rss_bytes: u64,
}

/// One cluster: the lake as a person sees it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClusterRecord {
    /// Rounded SRS metres of a point inside.
    pub id: String,
    /// A point inside, SRS coordinates where the scene has an SRS.
    #[serde(with = "milli")]
    pub x: f64,
    /// See `x`.
    #[serde(with = "milli")]
    pub y: f64,
    /// Names of the tiles it touches.
    pub tiles: Vec<String>,
    /// Sum over its holes.
    #[serde(with = "micro")]
    pub area_m2: f64,
    /// Highest layer of its holes.
    pub layers: u32,
    /// Level of the water at (x, y), where one was used; SRS height where the scene has an SRS.
    #[serde(with = "milli_option")]
    pub level_m: Option<f64>,
    /// Share of the rim's length that lies within 0.15 m of it.
    #[serde(with = "micro_option", default)]
    pub level_support: Option<f64>,
    /// How far the rim lies from the level where it lies near it: root mean square.
    #[serde(with = "milli_option", default)]
    pub level_residual_m: Option<f64>,
    /// Filled in all tiles or in none.
    pub outcome: Outcome,
    /// Why it was skipped or failed.
    pub reason: Option<String>,
}

/// One hole: what a cluster leaves open in one cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HoleRecord {
    /// Cluster and tile, unique.
    pub id: String,
    /// Its cluster.
    pub cluster: String,
    /// Name of its tile.
    pub tile: String,
    /// Column and row.
    pub cell: [i32; 2],
    /// Closed, I or II.
    pub class: HoleClass,
    /// Shape of an open hole, `null` for a closed one.
    pub shape: Option<HoleShape>,
    /// Distance from the cluster's outside, from 1.
    pub layer: u32,
    /// Area in plan.
    #[serde(with = "micro")]
    pub area_m2: f64,
    /// Length of rim and closing lines in plan.
    #[serde(with = "milli")]
    pub perimeter_m: f64,
    /// Vertices of the rim.
    pub rim_vertices: u64,
    /// Islands in it that the patch passes beneath: they keep an open rim.
    #[serde(default)]
    pub islands_passed_under: u64,
    /// What became of it.
    pub outcome: Outcome,
    /// Why it was skipped or failed.
    pub reason: Option<String>,
    /// Where its surface comes from.
    pub method: Option<String>,
    /// How the contour became triangles.
    pub filler: Option<String>,
    /// New positions in the tile.
    pub patch_vertices: u64,
    /// New triangles in the tile.
    pub patch_triangles: u64,
    /// Mean of 2r/R over the patch's triangles in space: 1 is equilateral.
    #[serde(with = "micro_option")]
    pub quality_mean: Option<f64>,
    /// Share of the patch's triangles above 0.5.
    #[serde(with = "micro_option")]
    pub quality_share_good: Option<f64>,
}

impl HoleRecord {
    /// The row of the summary that the hole counts in. An open hole without a shape counts as crossing (the most
    /// general shape), so that the sum over the rows stays the number of holes.
    #[must_use]
    pub fn kind(&self) -> HoleKind {
        HoleKind::of(self.class, self.shape)
    }
}

/// What the check of the borders measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SeamRecord {
    /// Shared borders that a patch ends on.
    pub borders: u64,
    /// Border vertices that both sides have, bit for bit.
    pub shared_vertices: u64,
    /// Border vertices that one side lacks.
    pub differing_vertices: u64,
    /// Widest gap between the surfaces of two sides.
    #[serde(with = "micro")]
    pub max_gap_m: f64,
}

/// Something wrong with an input tile.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct DefectRecord {
    /// The tile's name.
    pub tile: String,
    /// What is wrong, and what was done about it.
    pub what: String,
    /// True if the tile could not be used at all.
    pub unusable: bool,
}

/// Facts of the run that differ between two equal runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Execution {
    /// Verb, scene and output as given.
    #[serde(default)]
    pub command: Vec<String>,
    /// The scene's folder.
    #[serde(default)]
    pub scene: String,
    /// The output's folder.
    #[serde(default)]
    pub output: String,
    /// Wall-clock time of the run.
    #[serde(default, with = "milli")]
    pub seconds: f64,
    /// Clusters that an earlier run had finished and this one kept.
    #[serde(default)]
    pub kept_clusters: u64,
    /// Settings that change how a run goes, not what comes out.
    #[serde(default)]
    pub settings: serde_json::Value,
}

impl Report {
    /// The text of `report.json`: indented by two spaces, with a line feed at the end.
    ///
    /// # Errors
    /// Never for records made by lacuna; the error is the serialiser's.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }

    /// Reads a report back; keys it does not know are passed over.
    ///
    /// # Errors
    /// Text that is no JSON, or lacks one of the fixed keys.
    pub fn from_json(text: &str) -> Result<Self, serde_json::Error> {
        serde_json::from_str(text)
    }
}
