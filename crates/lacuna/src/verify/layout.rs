//! Where the cells are, judged from the delivered tiles: grid, reconstruction area, border mode, boundaries.

use super::patch_mesh::CellMesh;
use super::records::Records;
use super::seams::BorderEdge;
use super::work::Work;
use crate::geometry::box_near_cell;
use crate::report::Report;
use crate::{ExitCode, RunError};
use glam::DVec2;
use lacuna_grid::{Area, CellId, Domain, Grid, GridHints, Side, SideLabel, TileBox, infer_grid};
use lacuna_hole::{BorderFit, BorderMode, CellSurvey, Surveys, fit_borders, share_borders};
use lacuna_mesh::{Band, Boundary, Bounds, Fans, TriMesh, boundary};
use lacuna_tile::{ReadOptions, Scene, TileGroup, UpAxis, read_tile};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The scene as it was delivered.
pub(super) struct Layout {
    pub(super) grid: Grid,
    pub(super) area: Area,
    pub(super) fit: BorderFit,
    /// Group of the scene for each cell that has a readable tile.
    pub(super) groups: BTreeMap<CellId, usize>,
    /// Cells whose tile cannot be read.
    pub(super) unreadable: BTreeSet<CellId>,
    /// Boundaries as delivered.
    surveys: Surveys,
}

impl Layout {
    /// Reads every delivered tile once; only its boundary stays.
    pub(super) fn read(
        scene: &Scene,
        out: &Path,
        records: &Records,
        options: &ReadOptions,
        work: &Work<'_>,
    ) -> Result<Self, RunError> {
        let groups = &scene.groups;
        let surveys = work.each(
            groups.len(),
            |g| group_bytes(scene, &groups[g]),
            |g| survey(scene, &groups[g], options),
        )?;
        let read: Vec<(usize, CellSurvey)> =
            surveys.into_iter().enumerate().filter_map(|(g, s)| Some((g, s?))).collect();
        let (grid, cells) = find_grid(scene, &read, &records.report)?;
        let bad: BTreeSet<usize> = (0..groups.len()).filter(|g| read.iter().all(|(r, _)| r != g)).collect();
        let unreadable =
            bad.iter().filter_map(|&g| groups[g].index).map(|(i, j)| CellId::new(i, j)).collect();
        let mut bounds = Bounds::EMPTY;
        let (mut surveys, mut by_cell) = (Surveys::new(), BTreeMap::new());
        for ((group, mut survey), cell) in read.into_iter().zip(cells) {
            let Some(cell) = cell else { continue };
            bounds = bounds.union(&box_near_cell(&survey.bounds, &grid, cell));
            survey.cell = cell;
            by_cell.insert(cell, group);
            surveys.insert(cell, survey);
        }
        let present = by_cell.keys().chain(&unreadable).copied().collect();
        let area = find_area(&present, &grid, &bounds, out, &records.report);
        let fit = fit_borders(&surveys, &grid);
        Ok(Self { grid, area, fit, groups: by_cell, unreadable, surveys })
    }

    /// What lies this near to a border's line lies on it, metres.
    pub(super) fn tolerance_m(&self) -> f64 {
        self.fit.tolerance_m.max(0.002)
    }

    /// The rectangle of a cell.
    pub(super) fn domain(&self, cell: CellId) -> Domain {
        Domain::new(&self.grid, &self.area, cell, self.fit.margin_m)
    }

    /// True if a place lies on the area's border, as one of its cells sees it.
    pub(super) fn is_outer(&self, cell: CellId, place: DVec2) -> bool {
        let domain = self.domain(cell);
        let is_near = |s: Side| domain.outside_m(s, place) >= -self.tolerance_m();
        Side::ALL.into_iter().any(|s| domain.side(s).label == SideLabel::External && is_near(s))
    }

    /// How far beside each other the borders of ragged tiles run that share no vertices; `None` if they share them.
    pub(super) fn stub_reach_m(&self) -> Option<f64> {
        let share = share_borders(&self.surveys, &self.grid, &self.area, &self.fit);
        (!share).then_some(2.0 * self.fit.tolerance_m)
    }

    /// Boundary edges of a delivered tile near its borders.
    pub(super) fn delivered_border(&self, cell: CellId) -> Vec<BorderEdge> {
        let Some(survey) = self.surveys.get(&cell) else { return Vec::new() };
        self.border_edges(cell, &survey.boundary, |_| false)
    }

    /// Boundary edges near the cell's borders; all of ragged tiles; in overrun mode they are not needed.
    pub(super) fn border_edges(
        &self,
        cell: CellId,
        boundary: &Boundary,
        is_patch: impl Fn(usize) -> bool,
    ) -> Vec<BorderEdge> {
        if self.fit.mode == BorderMode::Overrun {
            return Vec::new();
        }
        let domain = self.domain(cell);
        let reach = self.tolerance_m();
        let near = |p: DVec2| Side::ALL.iter().any(|s| domain.outside_m(*s, p).abs() <= reach);
        let edges = boundary.edges.iter().map(|e| BorderEdge {
            from: boundary.position(e.from),
            to: boundary.position(e.to),
            is_patch: is_patch(e.face.index()),
        });
        let is_ragged = self.fit.mode == BorderMode::Ragged;
        edges.filter(|e| is_ragged || near(e.from.truncate()) && near(e.to.truncate())).collect()
    }
}

/// How tiles are read: with the up axis of the run.
pub(super) fn read_options(report: &Report) -> ReadOptions {
    let up_axis = match report.configuration["scene"]["up_axis"].as_str() {
        Some("y") => Some(UpAxis::Y),
        Some("z") => Some(UpAxis::Z),
        _ => None,
    };
    ReadOptions { up_axis, skip_hash: true, ..ReadOptions::default() }
}

/// What reading the files of a tile and finding its boundary takes.
pub(super) fn group_bytes(scene: &Scene, group: &TileGroup) -> u64 {
    let need = |p: &usize| match &scene.tiles[*p].header {
        Ok(h) => h.bytes + 56 * h.vertices + 24 * h.triangles,
        Err(_) => 0,
    };
    group.parts.iter().map(need).sum::<u64>() + (1 << 20)
}

/// Box and boundary of a tile; `None` if a file of it cannot be read, or no vertex has a place.
fn survey(scene: &Scene, group: &TileGroup, options: &ReadOptions) -> Option<CellSurvey> {
    let mut cell = CellMesh::default();
    for &part in &group.parts {
        let entry = &scene.tiles[part];
        let read = read_tile(&scene.path(entry), entry.format, options).ok()?;
        append(&mut cell.mesh, read.mesh);
    }
    if !cell.mesh.positions.is_empty() && !cell.mesh.positions.iter().any(|p| p.is_finite()) {
        return None;
    }
    let boundary = boundary(&cell.mesh);
    let mut bounds = Bounds::EMPTY;
    cell.mesh.positions.iter().filter(|p| p.is_finite()).for_each(|p| bounds.add(*p));
    let mut lengths: Vec<f64> =
        boundary.edges.iter().map(|e| boundary.position(e.from).distance(boundary.position(e.to))).collect();
    Some(CellSurvey {
        cell: CellId::new(0, 0),
        bounds,
        vertices: cell.mesh.positions.len() as u64,
        triangles: cell.mesh.triangles.len() as u64,
        boundary: Boundary { copies: Vec::new(), ..boundary },
        loops: Vec::new(),
        spacing_m: Vec::new(),
        components: Vec::new(),
        band: Band::default(),
        fans: Fans::default(),
        median_edge_m: median(&mut lengths),
    })
}

/// The upper median; 0 of nothing.
pub(super) fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Puts another file's mesh behind a mesh.
pub(super) fn append(mesh: &mut TriMesh, other: TriMesh) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(other.positions);
    mesh.triangles.extend(other.triangles.into_iter().map(|t| t.map(|v| v + first)));
}

fn find_grid(
    scene: &Scene,
    read: &[(usize, CellSurvey)],
    report: &Report,
) -> Result<(Grid, Vec<Option<CellId>>), RunError> {
    let boxes: Vec<TileBox> = read
        .iter()
        .map(|(group, survey)| {
            let group = &scene.groups[*group];
            TileBox {
                name: group.name.clone(),
                index: group.index,
                signed: group.index_is_signed,
                low: survey.bounds.min.truncate(),
                high: survey.bounds.max.truncate(),
            }
        })
        .collect();
    let asked = &report.configuration["scene"];
    let origin = asked["cell_origin_m"]
        .as_array()
        .and_then(|o| Some(DVec2::new(o.first()?.as_f64()?, o.get(1)?.as_f64()?)));
    let hints = GridHints { cell_size_m: asked["cell_size_m"].as_f64(), origin };
    let found = infer_grid(&boxes, hints)
        .map_err(|e| RunError { exit: ExitCode::Failed, message: format!("the scene has no grid: {e}") })?;
    Ok((found.grid, found.cells))
}

/// The area that the run was asked for; for polygons the cells that the run's map shows.
fn find_area(present: &BTreeSet<CellId>, grid: &Grid, bounds: &Bounds, out: &Path, report: &Report) -> Area {
    match report.configuration["area"]["limit"].as_str() {
        Some("box") => Area::of_box(present, grid, bounds.min.truncate(), bounds.max.truncate()),
        Some("cells") | None if !report.configuration["area"]["limit"].is_object() => Area::of_cells(present),
        _ => {
            let mut area = Area::of_cells(present);
            area.cells.extend(cells_of_map(out));
            area
        }
    }
}

fn cells_of_map(out: &Path) -> Vec<CellId> {
    let text = std::fs::read(out.join(super::records::OWN_FOLDER).join("cells.geojson")).unwrap_or_default();
    let map: Value = serde_json::from_slice(&text).unwrap_or_default();
    let cell = |feature: &Value| {
        let index = &feature["properties"]["cell"];
        Some(CellId::new(i32::try_from(index[0].as_i64()?).ok()?, i32::try_from(index[1].as_i64()?).ok()?))
    };
    map["features"].as_array().map_or_else(Vec::new, |all| all.iter().filter_map(cell).collect())
}
