//! Cells, their sides, and the borders and corners they share.

use glam::DVec2;
use serde::{Deserialize, Serialize};
use std::fmt;

/// One square of the grid: column `i` (east), row `j` (north).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct CellId {
    /// Row, growing north. First in the order, so that sorted cells run row by row.
    pub j: i32,
    /// Column, growing east.
    pub i: i32,
}

impl CellId {
    /// The cell of column `i` and row `j`.
    #[must_use]
    pub fn new(i: i32, j: i32) -> Self {
        Self { j, i }
    }

    /// The cell beyond one side.
    #[must_use]
    pub fn neighbour(self, side: Side) -> Self {
        let (di, dj) = side.step();
        Self::new(self.i + di, self.j + dj)
    }

    /// The border on one side; both cells of a border name the same one.
    #[must_use]
    pub fn border(self, side: Side) -> BorderId {
        match side {
            Side::South | Side::West => BorderId { cell: self, side },
            Side::North => BorderId { cell: self.neighbour(side), side: Side::South },
            Side::East => BorderId { cell: self.neighbour(side), side: Side::West },
        }
    }

    /// The grid corner where `side` ends (walking counter-clockwise).
    #[must_use]
    pub fn corner_after(self, side: Side) -> CornerId {
        let (di, dj) = match side {
            Side::South => (1, 0),
            Side::East => (1, 1),
            Side::North => (0, 1),
            Side::West => (0, 0),
        };
        CornerId { j: self.j + dj, i: self.i + di }
    }
}

impl fmt::Display for CellId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cell {},{}", self.i, self.j)
    }
}

impl fmt::Debug for CellId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// A side of a cell, counter-clockwise from the south.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Side {
    /// Lowest y.
    South,
    /// Highest x.
    East,
    /// Highest y.
    North,
    /// Lowest x.
    West,
}

impl Side {
    /// All four, counter-clockwise.
    pub const ALL: [Self; 4] = [Self::South, Self::East, Self::North, Self::West];

    /// Position in `ALL`.
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }

    /// The side that the neighbour sees.
    #[must_use]
    pub fn opposite(self) -> Self {
        Self::ALL[(self.index() + 2) % 4]
    }

    /// Column and row step to the neighbour.
    #[must_use]
    pub fn step(self) -> (i32, i32) {
        match self {
            Self::South => (0, -1),
            Self::East => (1, 0),
            Self::North => (0, 1),
            Self::West => (-1, 0),
        }
    }

    /// Unit vector that points out of the cell.
    #[must_use]
    pub fn outward(self) -> DVec2 {
        let (dx, dy) = self.step();
        DVec2::new(f64::from(dx), f64::from(dy))
    }

    /// True for south and north, whose coordinate along the side is x.
    #[must_use]
    pub fn is_horizontal(self) -> bool {
        matches!(self, Self::South | Self::North)
    }

    /// Coordinate of `point` along the side: x on south and north, y on east and west.
    #[must_use]
    pub fn along(self, point: DVec2) -> f64 {
        if self.is_horizontal() { point.x } else { point.y }
    }

    /// Coordinate of `point` across the side: y on south and north, x on east and west.
    #[must_use]
    pub fn across(self, point: DVec2) -> f64 {
        if self.is_horizontal() { point.y } else { point.x }
    }

    /// The point with these coordinates along and across the side.
    #[must_use]
    pub fn point(self, along: f64, across: f64) -> DVec2 {
        if self.is_horizontal() { DVec2::new(along, across) } else { DVec2::new(across, along) }
    }

    /// True if walking counter-clockwise runs with growing coordinate along the side (south, east).
    #[must_use]
    pub fn runs_upward(self) -> bool {
        matches!(self, Self::South | Self::East)
    }
}

/// A grid edge: the south or west side of `cell`. Cells outside the area are named too (north and east rim).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct BorderId {
    /// The cell north or east of the border.
    pub cell: CellId,
    /// South or west.
    pub side: Side,
}

impl BorderId {
    /// The two cells of the border: (north or east of it, south or west of it).
    #[must_use]
    pub fn cells(self) -> [CellId; 2] {
        [self.cell, self.cell.neighbour(self.side)]
    }
}

/// A grid corner: the south-west corner of cell (i, j).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct CornerId {
    /// Row line.
    pub j: i32,
    /// Column line.
    pub i: i32,
}

impl CornerId {
    /// The four cells round the corner, row by row.
    #[must_use]
    pub fn cells(self) -> [CellId; 4] {
        let (i, j) = (self.i, self.j);
        [CellId::new(i - 1, j - 1), CellId::new(i, j - 1), CellId::new(i - 1, j), CellId::new(i, j)]
    }
}

/// Where the cells lie.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// South-west corner of cell (0, 0), metres, in the frame of the scene's files.
    pub origin: DVec2,
    /// Length of a cell's side, metres.
    pub cell_size_m: f64,
}

impl Grid {
    /// Position of a grid corner.
    #[must_use]
    pub fn corner(&self, corner: CornerId) -> DVec2 {
        self.origin + DVec2::new(f64::from(corner.i), f64::from(corner.j)) * self.cell_size_m
    }

    /// South-west and north-east corner of a cell.
    #[must_use]
    pub fn rectangle(&self, cell: CellId) -> (DVec2, DVec2) {
        (
            self.corner(CornerId { j: cell.j, i: cell.i }),
            self.corner(CornerId { j: cell.j + 1, i: cell.i + 1 }),
        )
    }

    /// The cell that holds a point (south and west sides belong to the cell).
    #[must_use]
    pub fn cell_at(&self, point: DVec2) -> CellId {
        let q = ((point - self.origin) / self.cell_size_m).floor();
        CellId::new(q.x as i32, q.y as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_cells_name_the_same_border() {
        let cell = CellId::new(3, -2);
        for side in Side::ALL {
            assert_eq!(cell.border(side), cell.neighbour(side).border(side.opposite()), "{side:?}");
            assert!(cell.border(side).cells().contains(&cell));
        }
    }

    #[test]
    fn corners_follow_the_sides_counter_clockwise() {
        let grid = Grid { origin: DVec2::new(10.0, 20.0), cell_size_m: 5.0 };
        let cell = CellId::new(1, 1);
        let corners = Side::ALL.map(|s| grid.corner(cell.corner_after(s)));
        let expected = [(20.0, 25.0), (20.0, 30.0), (15.0, 30.0), (15.0, 25.0)];
        assert_eq!(corners.map(|c| (c.x, c.y)), expected);
    }

    #[test]
    fn a_point_on_the_south_west_sides_belongs_to_the_cell() {
        let grid = Grid { origin: DVec2::new(-10.0, 0.0), cell_size_m: 10.0 };
        assert_eq!(grid.cell_at(DVec2::new(0.0, 10.0)), CellId::new(1, 1));
        assert_eq!(grid.cell_at(DVec2::new(-0.001, 9.999)), CellId::new(0, 0));
        assert_eq!(grid.cell_at(DVec2::new(-10.5, -0.1)), CellId::new(-1, -1));
    }
}
