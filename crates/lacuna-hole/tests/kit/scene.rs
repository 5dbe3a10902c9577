//! A scene of meshes, and the way from it to a plan.

use glam::DVec2;
use lacuna_grid::{Area, AreaLimit, CellId, Grid};
use lacuna_hole::{ClusterRule, Plan, PlanOptions, Surveys, fit_borders, plan, survey};
use lacuna_mesh::TriMesh;
use std::collections::{BTreeMap, BTreeSet};

/// How far the area reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Limit {
    /// Whole cells.
    Cells,
    /// The box of all vertices.
    Box,
    /// A polygon: the rectangle west, south, east, north.
    Rectangle([f64; 4]),
}

/// Meshes on a grid.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) grid: Grid,
    pub(crate) tiles: BTreeMap<CellId, TriMesh>,
    /// Plan area of what was taken out of a full scene, square metres.
    pub(crate) removed_m2: f64,
    pub(crate) limit: Limit,
    pub(crate) rule: ClusterRule,
    pub(crate) unreadable: BTreeSet<CellId>,
}

/// A scene's surveys and plan.
pub(crate) struct Planned {
    pub(crate) surveys: Surveys,
    pub(crate) plan: Plan,
}

impl Scene {
    pub(crate) fn new(grid: Grid, tiles: BTreeMap<CellId, TriMesh>) -> Self {
        Self {
            grid,
            tiles,
            removed_m2: 0.0,
            limit: Limit::Cells,
            rule: ClusterRule::Interval,
            unreadable: BTreeSet::new(),
        }
    }

    /// The mesh of a cell that has a tile.
    pub(crate) fn tile(&mut self, i: i32, j: i32) -> &mut TriMesh {
        self.tiles.get_mut(&CellId::new(i, j)).expect("a cell with a tile")
    }

    /// Survey, borders, plan.
    pub(crate) fn plan(&self) -> Planned {
        let surveys: Surveys = self.tiles.iter().map(|(&c, mesh)| (c, survey(c, mesh))).collect();
        let fit = fit_borders(&surveys, &self.grid);
        let options = PlanOptions {
            grid: self.grid,
            area: self.area(),
            fit,
            rule: self.rule,
            unreadable: self.unreadable.clone(),
        };
        let plan = plan(&surveys, &options);
        Planned { surveys, plan }
    }

    fn area(&self) -> Area {
        let mut present: BTreeSet<CellId> = self.tiles.keys().copied().collect();
        present.extend(&self.unreadable);
        match self.limit {
            Limit::Cells => Area::of_cells(&present),
            Limit::Rectangle([west, south, east, north]) => {
                let corners = [(west, south), (east, south), (east, north), (west, north)];
                let ring = corners.map(DVec2::from).to_vec();
                Area { limit: AreaLimit::Polygon(vec![ring]), ..Area::of_cells(&present) }
            }
            Limit::Box => {
                let (low, high) = self.bounds();
                Area::of_box(&present, &self.grid, low, high)
            }
        }
    }

    /// The box of all vertices in plan.
    pub(crate) fn bounds(&self) -> (DVec2, DVec2) {
        let vertices = self.tiles.values().flat_map(|t| &t.positions).map(|p| p.truncate());
        vertices.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)))
    }
}

/// Adds one mesh to another, sharing nothing.
pub(crate) fn append(mesh: &mut TriMesh, other: TriMesh) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(other.positions);
    mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
}
