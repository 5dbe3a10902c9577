//! `info`: what a scene is, without a plan.

use super::RunError;
use super::assemble::border_mode;
use super::context::{Context, Stages};
use super::scan::scan;
use crate::Interrupt;
use crate::config::Settings;
use crate::progress::Progress;
use lacuna_hole::{BorderMode, fit_borders};
use lacuna_tile::{SceneOptions, open_scene};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// What `info` says.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneInfo {
    /// Number of tiles by format.
    pub formats: BTreeMap<String, u64>,
    /// Spatial reference system, if the scene or the flags name one.
    pub srs: Option<String>,
    /// What is added to file coordinates to get SRS coordinates.
    pub srs_origin: Option<[f64; 3]>,
    /// The file that said so.
    pub metadata: Option<String>,
    /// Side of a cell, metres.
    pub cell_size_m: f64,
    /// A corner of the grid, file coordinates, metres.
    pub grid_origin_m: [f64; 2],
    /// True if the grid was inferred from names and boxes.
    pub grid_inferred: bool,
    /// Number of cells with a tile.
    pub cells: u64,
    /// Tiles that could not be read.
    pub unreadable: Vec<String>,
    /// Number of triangles.
    pub triangles: u64,
    /// Number of vertices.
    pub vertices: u64,
    /// Bytes of all tiles.
    pub bytes: u64,
    /// Files beside the tiles (textures, materials, metadata).
    pub side_files: u64,
    /// Lowest corner of the box of all vertices, metres.
    pub min_m: [f64; 3],
    /// Highest corner.
    pub max_m: [f64; 3],
    /// How tiles meet their borders: exact, overrun, ragged, overlap.
    pub border_mode: String,
    /// How far tiles run past their cell, metres.
    pub overrun_m: Option<f64>,
    /// Median length of the boundary edges, metres.
    pub boundary_edge_m: f64,
    /// What is worth knowing.
    pub warnings: Vec<String>,
}

/// Reads all tiles of a scene and describes it.
///
/// # Errors
/// Unreadable scene, unusable settings, a memory limit too small for a tile, or a stop.
pub fn info(settings: &Settings, interrupt: &Interrupt, progress: &Progress) -> Result<SceneInfo, RunError> {
    let context = Context::new(settings, interrupt, progress)?.only_looking(false);
    let scene = open_scene(&settings.scene.input, &SceneOptions { follow_symlinks: !settings.run.untrusted })
        .map_err(super::run::scene_error)?;
    let scanned = Stages::default().measure("scan", || scan(&scene, &context))?;
    let fit = fit_borders(&scanned.surveys, &scanned.grid.grid);
    let mut formats: BTreeMap<String, u64> = BTreeMap::new();
    for tile in &scene.tiles {
        *formats.entry(format!("{:?}", tile.format).to_uppercase()).or_default() += 1;
    }
    let metadata = scene.metadata.as_ref();
    let defects = scanned.defects.iter().filter(|d| !d.unusable).map(|d| format!("{}: {}", d.tile, d.what));
    Ok(SceneInfo {
        formats,
        srs: settings.scene.srs.clone().or_else(|| metadata.and_then(|m| m.srs.clone())),
        srs_origin: settings.scene.srs_origin.or_else(|| metadata.map(|m| m.srs_origin)),
        metadata: metadata.map(|m| m.source.clone()),
        cell_size_m: scanned.grid.grid.cell_size_m,
        grid_origin_m: scanned.grid.grid.origin.to_array(),
        grid_inferred: scanned.grid.size_inferred || scanned.grid.origin_inferred,
        cells: scanned.surveys.len() as u64,
        unreadable: scanned.defects.iter().filter(|d| d.unusable).map(|d| d.what.clone()).collect(),
        triangles: scanned.surveys.values().map(|s| s.triangles).sum(),
        vertices: scanned.surveys.values().map(|s| s.vertices).sum(),
        bytes: scanned.tiles.values().flat_map(|t| &t.parts).map(|p| p.bytes).sum(),
        side_files: scene.side_files.len() as u64,
        min_m: scanned.bounds.min.to_array(),
        max_m: scanned.bounds.max.to_array(),
        border_mode: border_mode(fit.mode).to_owned(),
        overrun_m: (fit.mode == BorderMode::Overrun).then_some(fit.margin_m),
        boundary_edge_m: fit.edge_m,
        warnings: scene.warnings.iter().cloned().chain(defects).collect(),
    })
}

impl SceneInfo {
    /// The same as lines for people.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        let mut line = |name: &str, value: String| {
            let _ = writeln!(text, "{name:<12} {value}");
        };
        let formats: Vec<String> = self.formats.iter().map(|(name, n)| format!("{n} {name}")).collect();
        line(
            "tiles",
            format!("{} ({} bytes, {} side files)", formats.join(", "), self.bytes, self.side_files),
        );
        line("surface", format!("{} triangles, {} vertices", self.triangles, self.vertices));
        line("box", format!("{} .. {}", place(&self.min_m), place(&self.max_m)));
        let inferred =
            if self.grid_inferred { " (inferred; --cell-size, --cell-origin override)" } else { "" };
        line(
            "grid",
            format!(
                "{} cells of {} m, corner at {}, {}{inferred}",
                self.cells, self.cell_size_m, self.grid_origin_m[0], self.grid_origin_m[1]
            ),
        );
        let by = self.overrun_m.map_or_else(String::new, |m| format!(" {m:.2} m"));
        line("borders", format!("{}{by}", self.border_mode));
        let srs = self.srs.as_deref().map_or("not known", |s| s.lines().next().unwrap_or(s));
        line("SRS", srs.to_owned());
        if let Some(origin) = &self.srs_origin {
            line("SRS origin", place(origin));
        }
        if let Some(source) = &self.metadata {
            line("metadata", source.clone());
        }
        for problem in self.unreadable.iter().chain(&self.warnings) {
            line("note", problem.clone());
        }
        text
    }
}

fn place(p: &[f64; 3]) -> String {
    format!("{:.3}, {:.3}, {:.3}", p[0], p[1], p[2])
}
