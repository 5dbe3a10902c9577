//! The reconstruction area: which cells belong to the scene, and which sides lie on its edge.

use crate::{CellId, Side};
use glam::DVec2;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

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

/// Missing cells of one row between two present ones.
struct Gap {
    j: i32,
    first: i32,
    last: i32,
}

/// Missing cells that the present ones enclose: no walk over missing cells leads from them out of the scene.
///
/// Works on gaps, not on cells, so that two tiles far apart cost no more than two tiles. Steps: the gaps of every row; a
/// gap is open if the row above or below has no tile over a part of it that lies outside of that row's tiles; what
/// touches an open gap is open.
fn enclosed(present: &BTreeSet<CellId>) -> Vec<CellId> {
    let mut rows: BTreeMap<i32, Vec<i32>> = BTreeMap::new();
    present.iter().for_each(|c| rows.entry(c.j).or_default().push(c.i));
    let mut gaps: Vec<Gap> = Vec::new();
    let mut first_of_row: BTreeMap<i32, Range<usize>> = BTreeMap::new();
    for (&j, columns) in &rows {
        let start = gaps.len();
        let pairs = columns.windows(2).filter(|p| p[1] - p[0] > 1);
        gaps.extend(pairs.map(|p| Gap { j, first: p[0] + 1, last: p[1] - 1 }));
        first_of_row.insert(j, start..gaps.len());
    }
    let is_open = |gap: &Gap| {
        [gap.j - 1, gap.j + 1].iter().any(|j| match rows.get(j).and_then(|r| r.first().zip(r.last())) {
            Some((west, east)) => gap.first < *west || gap.last > *east,
            None => true,
        })
    };
    let mut open: Vec<bool> = gaps.iter().map(is_open).collect();
    let mut stack: Vec<usize> = (0..gaps.len()).filter(|&g| open[g]).collect();
    while let Some(g) = stack.pop() {
        for j in [gaps[g].j - 1, gaps[g].j + 1] {
            let row = first_of_row.get(&j).cloned().unwrap_or(0..0);
            let before = gaps[row.clone()].partition_point(|other| other.last < gaps[g].first);
            for other in row.start + before..row.end {
                if gaps[other].first > gaps[g].last {
                    break;
                }
                if !std::mem::replace(&mut open[other], true) {
                    stack.push(other);
                }
            }
        }
    }
    let closed = gaps.iter().zip(&open).filter(|(_, open)| !**open).map(|(gap, _)| gap);
    closed.flat_map(|gap| (gap.first..=gap.last).map(|i| CellId::new(i, gap.j))).collect()
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
            ("a tile alone above a gap of one cell", vec![".#.", "#.#", "###"], 1),
            ("a tile alone above a gap of two cells", vec![".#..", "#..#", "####"], 0),
            ("a spiral is open", vec!["#####", "#...#", "#.#.#", "#.###", "#...."], 0),
            ("a closed spiral", vec!["#####", "#...#", "#.#.#", "#.###", "#####"], 6),
            ("an island in a lake", vec!["#####", "#...#", "#.#.#", "#...#", "#####"], 8),
        ] {
            let present = cells(&rows);
            assert_eq!(Area::of_cells(&present).cells.len() - present.len(), missing, "{name}");
        }
    }

    #[test]
    fn tiles_far_apart_enclose_nothing_and_cost_nothing() {
        let far = 1 << 29;
        let present = [(0, 0), (far, 0), (0, far), (-far, far)].map(|(i, j)| CellId::new(i, j));
        let present = BTreeSet::from(present);
        assert_eq!(Area::of_cells(&present).cells, present);
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
