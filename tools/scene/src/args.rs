//! The command line.

use clap::{Args as ClapArgs, Parser, Subcommand};
use scene::dig::DigOptions;
use scene::encode::Format;
use scene::maker::{CutOption, MakeOptions};
use scene::preset::Preset;
use std::path::PathBuf;
use std::str::FromStr;

/// Tiled scenes with known holes.
#[derive(Debug, Parser)]
#[command(version, about)]
pub(crate) struct Args {
    /// What to do.
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Make a synthetic scene: tiles, scene.json and truth.csv
    Make(MakeArgs),
    /// Dig discs into an existing scene of binary PLY or OBJ tiles, and keep the truth
    Dig(DigArgs),
}

/// Arguments of `dig`.
#[derive(Debug, ClapArgs)]
pub(crate) struct DigArgs {
    /// Folder of tiles
    pub(crate) scene: PathBuf,
    /// New or empty folder
    pub(crate) out: PathBuf,
    /// How many discs
    #[arg(long, value_name = "N")]
    discs: usize,
    /// Smallest and largest radius, metres
    #[arg(long, value_name = "A,B", value_parser = parse_pair::<f64>)]
    radius: [f64; 2],
    /// Put centres on borders between tiles
    #[arg(long)]
    across_borders: bool,
    /// Seed of places and radii
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl DigArgs {
    /// The options that the arguments ask for.
    pub(crate) fn options(&self) -> DigOptions {
        DigOptions {
            discs: self.discs,
            radius_m: self.radius,
            across_borders: self.across_borders,
            seed: self.seed,
        }
    }
}

/// Arguments of `make`.
#[derive(Debug, ClapArgs)]
pub(crate) struct MakeArgs {
    /// Which holes and cells
    #[arg(long)]
    preset: Preset,
    /// New or empty folder
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Triangles a cell, about [default: the preset's]
    #[arg(long, value_name = "N")]
    triangles: Option<u64>,
    /// Tile format
    #[arg(long, default_value = "ply")]
    format: Format,
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How tiles meet: exact, overrun:M or ragged:M (metres)
    #[arg(long, default_value = "exact", value_name = "CUT", value_parser = parse_cut)]
    cut: CutOption,
    /// Add X,Y metres (formats obj and ply-double)
    #[arg(long, default_value = "0,0", value_name = "X,Y", allow_hyphen_values = true, value_parser = parse_pair::<f64>)]
    shift: [f64; 2],
    /// Turn the scene to the left, degrees
    #[arg(long, default_value = "0", value_parser = ["0", "90", "180", "270"])]
    turn: String,
    /// Swap east and west (before turning)
    #[arg(long)]
    mirror: bool,
    /// Put triangles, and the corners of each, in random order
    #[arg(long)]
    shuffle: bool,
    /// Put vertices in random order
    #[arg(long)]
    renumber: bool,
    /// Columns and rows [default: the preset's]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    cells: Option<[i64; 2]>,
    /// Buildings to try in each cell
    #[arg(long, default_value_t = 0, value_name = "N")]
    buildings: u32,
}

impl MakeArgs {
    /// The options that the arguments ask for.
    pub(crate) fn options(&self) -> MakeOptions {
        MakeOptions {
            preset: self.preset,
            triangles: self.triangles,
            format: self.format,
            seed: self.seed,
            cut: self.cut,
            shift_m: self.shift,
            turns: match self.turn.as_str() {
                "90" => 1,
                "180" => 2,
                "270" => 3,
                _ => 0,
            },
            mirror: self.mirror,
            shuffle: self.shuffle,
            renumber: self.renumber,
            cells: self.cells,
            buildings: self.buildings,
        }
    }
}

fn parse_cut(text: &str) -> Result<CutOption, String> {
    let metres = |m: &str| m.parse::<f64>().map_err(|e| format!("{m}: {e}"));
    match text.split_once(':') {
        None if text == "exact" => Ok(CutOption::Exact),
        Some(("overrun", m)) => Ok(CutOption::Overrun(metres(m)?)),
        Some(("ragged", m)) => Ok(CutOption::Ragged(metres(m)?)),
        _ => Err("give exact, overrun:M or ragged:M".to_owned()),
    }
}

/// Two numbers with a comma between.
fn parse_pair<T: FromStr>(text: &str) -> Result<[T; 2], String> {
    split_pair(text, ',')
}

fn parse_size(text: &str) -> Result<[i64; 2], String> {
    let size: [i64; 2] = split_pair(text, 'x')?;
    if size.iter().all(|k| (1..=10_000).contains(k)) {
        Ok(size)
    } else {
        Err("give 1 to 10000 each".to_owned())
    }
}

fn split_pair<T: FromStr>(text: &str, mark: char) -> Result<[T; 2], String> {
    let problem = || format!("give two numbers with '{mark}' between");
    let (first, second) = text.split_once(mark).ok_or_else(problem)?;
    let number = |t: &str| t.trim().parse().map_err(|_| problem());
    Ok([number(first)?, number(second)?])
}
