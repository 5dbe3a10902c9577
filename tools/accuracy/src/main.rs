//! The command line of the accuracy bench.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "the command line prints")]

use accuracy::case::{Case, Source, full, quick};
use accuracy::measure::{Figures, Repaired, measure, read_repaired, with_patch};
use accuracy::peers::Peers;
use accuracy::picture::{Curve, chart, error_maps, section, section_line, true_section};
use accuracy::prepare::prepare;
use accuracy::report::{Outcome, Row, by_depth, markdown};
use accuracy::run::{Cost, METHODS, VERB, repair, repair_here};
use accuracy::scene_files::{Tiles, TruthPoint, read_tiles, read_truth, rim_positions};
use anyhow::{Context, Result};
use clap::Parser;
use glam::DVec3;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

#[global_allocator]
static ALLOCATOR: lacuna_system::CountingAllocator = lacuna_system::CountingAllocator;

/// Repairs scenes with known holes with every method and measures what came out.
#[derive(Debug, Parser)]
struct Args {
    /// A few small scenes only: seconds
    #[arg(long)]
    quick: bool,
    /// Where scenes, tables and pictures go; an earlier run's are replaced
    #[arg(long, default_value = "target/accuracy")]
    out: PathBuf,
    /// Folder of real tiles; where it is missing, those scenes are left out
    #[arg(long, default_value = "../shared/data")]
    data: PathBuf,
    /// Only scenes whose kind or name contains this
    #[arg(long)]
    only: Option<String>,
    /// Python with packages of other programs; needs --check
    #[arg(long, requires = "check")]
    peers_python: Option<PathBuf>,
    /// Folder of peers.py
    #[arg(long, requires = "peers_python")]
    check: Option<PathBuf>,
    /// Other programs, as peers.py names them
    #[arg(long, value_delimiter = ',', default_value = "meshlib-nicely")]
    peers: Vec<String>,
}

fn main() -> std::process::ExitCode {
    lacuna_system::limit_arenas(2);
    let arguments: Vec<String> = std::env::args().collect();
    if arguments.get(1).is_some_and(|verb| verb == VERB) {
        let (exit, message) = repair_here(&arguments[2..]);
        message.into_iter().for_each(|m| eprintln!("{m}"));
        return exit.into();
    }
    match bench(&Args::parse()) {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("accuracy: {error:#}");
            std::process::ExitCode::FAILURE
        }
    }
}

fn bench(args: &Args) -> Result<()> {
    let has_data = args.data.is_dir();
    if !args.quick && !has_data {
        println!("{}: not there; scenes on real data are left out\n", args.data.display());
    }
    let mut cases = if args.quick { quick() } else { full(has_data) };
    if let Some(word) = &args.only {
        cases.retain(|c| c.kind.contains(word.as_str()) || c.name.contains(word.as_str()));
    }
    let scenes = args.out.join("scenes");
    if scenes.exists() {
        std::fs::remove_dir_all(&scenes).with_context(|| scenes.display().to_string())?;
    }
    let mut rows = Vec::new();
    for case in &cases {
        eprintln!("{}", case.name);
        rows.extend(bench_case(case, args, &scenes.join(&case.name))?);
        std::fs::remove_dir_all(scenes.join(&case.name))?;
    }
    draw_depths(&rows, &args.out)?;
    let tables = markdown(&rows);
    std::fs::write(args.out.join("accuracy.md"), &tables)?;
    std::fs::write(args.out.join("accuracy.json"), serde_json::to_string_pretty(&rows)?)?;
    print!("{tables}");
    println!("Tables, JSON and pictures: {}", args.out.display());
    Ok(())
}

/// A scene, ready to be measured on.
struct Ready {
    folder: PathBuf,
    tiles: Tiles,
    truth: Vec<TruthPoint>,
    rims: Vec<DVec3>,
}

/// What a program made of a scene.
struct Made {
    method: String,
    result: Result<(Repaired, Figures, Cost)>,
}

fn bench_case(case: &Case, args: &Args, folder: &Path) -> Result<Vec<Row>> {
    let scene = folder.join("scene");
    prepare(case, &args.data, &scene)?;
    let tiles = read_tiles(&scene)?;
    let ready =
        Ready { truth: read_truth(&scene)?, rims: rim_positions(&tiles), tiles, folder: folder.to_owned() };
    let area = if matches!(case.source, Source::Dug { .. }) { "box" } else { "cells" };
    let mut made: Vec<Made> = METHODS
        .iter()
        .map(|&method| {
            let out = folder.join(method.word());
            let result = repair(method, &scene, &out, area).and_then(|cost| {
                let repaired = read_repaired(&ready.tiles, &out)?;
                let figures = measure(&repaired, &ready.truth, &ready.rims);
                Ok((repaired, figures, cost))
            });
            Made { method: method.word().to_owned(), result }
        })
        .collect();
    if let (Some(python), Some(check), Source::Made { .. }) = (&args.peers_python, &args.check, &case.source)
    {
        let peers = Peers { python, check };
        made.extend(args.peers.iter().map(|name| run_peer(&peers, name, &ready)));
    }
    if case.name.ends_with("_1") {
        draw(case, &ready, &made, &args.out)?;
    }
    let row = |made: Made| Row {
        kind: case.kind.to_owned(),
        scene: case.name.clone(),
        method: made.method,
        outcome: made
            .result
            .map(|(_, figures, cost)| Outcome { figures, cost })
            .map_err(|e| format!("{e:#}")),
    };
    Ok(made.into_iter().map(row).collect())
}

fn run_peer(peers: &Peers<'_>, name: &str, ready: &Ready) -> Made {
    let filled = peers.fill(name, &ready.folder.join("scene"), &ready.folder.join("peers"));
    let result = filled.map(|(patch, cost)| {
        let repaired = with_patch(&ready.tiles, &patch);
        let figures = measure(&repaired, &ready.truth, &ready.rims);
        (repaired, figures, cost)
    });
    Made { method: name.to_owned(), result }
}

/// Draws a section and the maps of a scene.
fn draw(case: &Case, ready: &Ready, made: &[Made], out: &Path) -> Result<()> {
    let Some((hole, y, line)) = section_line(&ready.truth) else { return Ok(()) };
    let good = || made.iter().filter_map(|m| Some((&m.method, m.result.as_ref().ok()?)));
    let truth = Curve { name: "truth".to_owned(), points: true_section(&ready.truth, hole, y, line) };
    let curves: Vec<Curve> =
        std::iter::once(truth)
            .chain(good().map(|(name, (repaired, ..))| Curve {
                name: name.clone(),
                points: section(repaired, y, line),
            }))
            .collect();
    let title = format!("{}: section through the largest hole", case.kind);
    std::fs::write(
        out.join(format!("{}_section.svg", case.name)),
        chart(&title, ["m", "height m"], None, &curves),
    )?;
    let maps: Vec<(&str, &[Option<f64>])> =
        good().map(|(name, (_, figures, _))| (name.as_str(), figures.errors.as_slice())).collect();
    let full_m = good().map(|(_, (_, f, _))| 2.0 * f.error.rmse_m).fold(0.0, f64::max).max(0.01);
    let maps = error_maps(&ready.truth, hole, full_m, &maps);
    std::fs::write(out.join(format!("{}_map.svg", case.name)), maps)?;
    Ok(())
}

/// Draws error against depth for every kind of scene, all seeds together.
fn draw_depths(rows: &[Row], out: &Path) -> Result<()> {
    let mut kinds: Vec<&str> = rows.iter().map(|r| r.kind.as_str()).collect();
    kinds.dedup();
    for kind in kinds {
        let of_kind = || rows.iter().filter(|r| r.kind == kind);
        let mut methods: Vec<&str> = of_kind().map(|r| r.method.as_str()).collect();
        let mut seen = BTreeSet::new();
        methods.retain(|m| seen.insert(*m));
        let curve = |method: &str| {
            let outcomes: Vec<&Outcome> =
                of_kind().filter(|r| r.method == method).filter_map(|r| r.outcome.as_ref().ok()).collect();
            let points = by_depth(&outcomes).into_iter().map(|(depth, cm)| [depth, cm]).collect();
            Curve { name: method.to_owned(), points }
        };
        let curves: Vec<Curve> = methods.into_iter().map(curve).collect();
        let name: String = kind.chars().filter(char::is_ascii_alphanumeric).collect();
        let title = format!("{kind}: error against depth (0 = rim, 1 = farthest from it)");
        std::fs::write(
            out.join(format!("{name}_depth.svg")),
            chart(&title, ["depth", "mean error cm"], Some(0.0), &curves),
        )?;
    }
    Ok(())
}
