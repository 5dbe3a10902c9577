//! 3 x 3 cells: a lake, a river, an island, ponds, a hole at the edge.

use super::{Block, PlanError, size_or};
use crate::area::{Area, Side};
use crate::plan::Plan;
use crate::random::Rng;
use crate::stamp::{edge_pond, island_pond, lake, pond, river};

const BLOCK: Block = Block {
    size: [3, 3],
    cell_size_m: 100.0,
    holes: |at, rng| {
        vec![
            lake(&at([1, 1], 0), &[[0, 0]], &[([0, 0], Side::West), ([0, 0], Side::North)], rng),
            river(&at([1, 0], 0), 1, rng),
            island_pond(&at([2, 1], 0), rng),
            pond(&at([0, 2], 0), [0.5, 0.55], 0.2, rng),
            pond(&at([2, 2], 0), [0.5, 0.62], 0.15, rng),
        ]
    },
    edge_holes: |at, rng| vec![edge_pond(&at([0, 1], 0), rng)],
};

/// The plan of preset `small`.
pub(super) fn plan(cells: Option<[i64; 2]>, rng: &mut Rng) -> Result<Plan, PlanError> {
    let [columns, rows] = size_or(cells, BLOCK.size)?;
    Ok(Plan {
        name: "small",
        cell_size_m: BLOCK.cell_size_m,
        relief_m: 12.0,
        area: Area::rectangle(columns, rows),
        holes: BLOCK.repeat([columns, rows], rng),
    })
}
