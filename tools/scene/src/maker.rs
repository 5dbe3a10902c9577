//! Makes any cell of a scene alone.

use crate::area::Cell;
use crate::encode::{Format, Origin};
use crate::frame::Frame;
use crate::hole::Hole;
use crate::lattice::{Cut, Lattice, LatticeRule, UNITS_PER_M};
use crate::order::{renumber_vertices, shuffle_triangles};
use crate::plan::Plan;
use crate::preset::{PlanError, Preset};
use crate::random::Rng;
use crate::removal::{HALO, Numbered, remove};
use crate::terrain::{Terrain, buildings, height_units};
use crate::tile::{CellScene, Tile, gather};

/// How tiles meet, as asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CutOption {
    /// Shared border vertices.
    Exact,
    /// Tiles run so many metres past their cells.
    Overrun(f64),
    /// Border vertices stray up to so many metres.
    Ragged(f64),
}

/// What to make.
#[derive(Clone, Debug)]
pub struct MakeOptions {
    /// Holes and cells.
    pub preset: Preset,
    /// Triangles a cell, about (2 n^2 are made); the preset's own if `None`.
    pub triangles: Option<u64>,
    /// File format.
    pub format: Format,
    /// Seed of everything random.
    pub seed: u64,
    /// How tiles meet.
    pub cut: CutOption,
    /// Added to x and y, metres; needs a format of double precision.
    pub shift_m: [f64; 2],
    /// Quarter turns to the left.
    pub turns: u32,
    /// Swaps east and west (before turning).
    pub mirror: bool,
    /// Random order of triangles and of their first corners.
    pub shuffle: bool,
    /// Random order of vertices.
    pub renumber: bool,
    /// Columns and rows; the preset's own if `None`.
    pub cells: Option<[i64; 2]>,
    /// Buildings tried in each cell (those near holes are left out).
    pub buildings: u32,
}

impl MakeOptions {
    /// A preset in binary PLY, seed 1, exact borders.
    #[must_use]
    pub fn new(preset: Preset) -> Self {
        Self {
            preset,
            triangles: None,
            format: Format::Ply,
            seed: 1,
            cut: CutOption::Exact,
            shift_m: [0.0; 2],
            turns: 0,
            mirror: false,
            shuffle: false,
            renumber: false,
            cells: None,
            buildings: 0,
        }
    }
}

/// Why a scene can't be made.
#[derive(Debug, thiserror::Error)]
pub enum OptionError {
    /// The preset's holes have no room.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Too few or too many triangles.
    #[error("{triangles} triangles a cell: give 128 to 20,000,000")]
    Triangles {
        /// As asked for.
        triangles: u64,
    },
    /// A shift in single precision.
    #[error("a shift would be rounded in this format: take --format obj or ply-double")]
    ShiftInSinglePrecision,
    /// Too large a scene for single precision.
    #[error(
        "{width_m} m are too wide for exact single precision (16,384 m): take --format obj, glb or ply-double"
    )]
    TooWide {
        /// Larger side of the scene, metres.
        width_m: f64,
    },
    /// A margin that the triangles can't follow.
    #[error(
        "borders may move by 0 to {most_m:.3} m at this triangle size, not {asked_m} m: lower it or take fewer --triangles"
    )]
    CutTooWide {
        /// As asked for, metres.
        asked_m: f64,
        /// Largest possible, metres.
        most_m: f64,
    },
}

/// The rims of a cell could not be cleaned.
#[derive(Debug, thiserror::Error)]
#[error(
    "cell {cell:?}: its rims are still pinched after the clean-up; take more --triangles or another --seed"
)]
pub struct PinchedError {
    /// The cell, as planned.
    pub cell: Cell,
}

/// A planned scene, ready to make any of its cells.
#[derive(Debug)]
pub struct Maker {
    options: MakeOptions,
    plan: Plan,
    rule: LatticeRule,
    terrain: Terrain,
    frame: Frame,
}

impl Maker {
    /// Plans a scene.
    ///
    /// # Errors
    /// Options that contradict each other or the preset; the message says which to change.
    pub fn new(options: MakeOptions) -> Result<Self, OptionError> {
        let plan = options.preset.plan(options.seed, options.cells)?;
        let quads = quads_for(options.triangles.unwrap_or(options.preset.default_triangles()))?;
        let cell_size = (plan.cell_size_m * UNITS_PER_M).round() as i64;
        let cut = cut_in_units(options.cut, plan.cell_size_m / quads as f64)?;
        let seed = options.seed as i64;
        let rule = LatticeRule { quads, cell_size, cut, seed };
        let size = [plan.area.columns(), plan.area.rows()];
        let frame = Frame { size, cell_size, mirror: options.mirror, turns: options.turns % 4 };
        check_precision(&options, size, plan.cell_size_m)?;
        let terrain = Terrain::new(&plan, seed);
        Ok(Self { options, plan, rule, terrain, frame })
    }

    /// The plan.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The options.
    #[must_use]
    pub fn options(&self) -> &MakeOptions {
        &self.options
    }

    /// How the scene is turned.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Triangles of a cell without holes.
    #[must_use]
    pub fn triangles_per_cell(&self) -> i64 {
        2 * self.rule.quads * self.rule.quads
    }

    /// How far tiles run past their cells, metres.
    #[must_use]
    pub fn overrun_m(&self) -> f64 {
        match self.rule.cut {
            Cut::Overrun { margin } => margin as f64 / UNITS_PER_M,
            _ => 0.0,
        }
    }

    /// Makes one cell, not yet turned or reordered.
    ///
    /// # Errors
    /// [`PinchedError`] if its rims can't be cleaned.
    pub fn cell(&self, cell: Cell) -> Result<CellScene, PinchedError> {
        let step_m = self.plan.cell_size_m / self.rule.quads as f64;
        let exact = self.rule.cut == Cut::Exact;
        let reach_m = if exact { (HALO + 1) as f64 * step_m } else { 2.0 * step_m + self.overrun_m() };
        let holes: Vec<Numbered> =
            (0..).zip(&self.plan.holes).filter(|(_, h)| self.may_touch(h, cell, reach_m)).collect();
        let lattice = Lattice::new(&self.rule, cell, if exact && !holes.is_empty() { HALO } else { 0 });
        let states = remove(&lattice, &self.plan.area, &holes).ok_or(PinchedError { cell })?;
        let wanted = self.options.buildings;
        let blocks = buildings(&self.plan, &self.terrain, cell, wanted, 4.0 * step_m, self.rule.seed);
        Ok(gather(&lattice, &states, &self.plan.area, |node| height_units(&self.terrain, &blocks, node)))
    }

    fn may_touch(&self, hole: &Hole, cell: Cell, reach_m: f64) -> bool {
        let size = self.plan.cell_size_m;
        let low = cell.map(|k| k as f64 * size - reach_m);
        let high = cell.map(|k| (k + 1) as f64 * size + reach_m);
        hole.may_touch(low, high, size)
    }

    /// The tile as it goes into its file: reordered and turned.
    #[must_use]
    pub fn finished_tile(&self, scene: &CellScene) -> Tile {
        let mut tile = scene.tile.clone();
        let mut rng = Rng::new(&[self.rule.seed, 0x6f72_6472, scene.cell[0], scene.cell[1]]);
        if self.options.shuffle {
            shuffle_triangles(&mut tile, &mut rng);
        }
        if self.options.renumber {
            renumber_vertices(&mut tile, &mut rng);
        }
        self.frame.turn(&mut tile);
        tile
    }

    /// The tile's file name without extension.
    #[must_use]
    pub fn tile_name(&self, cell: Cell) -> String {
        let [i, j] = self.frame.cell(cell);
        format!("Tile_{i:+04}_{j:+04}")
    }

    /// The bytes of the tile's file.
    #[must_use]
    pub fn encode(&self, scene: &CellScene) -> Vec<u8> {
        let corner = self.frame.cell(scene.cell).map(|k| k * self.rule.cell_size);
        let origin = Origin { corner, shift_m: self.options.shift_m };
        self.options.format.encode(&self.finished_tile(scene), &origin)
    }
}

fn quads_for(triangles: u64) -> Result<i64, OptionError> {
    if !(128..=20_000_000).contains(&triangles) {
        return Err(OptionError::Triangles { triangles });
    }
    Ok((triangles as f64 / 2.0).sqrt().round() as i64)
}

fn cut_in_units(cut: CutOption, step_m: f64) -> Result<Cut, OptionError> {
    let units = |asked_m: f64| {
        let most_m = 0.4 * step_m;
        let fits = asked_m > 0.0 && asked_m <= most_m;
        fits.then_some((asked_m * UNITS_PER_M).round() as i64)
            .ok_or(OptionError::CutTooWide { asked_m, most_m })
    };
    Ok(match cut {
        CutOption::Exact => Cut::Exact,
        CutOption::Overrun(m) => Cut::Overrun { margin: units(m)? },
        CutOption::Ragged(m) => Cut::Ragged { reach: units(m)? },
    })
}

fn check_precision(options: &MakeOptions, size: [i64; 2], cell_size_m: f64) -> Result<(), OptionError> {
    let width_m = size[0].max(size[1]) as f64 * cell_size_m;
    if options.shift_m != [0.0; 2] && !options.format.holds_large_coordinates() {
        return Err(OptionError::ShiftInSinglePrecision);
    }
    if options.format.is_single_precision() && width_m >= 16_384.0 {
        return Err(OptionError::TooWide { width_m });
    }
    Ok(())
}
