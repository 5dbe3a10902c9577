//! 2 x 2 cells with one large hole over all four, and one at the area's edge.

use super::{Block, PlanError, size_or};
use crate::area::Area;
use crate::class::{Class, Form};
use crate::hole::Hole;
use crate::plan::Plan;
use crate::random::Rng;
use crate::shape::{Blob, Shape};
use crate::stamp::{Placement, edge_pond};

/// Area of the hole in the middle, square metres.
const AREA_M2: f64 = 57_000.0;

const BLOCK: Block = Block {
    size: [2, 2],
    cell_size_m: 250.0,
    holes: |at, rng| vec![large_pond(&at([0, 0], 0), rng)],
    edge_holes: |at, rng| vec![edge_pond(&at([0, 0], 0), rng)],
};

/// The plan of preset `a`.
pub(super) fn plan(cells: Option<[i64; 2]>, rng: &mut Rng) -> Result<Plan, PlanError> {
    let [columns, rows] = size_or(cells, BLOCK.size)?;
    Ok(Plan {
        name: "a",
        cell_size_m: BLOCK.cell_size_m,
        relief_m: 2.0,
        area: Area::rectangle(columns, rows),
        holes: BLOCK.repeat([columns, rows], rng),
    })
}

fn large_pond(at: &Placement, rng: &mut Rng) -> Hole {
    let corner = at.cell.map(|k| (k + 1) as f64 * at.cell_size_m);
    let radius_m = (AREA_M2 / std::f64::consts::PI).sqrt();
    let bay = Class::Internal(Form::SemiEnclosed);
    let cells = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[i, j]| ([at.cell[0] + i, at.cell[1] + j], bay));
    let blob = Blob::new(corner, radius_m, 0.15, rng);
    Hole { parts: vec![Shape::Blob(blob)], expected: cells.into(), ..Hole::default() }
}
