//! 4 x 2 cells (half a square kilometre) that repeat over any larger area: bays, an island, closed holes.

use super::{Block, PlanError, size_or};
use crate::area::Area;
use crate::plan::Plan;
use crate::random::Rng;
use crate::stamp::{border_pond, corner_pond, island_pond, pond};

/// No hole reaches the block's edge, so every area of whole blocks has as many holes a square kilometre: closed: 4;
/// I: 7 B, 1 D.
const BLOCK: Block = Block {
    size: [4, 2],
    cell_size_m: 250.0,
    holes: |at, rng| {
        vec![
            corner_pond(&at([0, 0], 0), rng),
            border_pond(&at([2, 0], 0), rng),
            island_pond(&at([3, 1], 2), rng),
            pond(&at([0, 0], 0), [0.3, 0.3], 0.12, rng),
            pond(&at([1, 1], 0), [0.7, 0.7], 0.14, rng),
            pond(&at([2, 1], 0), [0.3, 0.6], 0.16, rng),
            pond(&at([2, 1], 0), [0.75, 0.4], 0.08, rng),
        ]
    },
    edge_holes: |_, _| Vec::new(),
};

/// The plan of preset `growing`.
pub(super) fn plan(cells: Option<[i64; 2]>, rng: &mut Rng) -> Result<Plan, PlanError> {
    let [columns, rows] = size_or(cells, BLOCK.size)?;
    Ok(Plan {
        name: "growing",
        cell_size_m: BLOCK.cell_size_m,
        relief_m: 12.0,
        area: Area::rectangle(columns, rows),
        holes: BLOCK.repeat([columns, rows], rng),
    })
}
