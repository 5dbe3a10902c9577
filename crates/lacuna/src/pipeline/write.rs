//! Write: repaired tiles with their patches appended, new tiles for hollow cells, everything else copied.

use super::RunError;
use super::context::{Context, StageKind};
use super::manifest::OutputFile;
use super::names::Names;
use super::scan::{CellTile, Part};
use super::solve::{FilledHole, Fills, NotFilled};
use crate::config::Untouched;
use crate::report::DefectRecord;
use glam::DVec3;
use lacuna_close::Source;
use lacuna_grid::CellId;
use lacuna_hole::Plan;
use lacuna_mesh::VertexId;
use lacuna_schedule::{Job, JobResult};
use lacuna_tile::{
    AppendRequest, CopyMode, Corner, Hashing, HolePatch, NewTileRequest, Scene, TileEntry, TileError,
    append_patches, copy_file, new_tile, output_path,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What the write stage reads.
pub(crate) struct WriteInput<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) out: &'a Path,
    pub(crate) plan: &'a Plan,
    pub(crate) names: &'a Names,
    pub(crate) tiles: &'a BTreeMap<CellId, CellTile>,
    pub(crate) fills: &'a Fills,
    /// Holes that are written: all of a cluster, or none.
    pub(crate) holes: &'a BTreeSet<u32>,
    /// Template cell and relative path of the tile of every hollow cell.
    pub(crate) hollow: &'a BTreeMap<CellId, (CellId, String)>,
}

/// What was written.
#[derive(Debug, Default)]
pub(crate) struct WrittenFiles {
    pub(crate) outputs: Vec<OutputFile>,
    /// Files of the scene that could not be copied, as the report names them.
    pub(crate) missing: Vec<DefectRecord>,
    /// Cells whose tile could not take its patches, with the reason.
    pub(crate) refused: BTreeMap<CellId, String>,
}

/// One file to write.
enum Task {
    /// A file of the scene with patches behind it.
    Append { cell: CellId, part: Part, holes: Vec<u32> },
    /// A tile for a cell that has none.
    New { cell: CellId, template: usize, relative: String, holes: Vec<u32> },
    /// A file as it is.
    Copy { relative: String, bytes: u64 },
}

/// Writes all files. An error of the output ends the run; a file of the scene that can't be read any more is a record, and
/// a tile that can't take its patches is named, so that its clusters can be left whole.
pub(crate) fn write(input: &WriteInput<'_>, context: &Context<'_>) -> Result<WrittenFiles, RunError> {
    let tasks = tasks(input, context.settings.scene.untouched);
    let jobs: Vec<Job> =
        tasks.iter().enumerate().map(|(k, t)| Job { key: k as u64, bytes: task_bytes(input, t) }).collect();
    let total: u64 = tasks.iter().map(|t| file_bytes(input, t)).sum();
    context.progress.start(StageKind::Write, tasks.len() as u64, total);
    let results = context
        .pool
        .run(
            &jobs,
            &context.budget_beside(0),
            &context.stop,
            |k| perform(input, &tasks[k], context),
            |k| {
                context.progress.advance(file_bytes(input, &tasks[k]));
            },
        )
        .map_err(|e| context.memory_too_small("writing the largest tile", e.needed_bytes, e.limit_bytes))?;
    context.check_stop()?;
    let mut written = WrittenFiles::default();
    for (task, result) in tasks.iter().zip(results) {
        match result {
            JobResult::Done(Ok(files)) => written.outputs.extend(files),
            JobResult::Done(Err(error)) => refuse(input, task, &error, &mut written)?,
            JobResult::Panicked(message) => {
                return Err(RunError::failed(format!("a fault of the program while writing: {message}")));
            }
            JobResult::Stopped => {}
        }
    }
    written.outputs.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(written)
}

/// Errors of the output end the run; a file that can't be read, or a format that can't hold its patches, is that tile's
/// failure.
fn refuse(
    input: &WriteInput<'_>,
    task: &Task,
    error: &TileError,
    written: &mut WrittenFiles,
) -> Result<(), RunError> {
    let scene = input.scene;
    let (cell, source) = match task {
        Task::Append { cell, part, .. } => (Some(*cell), &scene.tiles[part.tile].relative),
        Task::New { cell, template, .. } => (Some(*cell), &scene.tiles[*template].relative),
        Task::Copy { relative, .. } => (None, relative),
    };
    let is_of_input = error.path() == scene.root.join(source);
    let problem = error.message_below(&scene.root);
    match cell {
        Some(cell) if is_of_input || !matches!(error, TileError::Io { .. }) => {
            written.refused.insert(cell, problem);
        }
        None if is_of_input => written.missing.push(missing_file(scene, source, problem)),
        _ => return Err(RunError::input_output(error.to_string())),
    }
    Ok(())
}

/// The record of a file that OUT lacks because it can't be read.
fn missing_file(scene: &Scene, relative: &str, problem: String) -> DefectRecord {
    let tile = scene.tiles.iter().find(|t| t.relative == relative);
    let name = tile.map_or(relative, |t| &t.name);
    DefectRecord { tile: name.to_owned(), what: problem, unusable: true }
}

fn tasks(input: &WriteInput<'_>, untouched: Untouched) -> Vec<Task> {
    let mut tasks = Vec::new();
    let mut patched: BTreeSet<usize> = BTreeSet::new();
    for (cell, holes) in holes_by_cell(input) {
        match input.tiles.get(&cell) {
            Some(tile) => {
                for (part, holes) in holes_by_part(input, tile, &holes) {
                    patched.insert(part.tile);
                    tasks.push(Task::Append { cell, part, holes });
                }
            }
            None => {
                let Some((template, relative)) = input.hollow.get(&cell) else { continue };
                let Some(template) = input.tiles.get(template) else { continue };
                tasks.push(Task::New {
                    cell,
                    template: template.parts[0].tile,
                    relative: relative.clone(),
                    holes,
                });
            }
        }
    }
    if untouched == Untouched::Omit {
        return tasks;
    }
    let others = (0..input.scene.tiles.len()).filter(|k| !patched.contains(k)).map(|k| &input.scene.tiles[k]);
    let bytes = |tile: &TileEntry| tile.header.as_ref().map_or(0, |h| h.bytes);
    let tiles = others.map(|t| Task::Copy { relative: t.relative.clone(), bytes: bytes(t) });
    let side_files =
        input.scene.side_files.iter().map(|relative| Task::Copy { relative: relative.clone(), bytes: 0 });
    tasks.extend(tiles.chain(side_files));
    tasks
}

fn holes_by_cell(input: &WriteInput<'_>) -> BTreeMap<CellId, Vec<u32>> {
    let mut by_cell: BTreeMap<CellId, Vec<u32>> = BTreeMap::new();
    for &h in input.holes {
        by_cell.entry(input.plan.holes[h as usize].cell).or_default().push(h);
    }
    by_cell
}

/// The holes of a tile, each in the file that holds most of its rim.
fn holes_by_part(input: &WriteInput<'_>, tile: &CellTile, holes: &[u32]) -> Vec<(Part, Vec<u32>)> {
    let mut by_part: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
    for &h in holes {
        // Of a merged patch a small hole's cell may get no triangle.
        if let Some(Ok(filled)) = input.fills.get(&h).filter(|f| has_triangles(f)) {
            by_part.entry(main_part(tile, filled)).or_default().push(h);
        }
    }
    by_part.into_iter().map(|(k, holes)| (tile.parts[k].clone(), holes)).collect()
}

fn has_triangles(fill: &Result<FilledHole, NotFilled>) -> bool {
    fill.as_ref().is_ok_and(|f| !f.patch.triangles.is_empty())
}

fn main_part(tile: &CellTile, filled: &FilledHole) -> usize {
    let count = |part: &Part| {
        filled.sources.iter().filter(|s| matches!(s, Source::Original(v) if holds(part, *v))).count()
    };
    let counts: Vec<usize> = tile.parts.iter().map(count).collect();
    (0..counts.len()).rev().max_by_key(|&k| counts[k]).unwrap_or(0)
}

fn holds(part: &Part, vertex: VertexId) -> bool {
    (part.first_vertex..part.first_vertex + part.vertices).contains(&vertex.0)
}

/// The patch of a hole as the writer wants it: rim vertices by number where they stand in this file, copies of all others.
fn hole_patch(input: &WriteInput<'_>, hole: u32, part: Option<&Part>) -> Option<HolePatch> {
    let record = &input.plan.holes[hole as usize];
    let filled = input.fills.get(&hole)?.as_ref().ok()?;
    let mut vertices: Vec<DVec3> = Vec::new();
    let mut corners: Vec<Corner> = Vec::with_capacity(filled.rim.len());
    for (position, source) in filled.rim.iter().zip(&filled.sources) {
        let own = match (source, part) {
            (Source::Original(v), Some(part)) if holds(part, *v) => Some(VertexId(v.0 - part.first_vertex)),
            _ => None,
        };
        corners.push(own.map_or_else(
            || {
                vertices.push(*position);
                Corner::New(vertices.len() as u32 - 1)
            },
            Corner::Original,
        ));
    }
    let first_new = vertices.len() as u32;
    vertices.extend(&filled.patch.vertices);
    let count = corners.len() as u32;
    let corner = |v: u32| if v < count { corners[v as usize] } else { Corner::New(first_new + v - count) };
    let name = &input.names.holes[hole as usize];
    Some(HolePatch {
        hole: name.id.clone(),
        cluster: input.names.clusters[record.cluster as usize].clone(),
        class: record.class.class().to_owned(),
        shape: record.class.shape().map(|s| s.letter().to_owned()),
        method: filled.method.word().to_owned(),
        filler: filled.filler.to_string(),
        area_m2: (record.area_m2 * 1e3).round() / 1e3,
        vertices,
        triangles: filled.patch.triangles.iter().map(|t| t.map(corner)).collect(),
    })
}

fn file_bytes(input: &WriteInput<'_>, task: &Task) -> u64 {
    let patch_bytes = |holes: &[u32]| -> u64 {
        let patches = holes.iter().filter_map(|h| input.fills.get(h)?.as_ref().ok());
        patches
            .map(|f| 24 * (f.rim.len() + f.patch.vertices.len()) + 16 * f.patch.triangles.len())
            .sum::<usize>() as u64
    };
    match task {
        Task::Append { part, holes, .. } => part.bytes + patch_bytes(holes),
        Task::New { holes, .. } => patch_bytes(holes),
        Task::Copy { bytes, .. } => *bytes,
    }
}

/// Memory of a task: a tile that gets patches is held once whole, with its patches as text or rows; a copy streams.
fn task_bytes(input: &WriteInput<'_>, task: &Task) -> u64 {
    match task {
        Task::Copy { .. } => 1 << 20,
        _ => 2 * file_bytes(input, task) + (1 << 20),
    }
}

fn perform(input: &WriteInput<'_>, task: &Task, context: &Context<'_>) -> Result<Vec<OutputFile>, TileError> {
    match task {
        Task::Append { part, holes, .. } => {
            let entry = &input.scene.tiles[part.tile];
            let patches: Vec<HolePatch> =
                holes.iter().filter_map(|&h| hole_patch(input, h, Some(part))).collect();
            let output = place(input, &entry.relative)?;
            let written = append_patches(&AppendRequest {
                input: &input.scene.path(entry),
                output: &output,
                format: entry.format,
                options: &context.read_options,
                expected_hash: Some(part.hash),
                patches: &patches,
            })?;
            listed(&entry.relative, &output, &written)
        }
        Task::New { template, relative, holes, .. } => {
            let entry = &input.scene.tiles[*template];
            let patches: Vec<HolePatch> = holes.iter().filter_map(|&h| hole_patch(input, h, None)).collect();
            let output = place(input, relative)?;
            let written = new_tile(&NewTileRequest {
                template: &input.scene.path(entry),
                output: &output,
                format: entry.format,
                options: &context.read_options,
                patches: &patches,
            })?;
            listed(relative, &output, &written)
        }
        Task::Copy { relative, .. } => {
            let output = place(input, relative)?;
            let mode = match context.settings.scene.untouched {
                Untouched::Reflink => CopyMode::Reflink,
                _ => CopyMode::Copy,
            };
            let copied = copy_file(&input.scene.root.join(relative), &output, mode, Hashing::Yes)?;
            Ok(vec![OutputFile {
                path: relative.clone(),
                bytes: copied.bytes,
                blake3: copied.hash.map_or_else(String::new, |h| hex(&h)),
                changed: false,
            }])
        }
    }
}

/// The output path of a file of the scene, with its folder made.
fn place(input: &WriteInput<'_>, relative: &str) -> Result<std::path::PathBuf, TileError> {
    let io =
        |path: &Path, source| TileError::Io { path: path.to_owned(), operation: "make the folder", source };
    let path = output_path(input.out, relative)
        .map_err(|e| io(input.out, std::io::Error::new(std::io::ErrorKind::InvalidInput, e.to_string())))?;
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| io(folder, e))?;
    }
    Ok(path)
}

/// The written tile and its side files as the manifest lists them.
fn listed(
    relative: &str,
    output: &Path,
    written: &lacuna_tile::Written,
) -> Result<Vec<OutputFile>, TileError> {
    let tile = OutputFile {
        path: relative.to_owned(),
        bytes: written.bytes,
        blake3: hex(&written.hash),
        changed: true,
    };
    let mut files = vec![tile];
    let folder = relative.rsplit_once('/').map(|(folder, _)| format!("{folder}/")).unwrap_or_default();
    for name in &written.side_files {
        let path = output.with_file_name(name);
        let bytes = std::fs::read(&path).map_err(|source| TileError::Io {
            path: path.clone(),
            operation: "read",
            source,
        })?;
        files.push(OutputFile {
            path: format!("{folder}{name}"),
            bytes: bytes.len() as u64,
            blake3: hex(blake3::hash(&bytes).as_bytes()),
            changed: true,
        });
    }
    Ok(files)
}

/// Lower-case hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}
