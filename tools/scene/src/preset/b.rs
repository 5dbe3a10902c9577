//! 8 x 4 cells with the counts of Wang et al. 2021: tables 1 and 2, and those of table 3, where holes were added.

use super::{Block, PlanError, size_or};
use crate::area::{Area, Cell, Side};
use crate::hole::Hole;
use crate::plan::Plan;
use crate::random::Rng;
use crate::shape::Place;
use crate::stamp::{Placement, border_pond, edge_pond, island_pond, lake, pond, river};

/// How a block's stamps are placed: the cell in the block, and quarter turns.
type At<'a> = dyn FnMut(Cell, u32) -> Placement + 'a;

/// Least and largest radius of closed holes, in cell sides.
const POND_RADIUS: [f64; 2] = [0.06, 0.13];

/// Closed: 16; I: 4 A, 17 B, 1 D; II: 2 B.
const TABLES_1_2: Block = Block {
    size: [8, 4],
    cell_size_m: 250.0,
    holes: |at, rng| {
        let mut holes = vec![
            lake(&at([2, 1], 0), &row(3), &bays(3), rng),
            lake(&at([6, 2], 0), &row(1), &bays(1), rng),
            border_pond(&at([0, 2], 0), rng),
            border_pond(&at([0, 0], 1), rng),
            island_pond(&at([1, 3], 3), rng),
            edge_pond(&at([7, 0], 1), rng),
            edge_pond(&at([4, 3], 3), rng),
        ];
        let cells = [[1, 0], [5, 0], [6, 0], [7, 1], [7, 3], [0, 3], [3, 3], [5, 3]];
        holes.extend(ponds(at, &cells, &[[0.28, 0.3], [0.7, 0.72]], rng));
        holes
    },
    edge_holes: |_, _| Vec::new(),
};

/// Closed: 20; I: 5 A, 20 B, 4 C, 4 D; II: 2 B.
const TABLE_3: Block = Block {
    size: [8, 4],
    cell_size_m: 250.0,
    holes: |at, rng| {
        let mut holes = vec![
            lake(&at([1, 1], 0), &row(4), &bays(4), rng),
            lake(&at([6, 1], 0), &row(1), &bays(1), rng),
            river(&at([1, 3], 0), 4, rng),
            edge_pond(&at([3, 0], 1), rng),
            edge_pond(&at([7, 3], 2), rng),
        ];
        holes.extend([[0, 0], [7, 0], [0, 2], [7, 2]].map(|cell| island_pond(&at(cell, 0), rng)));
        let corners = [[0.27, 0.27], [0.73, 0.27], [0.27, 0.73], [0.73, 0.73]];
        holes.extend(ponds(at, &[[5, 0], [5, 2], [6, 3]], &corners, rng));
        holes.extend(ponds(at, &[[1, 0], [2, 0], [4, 0], [6, 0]], &corners[..2], rng));
        holes
    },
    edge_holes: |_, _| Vec::new(),
};

/// Hollow cells in a row to the east.
fn row(hollow: i64) -> Vec<Cell> {
    (0..hollow).map(|i| [i, 0]).collect()
}

/// Bays on every side of such a row.
fn bays(hollow: i64) -> Vec<(Cell, Side)> {
    let ends = [([0, 0], Side::West), ([hollow - 1, 0], Side::East)];
    let sides = (0..hollow).flat_map(|i| [([i, 0], Side::South), ([i, 0], Side::North)]);
    ends.into_iter().chain(sides).collect()
}

/// A closed hole at each of the places in each of the cells.
fn ponds(at: &mut At<'_>, cells: &[Cell], places: &[Place], rng: &mut Rng) -> Vec<Hole> {
    let all = cells.iter().flat_map(|&cell| places.iter().map(move |&place| (cell, place)));
    let mut draw = |(cell, place)| {
        let radius = rng.within(POND_RADIUS[0], POND_RADIUS[1]);
        pond(&at(cell, 0), place, radius, rng)
    };
    all.map(&mut draw).collect()
}

/// The plan of preset `b`, or with the holes of table 3 that of `b-added`.
pub(super) fn plan(is_added: bool, cells: Option<[i64; 2]>, rng: &mut Rng) -> Result<Plan, PlanError> {
    let (name, block) = if is_added { ("b-added", TABLE_3) } else { ("b", TABLES_1_2) };
    let [columns, rows] = size_or(cells, block.size)?;
    Ok(Plan {
        name,
        cell_size_m: block.cell_size_m,
        relief_m: 12.0,
        area: Area::rectangle(columns, rows),
        holes: block.repeat([columns, rows], rng),
    })
}
