//! The cells of the reconstruction area.

use crate::random::Rng;

/// Column (east) and row (north) of a cell.
pub type Cell = [i64; 2];

/// A side of a cell, in walking order (counter-clockwise seen from above).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// Lower y.
    South,
    /// Higher x.
    East,
    /// Higher y.
    North,
    /// Lower x.
    West,
}

/// All four sides in walking order.
pub const SIDES: [Side; 4] = [Side::South, Side::East, Side::North, Side::West];

/// The cell beyond a side.
#[must_use]
pub fn beyond(cell: Cell, side: Side) -> Cell {
    let [i, j] = cell;
    match side {
        Side::South => [i, j - 1],
        Side::East => [i + 1, j],
        Side::North => [i, j + 1],
        Side::West => [i - 1, j],
    }
}

/// The cells of the reconstruction area inside a box of columns and rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Area {
    columns: i64,
    rows: i64,
    inside: Vec<bool>,
}

impl Area {
    /// A full rectangle.
    #[must_use]
    pub fn rectangle(columns: i64, rows: i64) -> Self {
        Self { columns, rows, inside: vec![true; (columns * rows).max(0) as usize] }
    }

    /// An irregular area of exactly `count` cells in a box.
    ///
    /// Every row is one run of cells, and runs of neighbouring rows overlap: so no missing cell is enclosed, and no
    /// two cells meet in a corner alone. The runs start as those of a wavering ellipse; then ends of random rows are
    /// moved until the count is right. `None` if the box has no room.
    #[must_use]
    pub fn irregular(columns: i64, rows: i64, count: i64, rng: &mut Rng) -> Option<Self> {
        let mut runs: Vec<[i64; 2]> = (0..rows).map(|row| wavering_run(columns, rows, row, rng)).collect();
        for _ in 0..100 * columns * rows {
            let total: i64 = runs.iter().map(|r| r[1] - r[0]).sum();
            if total == count {
                return Some(Self::of_runs(columns, rows, &runs));
            }
            nudge_run(&mut runs, columns, total < count, rng);
        }
        None
    }

    fn of_runs(columns: i64, rows: i64, runs: &[[i64; 2]]) -> Self {
        let inside = runs.iter().flat_map(|r| (0..columns).map(|i| r[0] <= i && i < r[1])).collect();
        Self { columns, rows, inside }
    }

    /// Columns of the box.
    #[must_use]
    pub fn columns(&self) -> i64 {
        self.columns
    }

    /// Rows of the box.
    #[must_use]
    pub fn rows(&self) -> i64 {
        self.rows
    }

    /// True if the cell is in the area.
    #[must_use]
    pub fn contains(&self, cell: Cell) -> bool {
        let [i, j] = cell;
        (0..self.columns).contains(&i)
            && (0..self.rows).contains(&j)
            && self.inside[(j * self.columns + i) as usize]
    }

    /// The cells of the area, row by row from the south, each from the west.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + '_ {
        (0..self.rows).flat_map(|j| (0..self.columns).map(move |i| [i, j])).filter(|&c| self.contains(c))
    }

    /// How many cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.inside.iter().filter(|&&b| b).count()
    }

    /// True if no cell is in the area.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Shortest overlap of two neighbouring rows' runs, in cells.
const OVERLAP: i64 = 3;

fn wavering_run(columns: i64, rows: i64, row: i64, rng: &mut Rng) -> [i64; 2] {
    let v = (row as f64 + 0.5) / rows as f64 * 2.0 - 1.0;
    let half = (1.0 - v * v).max(0.09).sqrt() * columns as f64 / 2.0;
    let middle = columns as f64 / 2.0;
    let low = (middle - half * rng.within(0.75, 1.0)).round() as i64;
    let high = (middle + half * rng.within(0.75, 1.0)).round() as i64;
    [low.clamp(0, columns), high.clamp(0, columns)]
}

fn nudge_run(runs: &mut [[i64; 2]], columns: i64, grow: bool, rng: &mut Rng) {
    let row = rng.below(runs.len());
    let end = rng.below(2);
    let outward = if end == 0 { -1 } else { 1 };
    let before = runs[row];
    runs[row][end] += if grow { outward } else { -outward };
    let fits = runs[row][0] >= 0 && runs[row][1] <= columns && runs[row][1] - runs[row][0] >= OVERLAP;
    let overlaps = |a: [i64; 2], b: [i64; 2]| a[1].min(b[1]) - a[0].max(b[0]) >= OVERLAP;
    let below = row == 0 || overlaps(runs[row], runs[row - 1]);
    let above = row + 1 == runs.len() || overlaps(runs[row], runs[row + 1]);
    if !(fits && below && above) {
        runs[row] = before;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reached_from_outside(area: &Area) -> usize {
        let (w, h) = (area.columns + 2, area.rows + 2);
        let mut seen = vec![false; (w * h) as usize];
        let mut stack = vec![[-1, -1]];
        let mut count = 0;
        while let Some(cell) = stack.pop() {
            let [i, j] = cell;
            if !(-1..=area.columns).contains(&i) || !(-1..=area.rows).contains(&j) || area.contains(cell) {
                continue;
            }
            if std::mem::replace(&mut seen[((j + 1) * w + i + 1) as usize], true) {
                continue;
            }
            count += 1;
            stack.extend(SIDES.map(|side| beyond(cell, side)));
        }
        count
    }

    #[test]
    fn an_irregular_area_has_its_count_and_encloses_nothing() {
        for seed in 1..=20 {
            let area = Area::irregular(21, 32, 449, &mut Rng::new(&[seed])).unwrap();
            assert_eq!(area.len(), 449, "seed {seed}");
            assert_eq!(area.cells().count(), 449);
            assert_eq!(reached_from_outside(&area) + 449, 23 * 34, "seed {seed}: a missing cell is enclosed");
        }
    }

    #[test]
    fn an_area_larger_than_its_box_is_refused() {
        assert!(Area::irregular(5, 5, 26, &mut Rng::new(&[1])).is_none());
    }
}
