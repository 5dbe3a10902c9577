//! The resolved configuration: defaults, then the file, then flags.

use super::polygon::PolygonFile;
use super::water::{WaterFile, WaterIslands, WaterMode};
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// What becomes of tiles that need no patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Untouched {
    /// The same bytes in OUT.
    #[default]
    Copy,
    /// The same bytes, shared with the input where the file system can.
    Reflink,
    /// Left out; `OUT/lacuna/changed.txt` lists the others.
    Omit,
}

/// Axis of the files that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum UpAxis {
    /// As glTF says.
    Y,
    /// As survey data have it.
    Z,
}

/// What to do with holes at the edge of the reconstruction area.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum External {
    /// Report them only.
    #[default]
    Skip,
    /// Fill them up to the area's edge.
    Fill,
}

/// What makes a finished run end with exit code 3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum FailOn {
    /// A tile that could not be read or written.
    Tiles,
    /// That, or a hole that could not be filled.
    #[default]
    Holes,
    /// Nothing.
    Never,
}

/// Where a patch's surface comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum MethodName {
    /// One height field a cluster.
    #[default]
    Field,
    /// Layer by layer from the outside in (the paper).
    Layered,
    /// The baseline: all cells merged in memory, closed holes filled there.
    Aggregate,
}

impl MethodName {
    /// The word in configurations and reports.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Field => "field",
            Self::Layered => "layered",
            Self::Aggregate => "aggregate",
        }
    }
}

/// Fillers of closed holes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
#[value(rename_all = "snake_case")]
pub enum ClosedFiller {
    /// Delaunay where the loop is valid in plan, else least area.
    #[default]
    Auto,
    /// Constrained Delaunay in plan.
    Delaunay,
    /// Triangulation of least area in space (the paper).
    MinArea,
}

/// Fillers of open holes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum OpenFiller {
    /// The best one for the hole.
    #[default]
    Auto,
    /// Constrained Delaunay in plan.
    Delaunay,
}

/// Classes that `find.class` and `--class` name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ValueEnum)]
pub enum HoleClassFilter {
    /// Closed holes.
    #[serde(rename = "closed")]
    #[value(name = "closed")]
    Closed,
    /// Open, internal.
    #[serde(rename = "I")]
    #[value(name = "I")]
    Internal,
    /// Open, external.
    #[serde(rename = "II")]
    #[value(name = "II")]
    External,
}

/// Shapes that `find.shape` and `--shape` name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ValueEnum)]
pub enum HoleShapeFilter {
    /// Hollow: a whole tile.
    #[value(name = "A")]
    A,
    /// Semi-enclosed: a bay.
    #[value(name = "B")]
    B,
    /// Crossing.
    #[value(name = "C")]
    C,
    /// Island.
    #[value(name = "D")]
    D,
}

/// How progress is shown on stderr.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum ProgressMode {
    /// Bars on a terminal, lines elsewhere.
    #[default]
    Auto,
    /// Bars.
    Bar,
    /// A line every 5 % or minute.
    Plain,
    /// Nothing.
    None,
}

/// Reconstruction area as asked for.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AreaLimit {
    /// Whole cells that have tiles, enclosed missing ones counted in.
    #[default]
    Cells,
    /// The bounding rectangle of all vertices.
    Box,
    /// Polygons of a GeoJSON file.
    Polygon(PolygonFile),
}

/// How to read the scene, and where to write.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneSettings {
    /// Folder of tiles.
    pub input: PathBuf,
    /// Folder to write; `None` for verbs that write no tiles.
    pub output: Option<PathBuf>,
    /// Tiles that need no patch.
    pub untouched: Untouched,
    /// Side of a cell; `None` = inferred.
    pub cell_size_m: Option<f64>,
    /// A corner of the grid, scene coordinates; `None` = inferred.
    pub cell_origin_m: Option<[f64; 2]>,
    /// `None` = what the format says.
    pub up_axis: Option<UpAxis>,
    /// Spatial reference system; `None` = what the scene says.
    pub srs: Option<String>,
    /// Added to file coordinates to get SRS coordinates; `None` = what the scene says.
    pub srs_origin: Option<[f64; 3]>,
}

/// The reconstruction area.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AreaSettings {
    /// How far it reaches.
    pub limit: AreaLimit,
    /// Holes at its edge.
    pub external: External,
}

/// How the run uses the machine, and how it ends.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunSettings {
    /// Limit in force.
    pub memory_limit_bytes: u64,
    /// Worker threads, at least 1.
    pub threads: usize,
    /// What makes exit code 3.
    pub fail_on: FailOn,
    /// Stop at the first bad tile.
    pub strict: bool,
    /// Tighter limits on counts and sizes.
    pub untrusted: bool,
    /// Delete what an earlier run wrote.
    pub overwrite: bool,
    /// Write nothing.
    pub dry_run: bool,
}

impl Default for RunSettings {
    fn default() -> Self {
        Self {
            memory_limit_bytes: 512 << 20,
            threads: 1,
            fail_on: FailOn::default(),
            strict: false,
            untrusted: false,
            overwrite: false,
            dry_run: false,
        }
    }
}

/// Filters; they look at whole clusters.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FindSettings {
    /// Smallest sum of areas.
    pub min_area_m2: Option<f64>,
    /// Largest sum of areas.
    pub max_area_m2: Option<f64>,
    /// Longest perimeter.
    pub max_perimeter_m: Option<f64>,
    /// Most rim edges.
    pub max_edges_around_hole: Option<u64>,
    /// Classes; empty = all. Sorted.
    pub class: Vec<HoleClassFilter>,
    /// Shapes; empty = all. Sorted. Closed holes have none.
    pub shape: Vec<HoleShapeFilter>,
}

/// Places that one solve of method `field` may have by default: half a gibibyte for a river, a little over
/// one for a wide lake.
const MAX_UNKNOWNS: usize = 400_000;

/// How holes are filled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FillSettings {
    /// Where the surface comes from.
    pub method: MethodName,
    /// Triangles of closed holes.
    pub closed: ClosedFiller,
    /// Triangles of open holes.
    pub open: OpenFiller,
    /// Triangle size; `None` = from the rim.
    pub spacing_m: Option<f64>,
    /// Whether the surface settles on a level (method `field`).
    pub water: WaterMode,
    /// Surface that hangs in water.
    pub islands: WaterIslands,
    /// Places that one solve may have (method `field`); larger clusters are solved on a coarser triangulation first, then
    /// block by block.
    pub max_unknowns: usize,
}

impl Default for FillSettings {
    fn default() -> Self {
        Self {
            method: MethodName::default(),
            closed: ClosedFiller::default(),
            open: OpenFiller::default(),
            spacing_m: None,
            water: WaterMode::default(),
            islands: WaterIslands::default(),
            max_unknowns: MAX_UNKNOWNS,
        }
    }
}

/// Where a region lies, in the frame of [`PolygonFile`] or scene coordinates.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RegionPlace {
    /// The cluster at this place.
    Point([f64; 2]),
    /// West, south, east, north.
    Box([f64; 4]),
    /// Inside these polygons.
    Polygon(PolygonFile),
}

/// Settings of a part of the scene; the later region wins where two overlap.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Region {
    /// Its name, unique.
    pub name: String,
    /// Where it lies.
    pub at: RegionPlace,
    /// Leave its clusters, for this reason.
    pub skip: Option<String>,
    /// Fill settings here: those of the scene, overridden.
    pub fill: FillSettings,
    /// What it says of water itself: that comes before the water polygons, they before the scene's mode.
    pub water: Option<WaterMode>,
}

/// Which clusters a run is limited to; all empty = the whole scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Selection {
    /// Names of regions.
    pub regions: Vec<String>,
    /// Names of tiles; `None` = all.
    pub cells: Option<BTreeSet<String>>,
    /// Places.
    pub at: Vec<[f64; 2]>,
    /// Ids of holes.
    pub holes: Vec<String>,
}

impl Selection {
    /// True if the run is limited to nothing less than the scene.
    #[must_use]
    pub fn is_whole_scene(&self) -> bool {
        self.regions.is_empty() && self.cells.is_none() && self.at.is_empty() && self.holes.is_empty()
    }
}

/// All settings of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Reading and writing.
    pub scene: SceneSettings,
    /// Reconstruction area.
    pub area: AreaSettings,
    /// Machine and end of run.
    pub run: RunSettings,
    /// Filters.
    pub find: FindSettings,
    /// Fillers.
    pub fill: FillSettings,
    /// Polygons that are water.
    pub water_polygons: Option<WaterFile>,
    /// Parts with settings of their own, in the file's order.
    pub regions: Vec<Region>,
    /// Part of the scene that the run is limited to.
    pub selection: Selection,
}
