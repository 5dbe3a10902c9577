//! A city of 449 cells with the counts of Wang et al. 2021, sec. 4: 56 closed; I: 17 A, 43 B, 4 C, 3 D; II: 5 B, 1 D.

use super::PlanError;
use crate::area::{Area, Cell, SIDES, Side, beyond};
use crate::class::Class;
use crate::hole::Hole;
use crate::plan::Plan;
use crate::random::Rng;
use crate::stamp::{
    Placement, border_pond, corner_pond, corner_river, edge_island_pond, edge_pond, island_pond, lake, pond,
    river,
};
use std::collections::BTreeSet;

const CELLS: i64 = 449;
const BOX: [i64; 2] = [21, 32];
const CELL_SIZE_M: f64 = 250.0;

/// Draws one hole at a placement.
type Stamp = fn(&Placement, &mut Rng) -> Hole;

/// How often each stamp is set; large ones first, as they find room least easily.
///
/// Holes: lakes 17 A + 15 B; rivers 4 C + 4 B; corner river and islands 3 D + 4 B; corner ponds 12 B; border ponds 8 B;
/// edge 5 B + 1 D; ponds 56 closed.
const STAMPS: [(usize, Stamp); 11] = [
    (1, great_lake),
    (1, square_lake),
    (1, long_lake),
    (3, single_lake),
    (2, |at, rng| river(at, 2, rng)),
    (3, corner_pond),
    (1, corner_river),
    (2, island_pond),
    (4, border_pond),
    (1, edge_island_pond),
    (5, edge_pond),
];
const PONDS: usize = 56;

/// The plan of preset `city`.
///
/// Without `cells` the area is irregular; with them it is that rectangle, and the holes are set once for every 449
/// cells (at least once).
pub(super) fn plan(cells: Option<[i64; 2]>, rng: &mut Rng) -> Result<Plan, PlanError> {
    let area = match cells {
        None => {
            Area::irregular(BOX[0], BOX[1], CELLS, rng).ok_or(PlanError::NoRoom { cells: CELLS as usize })?
        }
        Some([columns, rows]) => Area::rectangle(columns, rows),
    };
    let times = (area.len() / CELLS as usize).max(1);
    let mut site = Site { area: &area, taken: BTreeSet::new(), holes: Vec::new() };
    for (count, stamp) in STAMPS {
        for _ in 0..count * times {
            site.set(stamp, rng)?;
        }
    }
    for _ in 0..PONDS * times {
        site.set(random_pond, rng)?;
    }
    let holes = site.holes;
    Ok(Plan { name: "city", cell_size_m: CELL_SIZE_M, relief_m: 25.0, area, holes })
}

/// The area while holes are being set.
struct Site<'a> {
    area: &'a Area,
    taken: BTreeSet<Cell>,
    holes: Vec<Hole>,
}

impl Site<'_> {
    /// Sets a stamp at the first of the area's cells and turns, in random order, where it fits.
    fn set(&mut self, stamp: Stamp, rng: &mut Rng) -> Result<(), PlanError> {
        let mut places: Vec<(Cell, u32)> =
            self.area.cells().flat_map(|cell| (0..4).map(move |turns| (cell, turns))).collect();
        rng.shuffle(&mut places);
        for (cell, turns) in places {
            let hole = stamp(&Placement { cell, turns, cell_size_m: CELL_SIZE_M }, rng);
            if self.fits(&hole, cell, turns) {
                self.taken.extend(self.claim(&hole));
                self.holes.push(hole);
                return Ok(());
            }
        }
        Err(PlanError::NoRoom { cells: self.area.len() })
    }

    /// Cells the hole keeps for itself: those that show it, and all round a hollow cell.
    fn claim(&self, hole: &Hole) -> BTreeSet<Cell> {
        let mut cells: BTreeSet<Cell> = hole.expected.iter().map(|e| e.0).collect();
        cells.extend(hole.hollow.iter().flat_map(|&c| SIDES.map(|side| beyond(c, side))));
        cells
    }

    fn fits(&self, hole: &Hole, cell: Cell, turns: u32) -> bool {
        let free = self.claim(hole).iter().all(|c| self.area.contains(*c) && !self.taken.contains(c));
        let inland = hole.hollow.iter().flat_map(|&[i, j]| ring_of([i, j])).all(|c| self.area.contains(c));
        let at_edge = hole.expected.iter().any(|e| matches!(e.1, Class::External(_)));
        let outside = beyond(cell, WEST_AFTER[turns as usize]);
        free && inland && (!at_edge || !self.area.contains(outside))
    }
}

/// The eight cells round a cell: a hollow cell that met the outside in a corner would part its neighbours there.
fn ring_of([i, j]: Cell) -> impl Iterator<Item = Cell> {
    (0..9).filter(|k| *k != 4).map(move |k| [i + k % 3 - 1, j + k / 3 - 1])
}

/// Where a stamp's west comes to lie after so many quarter turns to the left.
const WEST_AFTER: [Side; 4] = [Side::West, Side::South, Side::East, Side::North];

fn random_pond(at: &Placement, rng: &mut Rng) -> Hole {
    let radius = rng.within(0.08, 0.28);
    let reach = 0.36 - radius;
    let centre = [0.5 + rng.within(-reach, reach), 0.5 + rng.within(-reach, reach)];
    pond(at, centre, radius, rng)
}

/// Eight hollow cells, five bays.
fn great_lake(at: &Placement, rng: &mut Rng) -> Hole {
    let hollow = [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1], [0, 2], [1, 2]];
    let bays = [
        ([0, 0], Side::South),
        ([2, 0], Side::South),
        ([2, 1], Side::East),
        ([1, 2], Side::North),
        ([0, 1], Side::West),
    ];
    lake(at, &hollow, &bays, rng)
}

/// Four hollow cells, four bays.
fn square_lake(at: &Placement, rng: &mut Rng) -> Hole {
    let bays = [([0, 0], Side::West), ([1, 0], Side::South), ([1, 1], Side::East), ([0, 1], Side::North)];
    lake(at, &[[0, 0], [1, 0], [0, 1], [1, 1]], &bays, rng)
}

/// Two hollow cells, three bays.
fn long_lake(at: &Placement, rng: &mut Rng) -> Hole {
    lake(at, &[[0, 0], [1, 0]], &[([0, 0], Side::West), ([1, 0], Side::South), ([1, 0], Side::East)], rng)
}

/// One hollow cell, one bay.
fn single_lake(at: &Placement, rng: &mut Rng) -> Hole {
    lake(at, &[[0, 0]], &[([0, 0], Side::East)], rng)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::class::Form;

    #[test]
    fn every_seed_plans_the_papers_counts() {
        for seed in 1..=10 {
            let plan = plan(None, &mut Rng::new(&[seed])).unwrap();
            let counts: Vec<usize> = [
                Class::Closed,
                Class::Internal(Form::Hollow),
                Class::Internal(Form::SemiEnclosed),
                Class::Internal(Form::Crossing),
                Class::Internal(Form::Island),
                Class::External(Form::SemiEnclosed),
                Class::External(Form::Island),
            ]
            .iter()
            .map(|c| plan.promised().get(c).copied().unwrap_or(0))
            .collect();
            assert_eq!(counts, [56, 17, 43, 4, 3, 5, 1], "seed {seed}");
            assert_eq!(plan.promised().values().sum::<usize>(), 129);
        }
    }

    #[test]
    fn too_small_an_area_is_refused() {
        assert!(matches!(plan(Some([5, 5]), &mut Rng::new(&[1])), Err(PlanError::NoRoom { cells: 25 })));
    }
}
