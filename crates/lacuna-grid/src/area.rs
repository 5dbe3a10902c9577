//! The reconstruction area: which cells belong to the scene, and which sides lie on its edge.

use crate::{CellId, Side};
use glam::DVec2;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// How far the area reaches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum AreaLimit {
    /// Whole cells.
    Cells,
    /// An axis-parallel rectangle: south-west and north-east corner.
    Box(DVec2, DVec2),
    /// Simple polygons (outer rings counter-clockwise, holes are rings of their own, even-odd).
    Polygon(Vec<Vec<DVec2>>),
}

/// The reconstruction area: a set of cells and a limit inside them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Area {
    /// Cells that belong to the area, missing ones that it encloses or covers included.
    pub cells: BTreeSet<CellId>,
    /// The limit inside these cells.
    pub limit: AreaLimit,
}

impl Area {
    /// The cells that have tiles, and the missing cells that they enclose: those that are not 4-connected to the
    /// unbounded exterior through missing cells.
    #[must_use]
    pub fn of_cells(present: &BTreeSet<CellId>) -> Self {
        let mut cells = present.clone();
        cells.extend(enclosed(present));
        Self { cells, limit: AreaLimit::Cells }
    }

    /// All cells that share inner points with a rectangle, and those that have tiles.
    #[must_use]
    pub fn of_box(present: &BTreeSet<CellId>, grid: &crate::Grid, low: DVec2, high: DVec2) -> Self {
        let tolerance = 1e-6 * grid.cell_size_m;
        let first = grid.cell_at(low + tolerance);
        let last = grid.cell_at(high - tolerance);
        let mut cells = present.clone();
        for j in first.j..=last.j {
            cells.extend((first.i..=last.i).map(|i| CellId::new(i, j)));
        }
        Self { cells, limit: AreaLimit::Box(low, high) }
    }

    /// True if the cell belongs to the area.
    #[must_use]
    pub fn contains(&self, cell: CellId) -> bool {
        self.cells.contains(&cell)
    }

    /// True if nothing of the area lies beyond this side.
    #[must_use]
    pub fn is_edge(&self, cell: CellId, side: Side) -> bool {
        !self.contains(cell.neighbour(side))
    }
}

/// Missing cells that the present ones enclose.
fn enclosed(present: &BTreeSet<CellId>) -> BTreeSet<CellId> {
    let (Some(first), Some(last)) = (present.first(), present.last()) else { return BTreeSet::new() };
    let (j0, j1) = (first.j - 1, last.j + 1);
    let i0 = present.iter().map(|c| c.i).min().unwrap_or(0) - 1;
    let i1 = present.iter().map(|c| c.i).max().unwrap_or(0) + 1;
    let mut outside = BTreeSet::from([CellId::new(i0, j0)]);
    let mut stack = vec![CellId::new(i0, j0)];
    while let Some(cell) = stack.pop() {
        for next in Side::ALL.map(|s| cell.neighbour(s)) {
            let inside_frame = (i0..=i1).contains(&next.i) && (j0..=j1).contains(&next.j);
            if inside_frame && !present.contains(&next) && outside.insert(next) {
                stack.push(next);
            }
        }
    }
    let all = (j0..=j1).flat_map(|j| (i0..=i1).map(move |i| CellId::new(i, j)));
    all.filter(|c| !present.contains(c) && !outside.contains(c)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(rows: &[&str]) -> BTreeSet<CellId> {
        let mut set = BTreeSet::new();
        for (j, row) in rows.iter().rev().enumerate() {
            for (i, c) in row.chars().enumerate() {
                if c == '#' {
                    set.insert(CellId::new(i as i32, j as i32));
                }
            }
        }
        set
    }

    #[test]
    fn enclosed_missing_cells_count_in() {
        for (name, rows, missing) in [
            ("ring", vec!["###", "#.#", "###"], 1),
            ("open ring", vec!["###", "#..", "###"], 0),
            ("diagonal gap is closed", vec!["##.", "#.#", "###"], 1),
            ("two lakes", vec!["#####", "#.#.#", "#####"], 2),
            ("none", vec!["##", "##"], 0),
        ] {
            let present = cells(&rows);
            assert_eq!(Area::of_cells(&present).cells.len() - present.len(), missing, "{name}");
        }
    }

    #[test]
    fn a_box_takes_cells_it_touches_inside() {
        let grid = crate::Grid { origin: DVec2::ZERO, cell_size_m: 10.0 };
        let area = Area::of_box(&BTreeSet::new(), &grid, DVec2::new(0.0, 5.0), DVec2::new(20.0, 10.0));
        assert_eq!(area.cells, BTreeSet::from([CellId::new(0, 0), CellId::new(1, 0)]));
        assert!(area.is_edge(CellId::new(0, 0), Side::West));
        assert!(!area.is_edge(CellId::new(0, 0), Side::East));
    }
}
