//! Tiny scenes with known holes, their plans, and ways to look at them.
#![allow(dead_code, unused_imports)] // each test file uses its own part

mod lattice;
mod motion;
mod scene;
mod sheet;
mod summary;

pub(crate) use lattice::{Step, lattice, lattice_of};
pub(crate) use motion::Motion;
pub(crate) use scene::{Limit, Planned, Scene, append};
pub(crate) use sheet::{block, open_slit, scatter, sheet, tube};
pub(crate) use summary::{Line, assert_same, lines, signature};

/// Side of a cell, metres; also the number of its lattice quads, so that a quad is one metre.
pub(crate) const CELL: i32 = 8;

/// The side in metres.
pub(crate) const CELL_M: f64 = CELL as f64;

/// The rectangle between two corners is cut out.
pub(crate) fn cut(x0: f64, y0: f64, x1: f64, y1: f64) -> Step {
    Step::Cut([x0, y0, x1, y1])
}

/// The rectangle between two corners is put back.
pub(crate) fn keep(x0: f64, y0: f64, x1: f64, y1: f64) -> Step {
    Step::Keep([x0, y0, x1, y1])
}
