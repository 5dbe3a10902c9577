//! `scene demo`: makes the demo scene, has lacuna repair it, and says where to look.

use anyhow::{Context, Result, bail};
use scene::make::{Summary, make};
use scene::maker::{MakeOptions, Maker};
use scene::preset::Preset;
use std::path::Path;
use std::process::Command;

/// Triangles of a cell: fine enough for a good picture, repaired in a second.
const TRIANGLES: u64 = 8_000;

/// Buildings tried in each cell.
const BUILDINGS: u32 = 12;

/// Makes `folder/scene`, repairs it into `folder/repaired` with the table on stdout, and prints where to look.
///
/// Steps: an earlier demo scene in that place is made anew; then `cargo run --package lacuna`, so that a fresh checkout
/// needs no second command.
///
/// # Errors
/// A folder `scene` that holds something else, files that cannot be written, or a repair that fails.
pub(crate) fn demo(folder: &Path) -> Result<()> {
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

/// Runs `lacuna repair` through the cargo that runs this program, built like it.
fn repair(scene: &Path, repaired: &Path) -> Result<()> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml");
    let profile = if cfg!(debug_assertions) { "test" } else { "release" };
    let mut command = Command::new(cargo);
    command.args(["run", "--profile", profile, "--package", "lacuna", "--manifest-path", manifest]);
    command.args(["--", "repair", "--progress", "none"]).arg(scene).arg(repaired);
    let status = command.status().context("cannot start cargo")?;
    if !status.success() {
        bail!("the repair ended with {status}");
    }
    Ok(())
}
