//! What the page draws and `holes.geojson` outlines: shapes, not numbers.

use super::hillshade::HeightRaster;
use super::kind::{HoleClass, HoleShape};
use super::model::Outcome;

/// Shapes of a run, in scene coordinates, metres.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    /// Cells that have a tile, and missing cells that belong to the area.
    pub cells: Vec<CellDrawing>,
    /// One for each hole of the report; joined by `id`.
    pub holes: Vec<HoleDrawing>,
    /// One for each cluster of more than one hole.
    pub clusters: Vec<ClusterDrawing>,
    /// Highest surface before the repair.
    pub before: Option<HeightRaster>,
    /// Highest surface after it, on the same pixels.
    pub after: Option<HeightRaster>,
}

/// What became of a cell's tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CellStatus {
    /// The tile needs no patch: its bytes stay.
    Untouched,
    /// The tile got a patch.
    Repaired,
    /// The tile could not be read or written.
    Failed,
    /// The cell has no tile.
    Missing,
}

impl CellStatus {
    /// The word that stands in `cells.geojson`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Untouched => "untouched",
            Self::Repaired => "repaired",
            Self::Failed => "failed",
            Self::Missing => "missing",
        }
    }
}

/// One cell.
#[derive(Clone, Debug)]
pub struct CellDrawing {
    /// Column and row.
    pub index: [i32; 2],
    /// West, south, east, north.
    pub rect: [f64; 4],
    /// Name of its tile; empty if it has none.
    pub tile: String,
    /// What became of it.
    pub status: CellStatus,
}

/// One hole.
#[derive(Clone, Debug)]
pub struct HoleDrawing {
    /// The hole's id in the report.
    pub id: String,
    /// Closed, I, II.
    pub class: HoleClass,
    /// Shape of an open hole.
    pub shape: Option<HoleShape>,
    /// From 1.
    pub layer: u32,
    /// Outline in plan, without a repeated last point: the outer ring counter-clockwise, then islands clockwise.
    pub rings: Vec<Vec<[f64; 2]>>,
    /// Outlines of the islands that the patch passes beneath.
    pub passed_under: Vec<Vec<[f64; 2]>>,
    /// What became of it.
    pub outcome: Outcome,
}

/// Outline of a cluster.
#[derive(Clone, Debug)]
pub struct ClusterDrawing {
    /// The cluster's id in the report.
    pub id: String,
    /// Rings in plan, without a repeated last point.
    pub rings: Vec<Vec<[f64; 2]>>,
}
