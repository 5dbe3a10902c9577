//! One changed cell: its files against the delivered ones, its patches, what its neighbours must know.

use super::accounts::check_marks;
use super::files::Files;
use super::holes_left::{FilledHole, check_filled};
use super::islands::check_islands;
use super::layout::{Layout, append, median};
use super::originals::{Mark, compare};
use super::overlap::CellStrips;
use super::patch_mesh::{CellMesh, ORIGINAL, PatchEdges};
use super::patches::{PatchCheck, check_patches};
use super::records::Records;
use super::seams::CellBorder;
use super::verdict::Findings;
use crate::report::{HoleRecord, Outcome};
use glam::DVec3;
use lacuna_grid::{CellId, Domain, Side};
use lacuna_hole::BorderMode;
use lacuna_mesh::{TriMesh, boundary, position_bits};
use lacuna_tile::{NumberType, ReadOptions, ReadTile, Scene, TileFormat, VertexFrame, read_tile};
use std::path::Path;

/// What all cells are checked against.
pub(super) struct Context<'a> {
    pub(super) scene: &'a Scene,
    pub(super) out: &'a Path,
    pub(super) files: &'a Files,
    pub(super) records: &'a Records,
    pub(super) layout: &'a Layout,
    pub(super) options: &'a ReadOptions,
}

/// A cell with at least one changed file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ChangedCell {
    pub(super) cell: CellId,
    /// The tile's name.
    pub(super) tile: String,
    /// Its files, relative to OUT.
    pub(super) parts: Vec<(String, TileFormat)>,
}

/// What the check of a cell finds, by promise, and what its neighbours need.
#[derive(Debug, Default)]
pub(super) struct CellFindings {
    pub(super) originals: Findings,
    pub(super) patches: Findings,
    pub(super) holes_left: Findings,
    pub(super) marks: Findings,
    pub(super) border: CellBorder,
    pub(super) strips: CellStrips,
}

/// The final mesh of a cell and the marks in its files.
#[derive(Default)]
struct Loaded {
    cell: CellMesh,
    marks: Vec<Mark>,
    last_place_m: f64,
}

/// Checks one cell.
pub(super) fn check_cell(context: &Context<'_>, changed: &ChangedCell) -> CellFindings {
    let mut found = CellFindings::default();
    found.originals.count("changed tiles", 1);
    let mut loaded = Loaded::default();
    for (relative, format) in &changed.parts {
        load_part(context, relative, *format, &mut loaded, &mut found);
    }
    let Loaded { cell, marks, last_place_m } = loaded;
    let holes: Vec<&HoleRecord> =
        context.records.report.holes.iter().filter(|h| h.cell == [changed.cell.i, changed.cell.j]).collect();
    found.marks = check_marks(&changed.tile, &holes, &marks, cell.patch_triangles().count() as u64);
    check_geometry(context, changed, &cell, &holes, &mut found);
    found.border.last_place_m = last_place_m;
    found
}

fn check_geometry(
    context: &Context<'_>,
    changed: &ChangedCell,
    cell: &CellMesh,
    holes: &[&HoleRecord],
    found: &mut CellFindings,
) {
    let layout = context.layout;
    let domain = layout.domain(changed.cell);
    let boundary = boundary(&cell.mesh);
    let edges = PatchEdges::new(cell);
    let filled: Vec<FilledHole<'_>> = holes
        .iter()
        .filter(|h| h.outcome == Outcome::Filled)
        .filter_map(|h| Some(FilledHole { id: &h.id, outline: context.records.outlines.get(&h.id)? }))
        .collect();
    let is_ragged = layout.fit.mode == BorderMode::Ragged;
    let inset_m = if is_ragged { layout.tolerance_m() } else { 0.0 };
    let (holes_left, is_open) = check_filled(&changed.tile, &filled, cell, &boundary, inset_m);
    found.holes_left = holes_left;
    let check = PatchCheck {
        tile: &changed.tile,
        cell,
        edges: &edges,
        boundary: &boundary,
        is_open: &is_open,
        domain: &domain,
        tolerance_m: layout.tolerance_m(),
        is_ragged,
    };
    found.patches.take(check_patches(&check));
    let islands: Vec<_> =
        filled.iter().filter_map(|hole| Some((hole.id, context.records.islands.get(hole.id)?))).collect();
    found.patches.take(check_islands(&changed.tile, &islands, cell, &boundary));
    for hole in holes {
        let passed = context.records.islands.get(&hole.id).map_or(0, |i| i.passed_under.len() as u64);
        if passed != hole.islands_passed_under {
            found.marks.offend(format!(
                "{} ({}): the report counts {} islands passed under, the map holds {passed}",
                changed.tile, hole.id, hole.islands_passed_under
            ));
        }
    }
    found.border.tile.clone_from(&changed.tile);
    found.border.edges = layout.border_edges(changed.cell, &boundary, |face| cell.owner[face] != ORIGINAL);
    if layout.fit.mode == BorderMode::Overrun {
        found.strips = strips(&changed.tile, cell, &edges, &domain, layout.fit.margin_m);
    }
}

/// Reads one file and, if it was delivered, the delivered one; compares their bytes; adds its mesh.
fn load_part(
    context: &Context<'_>,
    relative: &str,
    format: TileFormat,
    loaded: &mut Loaded,
    found: &mut CellFindings,
) {
    let is_delivered = context.files.scene.contains_key(relative);
    let is_changed = context.files.is_changed(relative);
    let (now_path, then_path) = (context.out.join(relative), context.scene.root.join(relative));
    // A file that an untouched tile was left out of OUT for is the delivered one.
    let path = if context.files.out.contains_key(relative) { &now_path } else { &then_path };
    let now = match read_tile(path, format, context.options) {
        Ok(read) => read,
        Err(error) if is_changed => {
            return found.patches.offend(format!("{relative}: cannot be read: {error}"));
        }
        Err(_) => return,
    };
    if !is_changed {
        return loaded.add(now, &[], |_| false);
    }
    let then = match is_delivered.then(|| read_tile(&then_path, format, context.options)).transpose() {
        Ok(then) => then,
        Err(error) => return found.originals.offend(format!("{relative}: as delivered: {error}")),
    };
    let marks = compare_bytes(relative, format, is_delivered.then_some(&*then_path), &now_path, found);
    let delivered = then.as_ref().map(|t| &t.mesh);
    check_finite(relative, delivered, &now.mesh, found);
    let is_patch = patch_triangles(format, delivered, &now.mesh);
    loaded.add(now, &marks, |t| is_patch[t]);
    loaded.marks.extend(marks);
}

fn compare_bytes(
    relative: &str,
    format: TileFormat,
    then: Option<&Path>,
    now: &Path,
    found: &mut CellFindings,
) -> Vec<Mark> {
    let read = |path: &Path| std::fs::read(path).map_err(|e| format!("{relative}: cannot be read: {e}"));
    let bytes = then.map(read).transpose().and_then(|then| Ok((then, read(now)?)));
    let (then, now) = match bytes {
        Ok(bytes) => bytes,
        Err(problem) => {
            found.originals.offend(problem);
            return Vec::new();
        }
    };
    let comparison = compare(format, then.as_deref(), &now);
    comparison.problems.iter().for_each(|p| found.originals.offend(format!("{relative}: {p}")));
    comparison.marks
}

fn check_finite(relative: &str, then: Option<&TriMesh>, now: &TriMesh, found: &mut CellFindings) {
    let broken = |mesh: &TriMesh| mesh.positions.iter().filter(|p| !p.is_finite()).count();
    let (before, after) = (then.map_or(0, broken), broken(now));
    if after > before {
        found.patches.offend(format!("{relative}: {} new vertices are not finite", after - before));
    }
}

/// Which triangles were not delivered. PLY and OBJ hold the delivered ones first; in GLB the patches stand between the
/// meshes, so the delivered triangles are looked for in their order.
fn patch_triangles(format: TileFormat, then: Option<&TriMesh>, now: &TriMesh) -> Vec<bool> {
    let count = then.map_or(0, |t| t.triangles.len());
    let (Some(then), TileFormat::Glb) = (then, format) else {
        return (0..now.triangles.len()).map(|t| t >= count).collect();
    };
    let bits = |mesh: &TriMesh, t: usize| mesh.corners(t).map(position_bits);
    let mut next = 0;
    let is_delivered = |t: usize| {
        let same = next < count && bits(then, next) == bits(now, t);
        next += usize::from(same);
        same
    };
    (0..now.triangles.len()).map(is_delivered).map(|delivered| !delivered).collect()
}

impl Loaded {
    /// Adds a file's mesh. Its patch triangles belong to the marks in their order, if the marks count as many.
    fn add(&mut self, read: ReadTile, marks: &[Mark], is_patch: impl Fn(usize) -> bool) {
        let count = read.mesh.triangles.len();
        let patches = (0..count).filter(|&t| is_patch(t)).count() as u64;
        let first = self.cell.holes.len() as u32;
        let is_complete = marks.iter().map(|m| m.triangles).sum::<u64>() == patches;
        let mut owners: Vec<u32> = Vec::new();
        if is_complete {
            for (k, mark) in marks.iter().enumerate() {
                owners.extend(std::iter::repeat_n(first + k as u32, mark.triangles as usize));
                self.cell.holes.push(Some(mark.hole.clone()));
            }
        } else {
            owners = vec![first; patches as usize];
            self.cell.holes.push(None);
        }
        let mut owners = owners.into_iter();
        let owner = |t: usize| if is_patch(t) { owners.next().unwrap_or(first) } else { ORIGINAL };
        self.cell.owner.extend((0..count).map(owner));
        self.last_place_m = self.last_place_m.max(last_place_m(&read.frame, &read.mesh));
        append(&mut self.cell.mesh, read.mesh);
    }
}

/// One unit in the last place of the largest stored coordinate, metres; 0 where the file stores scene coordinates.
fn last_place_m(frame: &VertexFrame, mesh: &TriMesh) -> f64 {
    if frame.number != NumberType::F32 || frame.to_scene == glam::DAffine3::IDENTITY {
        return 0.0;
    }
    let finite = mesh.positions.iter().filter(|p| p.is_finite());
    let largest = finite.map(|p| frame.to_file(*p).abs().max_element()).fold(0.0, f64::max);
    let scale = frame.to_scene.matrix3.x_axis.length();
    2.0 * largest * f64::from(f32::EPSILON) * scale
}

/// Patch triangles in the strips that overrunning neighbours share, and the rims near them.
fn strips(tile: &str, cell: &CellMesh, edges: &PatchEdges, domain: &Domain, margin_m: f64) -> CellStrips {
    let reach = 3.0 * margin_m;
    let inside = |p: &DVec3| {
        Side::ALL.iter().map(|s| -domain.outside_m(*s, p.truncate())).fold(f64::INFINITY, f64::min)
    };
    let all = cell.patch_triangles().map(|t| cell.mesh.corners(t));
    let rims: Vec<[DVec3; 2]> =
        edges.rims().map(|uses| [uses[0].low, uses[0].high].map(|v| edges.positions[v as usize])).collect();
    let mut lengths: Vec<f64> = rims.iter().map(|[a, b]| a.distance(*b)).collect();
    let rim_edge_m = median(&mut lengths);
    CellStrips {
        tile: tile.to_owned(),
        triangles: all.filter(|t| t.iter().any(|p| inside(p) <= reach)).collect(),
        rim: rims
            .iter()
            .flatten()
            .filter(|p| inside(p) <= reach + 3.0 * rim_edge_m)
            .map(|p| p.truncate())
            .collect(),
        rim_edge_m,
    }
}
