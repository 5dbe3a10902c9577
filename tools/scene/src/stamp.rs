//! Holes of known classes, each drawn once in units of a cell and placed anywhere, turned by quarter turns.
//!
//! Coordinates (u, v) count in cell sides from the south-west corner of the stamp's first cell. Rims cross cell borders
//! steeply and far from corners, so that the classes hold for every seed and any sensible triangle size.

use crate::area::{Cell, Side, beyond};
use crate::class::{Class, Form};
use crate::hole::Hole;
use crate::random::Rng;
use crate::shape::{Blob, Place, Shape};

/// Largest relative change of a pond's radius.
const WAVINESS: f64 = 0.1;

const BAY: Class = Class::Internal(Form::SemiEnclosed);

/// Where a stamp's first cell comes to lie, and how often the stamp is turned left about that cell's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The stamp's first cell.
    pub cell: Cell,
    /// Quarter turns to the left, 0..4.
    pub turns: u32,
    /// Side of a cell, metres.
    pub cell_size_m: f64,
}

impl Placement {
    fn place(&self, u: f64, v: f64) -> Place {
        let (mut du, mut dv) = (u - 0.5, v - 0.5);
        for _ in 0..self.turns {
            (du, dv) = (-dv, du);
        }
        [
            (self.cell[0] as f64 + 0.5 + du) * self.cell_size_m,
            (self.cell[1] as f64 + 0.5 + dv) * self.cell_size_m,
        ]
    }

    fn cell_at(&self, cell: Cell) -> Cell {
        let [mut i, mut j] = cell;
        for _ in 0..self.turns {
            (i, j) = (-j, i);
        }
        [self.cell[0] + i, self.cell[1] + j]
    }

    fn blob(&self, u: f64, v: f64, radius: f64, rng: &mut Rng) -> Shape {
        Shape::Blob(Blob::new(self.place(u, v), radius * self.cell_size_m, WAVINESS, rng))
    }

    fn hole(&self, parts: Vec<Shape>, islands: Vec<Shape>, expected: &[(Cell, Class)]) -> Hole {
        let expected = expected.iter().map(|&(cell, class)| (self.cell_at(cell), class)).collect();
        Hole { parts, islands, expected, ..Hole::default() }
    }
}

/// A closed hole round (u, v).
#[must_use]
pub fn pond(at: &Placement, [u, v]: Place, radius: f64, rng: &mut Rng) -> Hole {
    at.hole(vec![at.blob(u, v, radius, rng)], vec![], &[([0, 0], Class::Closed)])
}

/// A hole over the east border: a bay in each of two cells.
#[must_use]
pub fn border_pond(at: &Placement, rng: &mut Rng) -> Hole {
    let (v, radius) = (rng.within(0.42, 0.58), rng.within(0.2, 0.26));
    at.hole(vec![at.blob(1.0, v, radius, rng)], vec![], &[([0, 0], BAY), ([1, 0], BAY)])
}

/// A hole over the north-east corner: a bay in each of four cells.
#[must_use]
pub fn corner_pond(at: &Placement, rng: &mut Rng) -> Hole {
    let radius = rng.within(0.27, 0.34);
    let cells = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|c| (c, BAY));
    at.hole(vec![at.blob(1.0, 1.0, radius, rng)], vec![], &cells)
}

/// Hollow cells with bays into some of the cells round them.
///
/// A bay is given as the hollow cell and the side it leaves by. No cell may get two bays.
#[must_use]
pub fn lake(at: &Placement, hollow: &[Cell], bays: &[(Cell, Side)], rng: &mut Rng) -> Hole {
    let mut expected: Vec<(Cell, Class)> =
        hollow.iter().map(|&c| (c, Class::Internal(Form::Hollow))).collect();
    let mut parts = Vec::new();
    for &(cell, side) in bays {
        let other = beyond(cell, side);
        let middle = |k: usize| (cell[k] + other[k] + 1) as f64 / 2.0;
        parts.push(at.blob(middle(0), middle(1), rng.within(0.22, 0.3), rng));
        expected.push((other, BAY));
    }
    let mut hole = at.hole(parts, vec![], &expected);
    hole.hollow = hollow.iter().map(|&c| at.cell_at(c)).collect();
    hole
}

/// A river from the cell west of the first one through `crossed` cells into the next one: bay, crossings, bay.
#[must_use]
pub fn river(at: &Placement, crossed: i64, rng: &mut Rng) -> Hole {
    let steps = 4 * crossed + 2;
    let (start, end) = (-0.3, crossed as f64 + 0.3);
    let phase = rng.within(0.0, std::f64::consts::TAU);
    let line = (0..=steps)
        .map(|k| {
            let u = start + (end - start) * k as f64 / steps as f64;
            at.place(u, 0.5 + 0.06 * libm::sin(phase + 3.0 * u))
        })
        .collect();
    let band = Shape::Band { line, half_width_m: rng.within(0.09, 0.12) * at.cell_size_m };
    let mut expected = vec![([-1, 0], BAY), ([crossed, 0], BAY)];
    expected.extend((0..crossed).map(|i| ([i, 0], Class::Internal(Form::Crossing))));
    at.hole(vec![band], vec![], &expected)
}

/// A river that cuts the first cell's south-east corner off: its southern and eastern neighbours get bays.
#[must_use]
pub fn corner_river(at: &Placement, rng: &mut Rng) -> Hole {
    let shift = rng.within(-0.03, 0.03);
    let line = vec![at.place(0.36 + shift, -0.26), at.place(1.26, 0.64 - shift)];
    let band = Shape::Band { line, half_width_m: 0.1 * at.cell_size_m };
    at.hole(vec![band], vec![], &[([0, 0], Class::Internal(Form::Island)), ([0, -1], BAY), ([1, 0], BAY)])
}

/// A pond with an island in the first cell that reaches a little over the north border.
#[must_use]
pub fn island_pond(at: &Placement, rng: &mut Rng) -> Hole {
    let u = rng.within(0.47, 0.53);
    let pond = at.blob(u, 0.73, 0.38, rng);
    let island = at.blob(u, 0.68, rng.within(0.12, 0.15), rng);
    at.hole(vec![pond], vec![island], &[([0, 0], Class::Internal(Form::Island)), ([0, 1], BAY)])
}

/// A pond on the west side of a cell at the area's edge.
#[must_use]
pub fn edge_pond(at: &Placement, rng: &mut Rng) -> Hole {
    let (v, radius) = (rng.within(0.45, 0.55), rng.within(0.18, 0.24));
    at.hole(vec![at.blob(0.0, v, radius, rng)], vec![], &[([0, 0], Class::External(Form::SemiEnclosed))])
}

/// A pond with an island on the west side of a cell at the area's edge.
#[must_use]
pub fn edge_island_pond(at: &Placement, rng: &mut Rng) -> Hole {
    let v = rng.within(0.48, 0.52);
    let pond = at.blob(0.28, v, 0.38, rng);
    let island = at.blob(0.33, v, rng.within(0.12, 0.15), rng);
    at.hole(vec![pond], vec![island], &[([0, 0], Class::External(Form::Island))])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_stamp_is_the_turned_shape_in_the_turned_cells() {
        let at = |turns| Placement { cell: [4, 7], turns, cell_size_m: 100.0 };
        assert_eq!(at(0).place(1.0, 0.5), [500.0, 750.0]);
        assert_eq!(at(1).place(1.0, 0.5), [450.0, 800.0]);
        assert_eq!(at(1).cell_at([1, 0]), [4, 8]);
        assert_eq!(at(2).cell_at([1, 0]), [3, 7]);
        assert_eq!(at(3).cell_at([0, 1]), [5, 7]);
    }
}
