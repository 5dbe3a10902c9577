//! Turning and mirroring a whole scene in plan, so that the grid stays a grid.

use crate::area::Cell;
use crate::shape::Place;
use crate::tile::Tile;

/// A mirror along x (first) and quarter turns to the left; the scene's box keeps its south-west corner at 0, 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Columns and rows before.
    pub size: [i64; 2],
    /// Side of a cell, lattice units.
    pub cell_size: i64,
    /// True to swap east and west.
    pub mirror: bool,
    /// Quarter turns to the left, 0..4.
    pub turns: u32,
}

impl Frame {
    /// Columns and rows after.
    #[must_use]
    pub fn turned_size(&self) -> [i64; 2] {
        if self.turns % 2 == 1 { [self.size[1], self.size[0]] } else { self.size }
    }

    /// Where a point in plan comes to lie; `size` is the scene's box in the point's units.
    fn map<N: Copy + std::ops::Sub<Output = N>>(&self, point: [N; 2], size: [N; 2]) -> [N; 2] {
        let ([mut x, mut y], [width, mut height]) = (point, size);
        if self.mirror {
            x = width - x;
        }
        let mut other = width;
        for _ in 0..self.turns {
            (x, y) = (height - y, x);
            (height, other) = (other, height);
        }
        [x, y]
    }

    /// The cell after turning.
    #[must_use]
    pub fn cell(&self, cell: Cell) -> Cell {
        self.map(cell, self.size.map(|k| k - 1))
    }

    /// The place after turning, metres.
    #[must_use]
    pub fn place(&self, place: Place, cell_size_m: f64) -> Place {
        self.map(place, self.size.map(|k| k as f64 * cell_size_m))
    }

    /// The position after turning, lattice units.
    #[must_use]
    pub fn position(&self, [x, y, z]: [i64; 3]) -> [i64; 3] {
        let [x, y] = self.map([x, y], self.size.map(|k| k * self.cell_size));
        [x, y, z]
    }

    /// Turns a tile; mirrored triangles swap two corners, so that they face up again.
    pub fn turn(&self, tile: &mut Tile) {
        for vertex in &mut tile.vertices {
            *vertex = self.position(*vertex);
        }
        if self.mirror {
            tile.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_and_places_go_together() {
        let frame = |mirror, turns| Frame { size: [3, 2], cell_size: 1024, mirror, turns };
        let cases = [
            (frame(false, 0), [2, 0]),
            (frame(false, 1), [1, 2]),
            (frame(false, 2), [0, 1]),
            (frame(false, 3), [0, 0]),
            (frame(true, 0), [0, 0]),
            (frame(true, 1), [1, 0]),
        ];
        for (frame, cell) in cases {
            assert_eq!(frame.cell([2, 0]), cell, "{frame:?}");
            let middle = frame.place([2.5, 0.5], 1.0);
            assert_eq!(middle, cell.map(|k| k as f64 + 0.5), "{frame:?}");
        }
    }
}
