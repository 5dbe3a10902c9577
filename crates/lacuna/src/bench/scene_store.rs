//! Scenes on disk: made once, tile by tile, and used again by later runs.

use super::config::SceneSpec;
use crate::RunError;
use scene::lattice::UNITS_PER_M;
use scene::make::make_tiles;
use scene::maker::{MakeOptions, Maker};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What is known of a made scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MadeScene {
    /// Name of its folder.
    pub name: String,
    /// Version of lacuna that made it: other versions may make other tiles.
    pub lacuna: String,
    /// What was asked for.
    pub spec: SceneSpec,
    /// Cells of the area, hollow ones counted in.
    pub cells: u64,
    /// Tiles.
    pub tiles: u64,
    /// Triangles of all tiles.
    pub triangles: u64,
    /// Bytes of all tiles.
    pub bytes: u64,
    /// Area of all cells, square kilometres.
    pub area_km2: f64,
    /// Holes that the tiles show, one a cell, by kind (`closed`, `I-A` ...).
    pub holes: BTreeMap<String, u64>,
}

/// The record beside the tiles.
const RECORD: &str = "made.json";

/// The folder of the tiles of a scene.
pub(super) fn tiles_folder(store: &Path, spec: &SceneSpec) -> PathBuf {
    store.join(spec.folder_name()).join("tiles")
}

/// The record of a scene that this version has made, if it is there.
///
/// # Errors
/// The folder is there but holds something else.
pub(super) fn find(store: &Path, spec: &SceneSpec) -> Result<Option<MadeScene>, RunError> {
    let folder = store.join(spec.folder_name());
    if !folder.exists() {
        return Ok(None);
    }
    let text = std::fs::read_to_string(folder.join(RECORD)).unwrap_or_default();
    let made: Option<MadeScene> = serde_json::from_str(&text).ok();
    match made.filter(|m| m.spec == *spec && m.lacuna == env!("CARGO_PKG_VERSION")) {
        Some(made) => Ok(Some(made)),
        None => Err(RunError::usage(format!(
            "{}: holds no scene that this version has made; remove it, or name another --out",
            folder.display()
        ))),
    }
}

/// The maker of a scene: plans its holes, makes nothing.
///
/// # Errors
/// Options that no scene can have.
pub(super) fn plan(spec: &SceneSpec) -> Result<Maker, RunError> {
    let options = MakeOptions {
        triangles: Some(spec.triangles),
        format: spec.format,
        seed: spec.seed,
        cells: spec.cells,
        ..MakeOptions::new(spec.preset)
    };
    Maker::new(options).map_err(|e| RunError::usage(format!("scene {}: {e}", spec.folder_name())))
}

/// Makes a scene. Its folder appears whole or not at all; what an earlier run left unfinished is removed first.
///
/// # Errors
/// Options that no scene can have; files that cannot be written.
pub(super) fn make(store: &Path, spec: &SceneSpec) -> Result<(), RunError> {
    let maker = plan(spec)?;
    let unfinished = store.join(format!("unfinished-{}", spec.folder_name()));
    let failed = |e: &dyn std::fmt::Display| RunError::input_output(format!("{}: {e}", unfinished.display()));
    if unfinished.exists() {
        std::fs::remove_dir_all(&unfinished).map_err(|e| failed(&e))?;
    }
    let summary = make_tiles(&maker, &unfinished.join("tiles")).map_err(|e| failed(&e))?;
    let cell_size_m = (maker.plan().cell_size_m * UNITS_PER_M).round() / UNITS_PER_M;
    let made = MadeScene {
        name: spec.folder_name(),
        lacuna: env!("CARGO_PKG_VERSION").to_owned(),
        spec: spec.clone(),
        cells: summary.cells as u64,
        tiles: summary.tiles as u64,
        triangles: summary.triangles,
        bytes: summary.bytes,
        area_km2: summary.cells as f64 * cell_size_m * cell_size_m * 1e-6,
        holes: summary.counts.iter().map(|(class, count)| (class.to_string(), *count as u64)).collect(),
    };
    let record = serde_json::to_string_pretty(&made).map_err(|e| failed(&e))?;
    std::fs::write(unfinished.join(RECORD), record).map_err(|e| failed(&e))?;
    std::fs::rename(&unfinished, store.join(spec.folder_name())).map_err(|e| failed(&e))
}
