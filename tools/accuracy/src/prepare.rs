//! Makes the scene of a case in a folder.

use crate::case::{Case, Source};
use crate::rework::rework;
use anyhow::{Context, Result};
use scene::dig::{DigOptions, dig};
use scene::make::make;
use scene::maker::{MakeOptions, Maker};
use std::path::Path;

/// Makes tiles, `scene.json` and `truth.csv` in `folder`, which must not exist; `data` holds real tiles.
///
/// # Errors
/// A folder that can't be written, data that is not there, holes that find no room.
pub fn prepare(case: &Case, data: &Path, folder: &Path) -> Result<()> {
    let work = || -> Result<()> {
        match &case.source {
            Source::Made { preset, triangles, seed, ground, rim } => {
                let options =
                    MakeOptions { triangles: Some(*triangles), seed: *seed, ..MakeOptions::new(*preset) };
                make(&Maker::new(options)?, folder)?;
                rework(folder, *ground, *rim, *seed, data)
            }
            Source::Dug { folder: source, discs, radius_m, across_borders, seed } => {
                let options = DigOptions {
                    discs: *discs,
                    radius_m: *radius_m,
                    across_borders: *across_borders,
                    seed: *seed,
                };
                dig(&data.join(source), folder, &options)?;
                Ok(())
            }
        }
    };
    work().with_context(|| format!("scene {}", case.name))
}
