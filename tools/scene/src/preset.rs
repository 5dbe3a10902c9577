//! The presets: which holes where.

mod a;
mod b;
mod city;
mod demo;
mod growing;
mod small;

use crate::area::Cell;
use crate::hole::Hole;
use crate::plan::Plan;
use crate::random::Rng;
use crate::stamp::Placement;
use serde::{Deserialize, Serialize};

/// A named kind of scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// A lake, a river, an island, ponds: 6 x 5 cells of 100 m.
    Demo,
    /// One hole of nearly every class in 3 x 3 cells of 100 m.
    Small,
    /// 449 cells of 250 m in an irregular area, 129 holes as in Wang et al. 2021, sec. 4.
    City,
    /// One hole of 57,000 square metres over 2 x 2 cells of 250 m, and one at the edge.
    A,
    /// 8 x 4 cells of 250 m, holes as in Wang et al. 2021, tables 1 and 2.
    B,
    /// The same with the holes of table 3.
    BAdded,
    /// 4 x 2 cells of 250 m that repeat over larger areas.
    Growing,
}

impl Preset {
    /// Triangles a cell unless asked otherwise.
    #[must_use]
    pub fn default_triangles(self) -> u64 {
        match self {
            Self::Demo => 4_000,
            Self::Small => 2_000,
            Self::City => 20_000,
            Self::A => 50_000,
            Self::B | Self::BAdded | Self::Growing => 20_000,
        }
    }

    /// The plan for a seed; `cells` = columns and rows, if not the preset's own.
    ///
    /// # Errors
    /// The preset's holes find no room in so few cells: the message names the smallest number.
    pub fn plan(self, seed: u64, cells: Option<[i64; 2]>) -> Result<Plan, PlanError> {
        let mut rng = Rng::new(&[seed as i64, 0x706c_616e]);
        let mut plan = match self {
            Self::Demo => demo::plan(cells, &mut rng),
            Self::Small => small::plan(cells, &mut rng),
            Self::City => city::plan(cells, &mut rng),
            Self::A => a::plan(cells, &mut rng),
            Self::B => b::plan(false, cells, &mut rng),
            Self::BAdded => b::plan(true, cells, &mut rng),
            Self::Growing => growing::plan(cells, &mut rng),
        }?;
        for (number, hole) in plan.holes.iter_mut().enumerate() {
            hole.id = format!("hole_{:03}", number + 1);
        }
        Ok(plan)
    }
}

/// Why a preset can't be planned.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The holes don't fit.
    #[error(
        "{columns} x {rows} cells are too few for this preset: give --cells {least_columns}x{least_rows} or more"
    )]
    TooFewCells {
        /// Columns asked for.
        columns: i64,
        /// Rows asked for.
        rows: i64,
        /// Columns needed.
        least_columns: i64,
        /// Rows needed.
        least_rows: i64,
    },
    /// Random placing found no room.
    #[error("no room for all holes of this preset in {cells} cells: take another --seed, or more --cells")]
    NoRoom {
        /// Cells of the area.
        cells: usize,
    },
}

/// Columns and rows, checked against the preset's smallest ones (which are also the default).
fn size_or(cells: Option<[i64; 2]>, least: [i64; 2]) -> Result<[i64; 2], PlanError> {
    let [columns, rows] = cells.unwrap_or(least);
    if columns < least[0] || rows < least[1] {
        return Err(PlanError::TooFewCells { columns, rows, least_columns: least[0], least_rows: least[1] });
    }
    Ok([columns, rows])
}

/// Holes of one block of cells that is repeated over a larger area, and those for the area's western edge.
struct Block {
    size: [i64; 2],
    cell_size_m: f64,
    holes: fn(&mut dyn FnMut(Cell, u32) -> Placement, &mut Rng) -> Vec<Hole>,
    edge_holes: fn(&mut dyn FnMut(Cell, u32) -> Placement, &mut Rng) -> Vec<Hole>,
}

impl Block {
    /// The block's holes in every whole block of the area; its edge holes in the westernmost ones.
    fn repeat(&self, [columns, rows]: [i64; 2], rng: &mut Rng) -> Vec<Hole> {
        let [width, height] = self.size;
        let mut all = Vec::new();
        for row in 0..rows / height {
            for column in 0..columns / width {
                let corner = [column * width, row * height];
                let mut at = |cell: Cell, turns| Placement {
                    cell: [corner[0] + cell[0], corner[1] + cell[1]],
                    turns,
                    cell_size_m: self.cell_size_m,
                };
                all.extend((self.holes)(&mut at, rng));
                if column == 0 {
                    all.extend((self.edge_holes)(&mut at, rng));
                }
            }
        }
        all
    }
}
