//! Scan: read every tile once, keep its survey, drop its mesh.

use super::RunError;
use super::context::{Context, StageKind};
use super::kept::kept_bytes;
use super::memory_account::MemoryAccount;
use super::preview::tile_preview;
use crate::geometry::box_near_cell;
use crate::report::{DefectRecord, HeightRaster};
use glam::DVec2;
use lacuna_grid::{CellId, Grid, GridHints, InferredGrid, TileBox, infer_grid, is_near_index};
use lacuna_hole::{CellSurvey, Surveys, survey};
use lacuna_mesh::{Bounds, TriMesh};
use lacuna_schedule::{Job, JobResult};
use lacuna_tile::{ReadTile, Scene, TileError, TileGroup, TileHeader, VertexFrame, read_tile};
use std::collections::{BTreeMap, BTreeSet};

/// One file of a cell's tile.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Index into the scene's tiles.
    pub(crate) tile: usize,
    /// Number of its first vertex in the cell's mesh.
    pub(crate) first_vertex: u32,
    /// Number of its vertices.
    pub(crate) vertices: u32,
    /// How it stores positions.
    pub(crate) frame: VertexFrame,
    /// Hash of the bytes that were read.
    pub(crate) hash: [u8; 32],
    /// Size of the file.
    pub(crate) bytes: u64,
}

/// The tile of a cell.
#[derive(Clone, Debug)]
pub(crate) struct CellTile {
    /// What messages call it.
    pub(crate) name: String,
    /// Index into the scene's groups.
    pub(crate) group: usize,
    /// Its files.
    pub(crate) parts: Vec<Part>,
}

/// All that the scan leaves.
pub(crate) struct Scanned {
    pub(crate) surveys: Surveys,
    pub(crate) tiles: BTreeMap<CellId, CellTile>,
    pub(crate) grid: InferredGrid,
    /// Cells whose tile could not be read, with the tile's name.
    pub(crate) unreadable: BTreeMap<CellId, String>,
    /// True if a tile could not be read and nothing says which cell is its.
    pub(crate) lost_cell: bool,
    pub(crate) defects: Vec<DefectRecord>,
    pub(crate) bounds: Bounds,
    /// Small rasters of the tiles.
    pub(crate) previews: Vec<HeightRaster>,
}

/// One tile as the workers return it; its cell is not known yet.
struct ScannedTile {
    survey: CellSurvey,
    preview: Option<HeightRaster>,
    parts: Vec<Part>,
    warnings: Vec<String>,
}

/// Reads and surveys all tiles in parallel under the memory limit, then finds the grid.
pub(crate) fn scan(scene: &Scene, context: &Context<'_>) -> Result<Scanned, RunError> {
    let jobs: Vec<Job> = scene.groups.iter().enumerate().map(|(k, g)| job(scene, k, g)).collect();
    let bytes = |g: &TileGroup| -> u64 { g.parts.iter().map(|&p| tile_bytes(scene, p)).sum() };
    context.progress.start(StageKind::Scan, scene.groups.len() as u64, scene.groups.iter().map(bytes).sum());
    let account = MemoryAccount::new(scene, context);
    account.check_largest(&jobs)?;
    let work = |k: usize| {
        let scanned = scan_group(scene, &scene.groups[k], context);
        account.keep(k, scanned.as_ref().map_or(0, |s| kept_bytes(&s.survey)));
        scanned
    };
    let done = |k: usize| context.progress.advance(bytes(&scene.groups[k]));
    let results = context.pool.run(&jobs, &context.budget, &context.stop, work, done);
    let results = results.map_err(|e| account.too_small(e.index, e.needed_bytes))?;
    context.check_stop()?;
    account.check_kept()?;
    collect(scene, results, context)
}

/// What a scan of a tile takes: its bytes, its mesh, and 16 bytes a vertex for the balance; measured peaks are a
/// quarter lower.
fn job(scene: &Scene, key: usize, group: &TileGroup) -> Job {
    let mesh_bytes = |h: &TileHeader| {
        h.bytes.saturating_add(h.vertices.saturating_mul(56)).saturating_add(h.triangles.saturating_mul(24))
    };
    // A tile with a bad header is not read.
    let need = |p: &usize| scene.tiles[*p].header.as_ref().map_or(0, mesh_bytes);
    Job { key: key as u64, bytes: group.parts.iter().map(need).fold(1 << 20, u64::saturating_add) }
}

pub(super) fn tile_bytes(scene: &Scene, tile: usize) -> u64 {
    scene.tiles[tile].header.as_ref().map_or(0, |h| h.bytes)
}

/// Reads the files of one tile as one mesh and surveys it; the error is the sentence that the report gets.
fn scan_group(scene: &Scene, group: &TileGroup, context: &Context<'_>) -> Result<ScannedTile, String> {
    let sentence = |error: &TileError| error.message_below(&scene.root);
    let mut mesh = TriMesh::default();
    let mut parts = Vec::new();
    let mut warnings = Vec::new();
    for &tile in &group.parts {
        let entry = &scene.tiles[tile];
        if let Err(error) = &entry.header {
            return Err(sentence(error));
        }
        let read = read_tile(&scene.path(entry), entry.format, &context.read_options);
        let read = read.map_err(|e| sentence(&e))?;
        parts.push(Part {
            tile,
            first_vertex: mesh.positions.len() as u32,
            vertices: read.mesh.positions.len() as u32,
            frame: read.frame,
            hash: read.hash,
            bytes: read.bytes,
        });
        warnings.extend(read.warnings.iter().map(|w| format!("{}: {w}", entry.relative.escape_debug())));
        append_mesh(&mut mesh, read);
    }
    if !mesh.positions.is_empty() && !mesh.positions.iter().any(|p| p.is_finite()) {
        let first = scene.tiles[group.parts[0]].relative.escape_debug();
        return Err(format!(
            "{first}: its positions are not finite numbers; export the tile again or take it out of the scene"
        ));
    }
    let survey = survey(CellId::new(0, 0), &mesh);
    let preview = context.draws.then(|| tile_preview(&mesh, &survey.bounds, scene.groups.len()));
    drop(mesh);
    context.trim_if_tight();
    Ok(ScannedTile { survey, preview, parts, warnings })
}

/// Puts a file's mesh behind those of the files before it.
pub(super) fn append_mesh(mesh: &mut TriMesh, read: ReadTile) {
    if mesh.positions.is_empty() {
        *mesh = read.mesh;
        return;
    }
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(read.mesh.positions);
    mesh.triangles.extend(read.mesh.triangles.into_iter().map(|t| t.map(|v| v + first)));
}

fn collect(
    scene: &Scene,
    results: Vec<JobResult<Result<ScannedTile, String>>>,
    context: &Context<'_>,
) -> Result<Scanned, RunError> {
    let (mut good, mut bad, mut defects) = (Vec::new(), Vec::new(), Vec::new());
    for (group, result) in results.into_iter().enumerate() {
        let name = &scene.groups[group].name;
        let problem = match result {
            JobResult::Done(Ok(tile)) => {
                defects.extend(tile.warnings.iter().map(|w| defect(name, w, false)));
                defects.extend(mesh_defects(name, &tile.survey));
                good.push((group, tile));
                continue;
            }
            JobResult::Done(Err(problem)) => problem,
            JobResult::Panicked(message) => {
                format!("the scan stopped with a fault of the program: {message}")
            }
            JobResult::Stopped => continue,
        };
        defects.push(reported(name, &problem, context)?);
        bad.push(group);
    }
    if good.is_empty() {
        let first = defects.iter().find(|d| d.unusable).map_or("", |d| d.what.as_str());
        return Err(RunError::failed(format!("no tile could be read; the first problem: {first}")));
    }
    place(scene, good, &bad, defects, context)
}

/// Gives every tile its cell.
fn place(
    scene: &Scene,
    good: Vec<(usize, ScannedTile)>,
    bad: &[usize],
    mut defects: Vec<DefectRecord>,
    context: &Context<'_>,
) -> Result<Scanned, RunError> {
    let is_empty = |tile: &ScannedTile| !tile.survey.bounds.min.is_finite();
    if !bad.is_empty() && good.iter().all(|(_, tile)| is_empty(tile)) {
        return Err(RunError::failed("no tile of the scene can be used; each one's reason stands above"));
    }
    let grid = find_grid(scene, &good, context)?;
    let (unreadable, mut lost_cell) = cells_of_bad(scene, bad, &grid);
    let (mut surveys, mut tiles) = (Surveys::new(), BTreeMap::new());
    let mut bounds = Bounds::EMPTY;
    let mut previews = Vec::new();
    for ((group, mut tile), &cell) in good.into_iter().zip(&grid.cells) {
        let name = &scene.groups[group].name;
        let Some(cell) = cell else {
            let problem =
                "it holds no vertex, so nothing says which cell it is of; leave it out of the scene";
            defects.push(reported(name, problem, context)?);
            lost_cell = true;
            continue;
        };
        let near = box_near_cell(&tile.survey.bounds, &grid.grid, cell);
        if near == tile.survey.bounds {
            previews.extend(tile.preview);
        } else {
            let what = "vertices more than a cell past its cell do not count for the scene's box";
            defects.push(defect(name, what, false));
        }
        bounds = bounds.union(&near);
        tile.survey.cell = cell;
        tiles.insert(cell, CellTile { name: name.clone(), group, parts: tile.parts });
        surveys.insert(cell, tile.survey);
    }
    Ok(Scanned { surveys, tiles, grid, unreadable, lost_cell, defects, bounds, previews })
}

/// Cells of the tiles that can't be used, and whether there are some whose cell nothing tells.
fn cells_of_bad(scene: &Scene, bad: &[usize], grid: &InferredGrid) -> (BTreeMap<CellId, String>, bool) {
    let mut unreadable = BTreeMap::new();
    let mut lost_cell = false;
    for &group in bad {
        let group = &scene.groups[group];
        match group.index {
            Some((i, j)) if grid.from_names && is_near_index((i, j)) => {
                unreadable.insert(CellId::new(i, j), group.name.clone());
            }
            _ => lost_cell = true,
        }
    }
    (unreadable, lost_cell)
}

/// The record of a tile that can't be used, said aloud; with `--strict` the end of the run.
fn reported(name: &str, problem: &str, context: &Context<'_>) -> Result<DefectRecord, RunError> {
    tracing::warn!("{name}: {problem}");
    if context.settings.run.strict {
        return Err(RunError::failed(problem));
    }
    Ok(defect(name, problem, true))
}

fn find_grid(
    scene: &Scene,
    good: &[(usize, ScannedTile)],
    context: &Context<'_>,
) -> Result<InferredGrid, RunError> {
    let boxes: Vec<TileBox> = good
        .iter()
        .map(|(group, tile)| {
            let g = &scene.groups[*group];
            TileBox {
                name: g.name.clone(),
                index: g.index,
                signed: g.index_is_signed,
                low: tile.survey.bounds.min.truncate(),
                high: tile.survey.bounds.max.truncate(),
            }
        })
        .collect();
    let hints = GridHints {
        cell_size_m: context.settings.scene.cell_size_m,
        origin: context.settings.scene.cell_origin_m.map(DVec2::from),
    };
    let found = infer_grid(&boxes, hints).map_err(|e| RunError::usage(e.to_string()))?;
    say_grid(&found.grid, &found);
    Ok(found)
}

/// Inferred numbers are said aloud, with the flags that override them.
fn say_grid(grid: &Grid, found: &InferredGrid) {
    if found.size_inferred || found.origin_inferred {
        let from = if found.from_names { "names and boxes" } else { "boxes" };
        tracing::info!(
            "grid from the tiles' {from}: cells of {} m, corner at {}, {} (--cell-size, --cell-origin override it)",
            grid.cell_size_m,
            grid.origin.x,
            grid.origin.y
        );
    }
}

fn defect(tile: &str, what: &str, unusable: bool) -> DefectRecord {
    DefectRecord { tile: tile.to_owned(), what: what.to_owned(), unusable }
}

/// What the boundary scan found wrong with a tile's own mesh.
fn mesh_defects(name: &str, survey: &CellSurvey) -> Vec<DefectRecord> {
    let d = &survey.boundary.defects;
    let counts = [
        (d.degenerate, "triangles without area"),
        (d.duplicate, "repeated triangles"),
        (d.non_manifold_edges, "edges with more than two triangles"),
        (d.conflict_edges, "edges whose two triangles face opposite ways"),
    ];
    counts
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| defect(name, &format!("{count} {what}"), false))
        .collect()
}

impl Scanned {
    /// Cells that must not be taken for hollow.
    pub(crate) fn unreadable_cells(&self, area: &BTreeSet<CellId>) -> BTreeSet<CellId> {
        let mut cells: BTreeSet<CellId> = self.unreadable.keys().copied().collect();
        if self.lost_cell {
            cells.extend(area.iter().filter(|c| !self.surveys.contains_key(c)));
        }
        cells
    }
}
