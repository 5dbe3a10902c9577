//! 6 x 5 cells: a lake over two hollow cells with bays, a river through three cells, an island, ponds, a hole at the edge.

use super::{Block, PlanError, size_or};
use crate::area::{Area, Side};
use crate::plan::Plan;
use crate::random::Rng;
use crate::stamp::{border_pond, edge_pond, island_pond, lake, pond, river};

const BLOCK: Block = Block {
    size: [6, 5],
    cell_size_m: 100.0,
    holes: |at, rng| {
        let bays = [
            ([0, 0], Side::West),
            ([0, 0], Side::North),
            ([0, 0], Side::South),
            ([1, 0], Side::North),
            ([1, 0], Side::East),
        ];
        vec![
            lake(&at([2, 2], 0), &[[0, 0], [1, 0]], &bays, rng),
            river(&at([1, 0], 0), 3, rng),
            island_pond(&at([4, 3], 0), rng),
            border_pond(&at([0, 1], 1), rng),
            pond(&at([0, 3], 0), [0.55, 0.5], 0.22, rng),
            pond(&at([1, 4], 0), [0.5, 0.5], 0.14, rng),
            pond(&at([5, 1], 0), [0.45, 0.5], 0.28, rng),
            pond(&at([3, 1], 0), [0.5, 0.6], 0.1, rng),
        ]
    },
    edge_holes: |at, rng| vec![edge_pond(&at([0, 4], 0), rng)],
};

/// The plan of preset `demo`.
pub(super) fn plan(cells: Option<[i64; 2]>, rng: &mut Rng) -> Result<Plan, PlanError> {
    let [columns, rows] = size_or(cells, BLOCK.size)?;
    Ok(Plan {
        name: "demo",
        cell_size_m: BLOCK.cell_size_m,
        relief_m: 20.0,
        area: Area::rectangle(columns, rows),
        holes: BLOCK.repeat([columns, rows], rng),
    })
}
