//! `cargo demo [FOLDER]`: makes the demo scene, has lacuna repair it, and says where to look.
//!
//! It is built as a test without a harness, so that it and `cargo test --workspace` compile nothing twice; `cargo test`
//! alone does not run it.
#![allow(clippy::print_stdout, reason = "the command line prints its results")]

use anyhow::{Context, Result, bail};
use scene::make::{Summary, make};
use scene::maker::{MakeOptions, Maker};
use scene::preset::Preset;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Triangles of a cell: fine enough for a good picture, repaired in a second.
const TRIANGLES: u64 = 8_000;

/// Buildings tried in each cell.
const BUILDINGS: u32 = 12;

fn main() -> Result<()> {
    // Cargo starts tests in the folder of their crate; paths of the demo are counted from the checkout's root.
    std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))?;
    demo(&std::env::args_os().nth(1).map_or_else(|| PathBuf::from("demo"), PathBuf::from))
}

/// Makes `folder/scene`, repairs it into `folder/repaired` with the table on stdout, and prints where to look. The scene
/// of an earlier demo in that place is made anew.
fn demo(folder: &Path) -> Result<()> {
    let (scene, repaired) = (folder.join("scene"), folder.join("repaired"));
    clear_earlier(&scene)?;
    let options =
        MakeOptions { triangles: Some(TRIANGLES), buildings: BUILDINGS, ..MakeOptions::new(Preset::Demo) };
    let summary = make(&Maker::new(options)?, &scene)?;
    println!("{}", describe(&summary, &scene));
    println!("lacuna repair {} {}\n", scene.display(), repaired.display());
    repair(&scene, &repaired)?;
    println!("\nThe page with map and pictures:  {}", repaired.join("lacuna/report.html").display());
    println!("The repaired tiles:              {}", repaired.display());
    println!("The tiles before:                {}", scene.display());
    Ok(())
}

fn describe(summary: &Summary, scene: &Path) -> String {
    let holes: usize = summary.counts.values().sum();
    format!(
        "{}: {} tiles in {} cells, {} triangles, {holes} holes (one a cell).",
        scene.display(),
        summary.tiles,
        summary.cells,
        summary.triangles
    )
}

/// Removes the scene of an earlier demo; a folder with anything else is refused.
fn clear_earlier(scene: &Path) -> Result<()> {
    if !scene.exists() {
        return Ok(());
    }
    let record = std::fs::read_to_string(scene.join("scene.json")).unwrap_or_default();
    if !record.starts_with("{\"name\":\"demo\"") {
        bail!("{} holds no demo scene; name another folder: cargo demo FOLDER", scene.display());
    }
    std::fs::remove_dir_all(scene).with_context(|| format!("cannot remove {}", scene.display()))
}

fn repair(scene: &Path, repaired: &Path) -> Result<()> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
    command.args(["repair", "--progress", "none"]).arg(scene).arg(repaired);
    let status = command.status().context("cannot start lacuna")?;
    if !status.success() {
        bail!("the repair ended with {status}");
    }
    Ok(())
}
