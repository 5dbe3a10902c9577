//! The command line: verbs and flags (product.md, "Command line"). Values are checked here as far as one flag alone
//! can be; [`crate::config::Settings::resolve`] joins them with the configuration file.

use crate::config::{
    AreaArgument, ClosedFiller, External, FailOn, HoleClassFilter, HoleShapeFilter, MemoryLimit, MethodName,
    OpenFiller, ProgressMode, Untouched, UpAxis, values,
};
use clap::{ArgAction, Args, Parser, Subcommand};
use std::path::PathBuf;

/// Repairs the holes of tiled city and terrain meshes, from the tiles alone.
#[derive(Debug, Clone, Parser)]
#[command(name = "lacuna", version, propagate_version = true, max_term_width = 100)]
#[command(after_help = "Exit codes: 0 done, 1 failed, 2 usage or configuration, 3 tiles or holes failed,\n\
4 input or output, 5 memory limit too small, 75 another run holds OUT, 130/143 stopped.")]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Flags of every verb.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// The verbs.
#[derive(Debug, Clone, Subcommand)]
pub enum Command {
    /// Say what a scene is: format, grid, cells, triangles, borders
    Info(InfoArgs),
    /// Find holes and say how they would be filled; write no tile
    Inspect(Box<InspectArgs>),
    /// Find, fill, write and report
    Repair(Box<RepairArgs>),
    /// Prove the promises on what was written
    Verify(VerifyArgs),
    /// Measure time, memory and success of the methods on made scenes
    Bench(BenchArgs),
}

/// How the program talks.
#[derive(Debug, Clone, Default, Args)]
pub struct OutputArgs {
    /// Progress on stderr: bars on a terminal, else a line every 5 % (5 s apart) or minute
    #[arg(long, global = true, value_enum, default_value_t, value_name = "MODE")]
    pub progress: ProgressMode,
    /// Log lines as JSON
    #[arg(long, global = true)]
    pub log_json: bool,
    /// Errors only
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// More log lines; twice for all of them
    #[arg(short, long, global = true, action = ArgAction::Count)]
    pub verbose: u8,
}

/// How to read a scene.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Scene")]
pub struct SceneArgs {
    /// Side of a cell, metres (default: inferred from the tiles)
    #[arg(long, value_name = "M", value_parser = values::positive)]
    pub cell_size: Option<f64>,
    /// A corner of the grid, metres (default: inferred)
    #[arg(long, value_name = "X,Y", value_parser = values::pair, allow_hyphen_values = true)]
    pub cell_origin: Option<[f64; 2]>,
    /// Axis that points up (default: what the format says)
    #[arg(long, value_enum, value_name = "AXIS")]
    pub up_axis: Option<UpAxis>,
    /// Spatial reference system, such as EPSG:28992
    #[arg(long, value_name = "SRS")]
    pub srs: Option<String>,
    /// Added to file coordinates to get SRS coordinates, metres
    #[arg(long, value_name = "X,Y[,Z]", value_parser = values::pair_or_triple, allow_hyphen_values = true)]
    pub srs_origin: Option<[f64; 3]>,
}

/// Where holes are looked for, and which of them are taken.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Holes")]
pub struct FindArgs {
    /// Reconstruction area: the cells that have tiles, the box of all vertices, or polygons [default: cells]
    #[arg(long, value_name = "cells|box|FILE.geojson", value_parser = values::area)]
    pub area: Option<AreaArgument>,
    /// What to do with holes at the area's edge [default: skip]
    #[arg(long, value_enum, value_name = "skip|fill", hide_possible_values = true)]
    pub external: Option<External>,
    /// Leave clusters below this area
    #[arg(long, value_name = "M2", value_parser = values::not_negative)]
    pub min_area: Option<f64>,
    /// Leave clusters above this area
    #[arg(long, value_name = "M2", value_parser = values::positive)]
    pub max_area: Option<f64>,
    /// Leave clusters with a longer perimeter
    #[arg(long, value_name = "M", value_parser = values::positive)]
    pub max_perimeter: Option<f64>,
    /// Leave clusters with more rim edges
    #[arg(long, value_name = "N")]
    pub max_edges_around_hole: Option<u64>,
    /// Only clusters with a hole of these classes
    #[arg(long, value_enum, value_delimiter = ',', value_name = "CLASS")]
    pub class: Vec<HoleClassFilter>,
    /// Only clusters with a hole of these shapes
    #[arg(long, value_enum, value_delimiter = ',', value_name = "SHAPE", ignore_case = true)]
    pub shape: Vec<HoleShapeFilter>,
}

/// Which clusters a run is limited to.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Part of the scene")]
pub struct SelectionArgs {
    /// Only clusters in this region of the configuration (may be given again)
    #[arg(long, value_name = "NAME")]
    pub region: Vec<String>,
    /// Only clusters that touch these tiles; one name a line
    #[arg(long, value_name = "FILE")]
    pub cells: Option<PathBuf>,
    /// Only the cluster at this place (may be given again)
    #[arg(long, value_name = "X,Y", value_parser = values::pair, allow_hyphen_values = true)]
    pub at: Vec<[f64; 2]>,
    /// Only the cluster of this hole of a report (may be given again)
    #[arg(long, value_name = "ID")]
    pub hole: Vec<String>,
}

/// How holes are filled.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Fill")]
pub struct FillArgs {
    /// Where the surface comes from [default: field]
    #[arg(long, value_enum, value_name = "METHOD")]
    pub method: Option<MethodName>,
    /// Triangles of closed holes [default: auto]
    #[arg(long, value_enum, value_name = "FILLER")]
    pub closed: Option<ClosedFiller>,
    /// Triangles of open holes [default: auto]
    #[arg(long, value_enum, value_name = "FILLER")]
    pub open: Option<OpenFiller>,
    /// Triangle size of patches, metres (default: graded from the rim)
    #[arg(long, value_name = "M", value_parser = values::positive)]
    pub spacing: Option<f64>,
}

/// How a run uses the machine.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Run")]
pub struct RunArgs {
    /// Memory limit [default: 50% of what the machine or its cgroup has]
    #[arg(long, value_name = "512MiB|50%", value_parser = values::memory)]
    pub memory: Option<MemoryLimit>,
    /// Worker threads; 0 = one a processor [default: 0]
    #[arg(short = 'j', long, value_name = "N")]
    pub threads: Option<usize>,
    /// Treat the tiles as hostile: tighter limits on counts and sizes
    #[arg(long)]
    pub untrusted: bool,
}

/// Arguments of `info`.
#[derive(Debug, Clone, Args)]
pub struct InfoArgs {
    /// Folder of tiles
    #[arg(value_name = "SCENE", required_unless_present = "input", conflicts_with = "input")]
    pub scene: Option<PathBuf>,
    /// The same as SCENE
    #[arg(short, long, value_name = "SCENE")]
    pub input: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// How to read the scene.
    #[command(flatten)]
    pub reading: SceneArgs,
    /// How to use the machine.
    #[command(flatten)]
    pub run: RunArgs,
}

/// Arguments of `inspect`.
#[derive(Debug, Clone, Args)]
pub struct InspectArgs {
    /// Folder of tiles
    #[arg(value_name = "SCENE", conflicts_with = "input")]
    pub scene: Option<PathBuf>,
    /// The same as SCENE
    #[arg(short, long, value_name = "SCENE")]
    pub input: Option<PathBuf>,
    /// Configuration file; flags override it
    #[arg(long, value_name = "FILE.ron")]
    pub config: Option<PathBuf>,
    /// Write report.json, report.html, holes.geojson and cells.geojson into this folder
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// How to read the scene.
    #[command(flatten)]
    pub reading: SceneArgs,
    /// Which holes.
    #[command(flatten)]
    pub find: FindArgs,
    /// Which clusters.
    #[command(flatten)]
    pub selection: SelectionArgs,
    /// How to fill.
    #[command(flatten)]
    pub fill: FillArgs,
    /// How to use the machine.
    #[command(flatten)]
    pub run: RunArgs,
}

/// Arguments of `repair`.
#[derive(Debug, Clone, Args)]
pub struct RepairArgs {
    /// Folder of tiles
    #[arg(value_name = "SCENE", conflicts_with = "input")]
    pub scene: Option<PathBuf>,
    /// Folder to write
    #[arg(value_name = "OUT", conflicts_with = "output")]
    pub out: Option<PathBuf>,
    /// The same as SCENE
    #[arg(short, long, value_name = "SCENE")]
    pub input: Option<PathBuf>,
    /// The same as OUT
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Configuration file; flags override it
    #[arg(long, value_name = "FILE.ron")]
    pub config: Option<PathBuf>,
    /// Tiles that need no patch [default: copy]
    #[arg(long, value_enum, value_name = "MODE")]
    pub untouched: Option<Untouched>,
    /// Start anew: delete what OUT's own manifest lists, then run
    #[arg(long)]
    pub overwrite: bool,
    /// Go on where an earlier run stopped (not in this version).
    #[arg(long, hide = true)]
    pub resume: bool,
    /// Scan, plan and list the holes, write nothing
    #[arg(long)]
    pub dry_run: bool,
    /// What makes the run end with exit code 3 [default: holes]
    #[arg(long, value_enum, value_name = "WHAT")]
    pub fail_on: Option<FailOn>,
    /// Stop at the first tile that cannot be read, instead of leaving it out
    #[arg(long)]
    pub strict: bool,
    /// How to read the scene.
    #[command(flatten)]
    pub reading: SceneArgs,
    /// Which holes.
    #[command(flatten)]
    pub find: FindArgs,
    /// Which clusters.
    #[command(flatten)]
    pub selection: SelectionArgs,
    /// How to fill.
    #[command(flatten)]
    pub fill: FillArgs,
    /// How to use the machine.
    #[command(flatten)]
    pub run: RunArgs,
}

/// Arguments of `verify`.
#[derive(Debug, Clone, Args)]
pub struct VerifyArgs {
    /// The scene that was repaired
    #[arg(value_name = "SCENE", required_unless_present_any = ["input", "digest"], conflicts_with = "input")]
    pub scene: Option<PathBuf>,
    /// The folder that the repair wrote
    #[arg(value_name = "OUT", required_unless_present_any = ["output", "digest"], conflicts_with = "output")]
    pub out: Option<PathBuf>,
    /// The same as SCENE
    #[arg(short, long, value_name = "SCENE")]
    pub input: Option<PathBuf>,
    /// The same as OUT
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Only print one hash over all that OUT promises to be the same in every run
    #[arg(long, value_name = "OUT", conflicts_with_all = ["scene", "out", "input", "output"])]
    pub digest: Option<PathBuf>,
    /// How to use the machine.
    #[command(flatten)]
    pub run: RunArgs,
}

/// Arguments of `bench`.
#[derive(Debug, Clone, Args)]
pub struct BenchArgs {
    /// What to measure, such as configs/bench-small.ron
    #[arg(value_name = "CONFIG.ron")]
    pub config: PathBuf,
    /// Where scenes, tables (bench.md, bench.json) and pictures go; scenes that are there are used again
    #[arg(long, value_name = "DIR", default_value = "bench-out")]
    pub out: PathBuf,
    /// Fail (exit code 1) if memory, or time relative to a copy, is more than a third above this earlier bench.json
    #[arg(long, value_name = "BASELINE.json")]
    pub check: Option<PathBuf>,
    /// Make one scene and end: how the bench starts itself.
    #[arg(long, hide = true)]
    pub make: Option<String>,
}
