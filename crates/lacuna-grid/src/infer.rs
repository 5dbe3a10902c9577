//! The grid from the names and boxes of the tiles (formats.md section 2, "grid inference").

use crate::{CellId, Grid};
use glam::DVec2;
use std::collections::BTreeMap;
use thiserror::Error;

/// Name index and plan box of one tile.
#[derive(Clone, Debug, PartialEq)]
pub struct TileBox {
    /// What messages call the tile.
    pub name: String,
    /// Column and row from the name.
    pub index: Option<(i32, i32)>,
    /// True if the name wrote the index with signs; unsigned numbers count only if the boxes agree.
    pub signed: bool,
    /// South-west corner of the box of its vertices.
    pub low: DVec2,
    /// North-east corner.
    pub high: DVec2,
}

/// What the user said.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GridHints {
    /// `--cell-size`.
    pub cell_size_m: Option<f64>,
    /// `--cell-origin`.
    pub origin: Option<DVec2>,
}

/// A grid and the cell of every tile, in the order of the input.
#[derive(Clone, Debug, PartialEq)]
pub struct InferredGrid {
    /// Origin and size.
    pub grid: Grid,
    /// Cell of each tile; `None` if neither its name nor a vertex says which.
    pub cells: Vec<Option<CellId>>,
    /// True if the cells come from the names, false if from the boxes.
    pub from_names: bool,
    /// True if nobody said the cell size: the user should be told the numbers.
    pub size_inferred: bool,
    /// True if nobody said the origin.
    pub origin_inferred: bool,
}

/// Why there is no grid.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GridError {
    /// No tile has a finite vertex.
    #[error("no tile holds a finite vertex, so no grid can be found; give --cell-size and --cell-origin")]
    NoBoxes,
    /// Two tiles lie in one cell.
    #[error(
        "tiles {0} and {1} both lie in {2}; leave one of them out, or give --cell-size and --cell-origin if the inferred \
         grid is wrong"
    )]
    TwoTiles(String, String, CellId),
    /// A cell number that no scene has.
    #[error(
        "tile {0} lies too many cells out to be one of the scene; rename it, mend its stray vertices, or leave it out"
    )]
    FarIndex(String),
    /// A box that is no cell's.
    #[error(
        "tile {name} is {width_m:.0} m wide where others are {usual_m:.0} m, so its box does not tell its cell; mend its \
         stray vertices, or leave it out"
    )]
    OddBox {
        /// The tile.
        name: String,
        /// Longer side of its box, metres.
        width_m: f64,
        /// Median of the longer sides of all boxes, metres.
        usual_m: f64,
    },
    /// The flags make no sense.
    #[error("the cell size must be a positive number of metres, not {0}")]
    BadSize(f64),
}

/// Largest cell number of a name, either sign.
const LARGEST_INDEX: u32 = 1_000_000;

/// True if a cell number of a name is one that a scene may have.
#[must_use]
pub fn is_near_index((i, j): (i32, i32)) -> bool {
    i.unsigned_abs() <= LARGEST_INDEX && j.unsigned_abs() <= LARGEST_INDEX
}

/// Largest cell number of a box: places far from a grid's corner are many small cells out.
const LARGEST_BOX_INDEX: u32 = 1 << 30;

/// A box so many times as wide as the others is not one cell's.
const ODD_WIDTHS: f64 = 4.0;

/// Finds origin, size and the cell of every tile.
///
/// Steps: names give the index (unsigned ones only if the boxes agree with one grid); size = median over neighbouring
/// pairs of the step of the box centres' sides over the index step; origin = median of (box middle - index middle).
/// Without names: size = the median of the longer box sides rounded, cells by the box middles. Boxes without vertices
/// say nothing.
///
/// # Errors
/// No boxes, two tiles in one cell, a tile too far out, a box too wide to be a cell's, or a size that is not positive.
pub fn infer_grid(tiles: &[TileBox], hints: GridHints) -> Result<InferredGrid, GridError> {
    if let Some(size) = hints.cell_size_m
        && !(size.is_finite() && size > 0.0)
    {
        return Err(GridError::BadSize(size));
    }
    if !tiles.iter().any(has_box) {
        return Err(GridError::NoBoxes);
    }
    let (grid, cells, from_names) = match by_names(tiles, hints)? {
        Some((grid, cells)) => (grid, cells, true),
        None => {
            let (grid, cells) = by_boxes(tiles, hints)?;
            (grid, cells, false)
        }
    };
    refuse_two_tiles(tiles, &cells)?;
    Ok(InferredGrid {
        grid,
        cells,
        from_names,
        size_inferred: hints.cell_size_m.is_none(),
        origin_inferred: hints.origin.is_none(),
    })
}

type Cells = Vec<Option<CellId>>;

/// Grid and cells, if all names hold an index that can be believed.
fn by_names(tiles: &[TileBox], hints: GridHints) -> Result<Option<(Grid, Cells)>, GridError> {
    if tiles.iter().any(|t| t.index.is_none()) {
        return Ok(None);
    }
    let grid = grid_from_names(tiles, hints);
    let signed = tiles.iter().all(|t| t.signed);
    if !signed && !boxes_agree(tiles, &grid) {
        return Ok(None);
    }
    let cells: Cells = tiles.iter().map(|t| t.index.map(|(i, j)| CellId::new(i, j))).collect();
    refuse_far(tiles, &cells, LARGEST_INDEX)?;
    Ok(Some((grid, cells)))
}

fn by_boxes(tiles: &[TileBox], hints: GridHints) -> Result<(Grid, Cells), GridError> {
    let usual_m = usual_width(tiles);
    let odd = |t: &&TileBox| has_box(t) && width(t) > ODD_WIDTHS * usual_m;
    if let Some(tile) = tiles.iter().find(odd) {
        return Err(GridError::OddBox { name: tile.name.clone(), width_m: width(tile), usual_m });
    }
    let grid = grid_from_boxes(tiles, hints);
    let cell = |t: &TileBox| has_box(t).then(|| grid.cell_at((t.low + t.high) / 2.0));
    let cells: Cells = tiles.iter().map(cell).collect();
    refuse_far(tiles, &cells, LARGEST_BOX_INDEX)?;
    Ok((grid, cells))
}

fn refuse_far(tiles: &[TileBox], cells: &[Option<CellId>], largest: u32) -> Result<(), GridError> {
    let is_far = |cell: &CellId| cell.i.unsigned_abs().max(cell.j.unsigned_abs()) > largest;
    match tiles.iter().zip(cells).find(|(_, cell)| cell.as_ref().is_some_and(is_far)) {
        Some((tile, _)) => Err(GridError::FarIndex(tile.name.clone())),
        None => Ok(()),
    }
}

/// Longer side of a tile's box, metres.
fn width(tile: &TileBox) -> f64 {
    (tile.high - tile.low).max_element()
}

/// Median of the longer sides of all boxes, metres: one odd box changes nothing.
fn usual_width(tiles: &[TileBox]) -> f64 {
    median(tiles.iter().filter(|t| has_box(t)).map(width).collect()).unwrap_or(0.0)
}

fn has_box(tile: &TileBox) -> bool {
    tile.low.is_finite() && tile.high.is_finite() && tile.low.x <= tile.high.x
}

fn grid_from_names(tiles: &[TileBox], hints: GridHints) -> Grid {
    let boxed: Vec<_> = tiles.iter().filter(|t| has_box(t)).collect();
    let cell_size_m = hints.cell_size_m.unwrap_or_else(|| {
        let steps = steps_over_indices(&boxed);
        tidy(median(steps).unwrap_or_else(|| usual_width(tiles)))
    });
    let origin = hints.origin.unwrap_or_else(|| {
        let axis = |pick: fn(DVec2) -> f64| {
            // The middle of a full tile is the middle of its cell, whatever the overrun; partly filled tiles at the
            // scene's edge are outvoted, because their box is smaller.
            let full: Vec<f64> = boxed
                .iter()
                .filter(|t| pick(t.high - t.low) >= 0.98 * cell_size_m)
                .map(|t| pick((t.low + t.high) / 2.0) - (pick(index_vector(t)) + 0.5) * cell_size_m)
                .collect();
            let any =
                || median(boxed.iter().map(|t| pick(t.low) - pick(index_vector(t)) * cell_size_m).collect());
            tidy_origin(median(full).or_else(any).unwrap_or(0.0), cell_size_m)
        };
        DVec2::new(axis(|v| v.x), axis(|v| v.y))
    });
    Grid { origin, cell_size_m }
}

fn index_vector(tile: &TileBox) -> DVec2 {
    let (i, j) = tile.index.unwrap_or((0, 0));
    DVec2::new(f64::from(i), f64::from(j))
}

/// Steps of equal box sides between tiles that follow each other in a row or column, per index step.
fn steps_over_indices(tiles: &[&TileBox]) -> Vec<f64> {
    let mut steps = Vec::new();
    for axis in 0..2 {
        let mut lines: BTreeMap<i32, Vec<(i32, f64, f64)>> = BTreeMap::new();
        for tile in tiles {
            let (i, j) = tile.index.unwrap_or((0, 0));
            let (key, order) = if axis == 0 { (j, i) } else { (i, j) };
            lines.entry(key).or_default().push((order, tile.low[axis], tile.high[axis]));
        }
        for line in lines.values_mut() {
            line.sort_by_key(|t| t.0);
            for pair in line.windows(2) {
                let count = f64::from(pair[1].0) - f64::from(pair[0].0);
                if count > 0.0 {
                    steps.extend([(pair[1].1 - pair[0].1) / count, (pair[1].2 - pair[0].2) / count]);
                }
            }
        }
    }
    steps.retain(|s| *s > 0.0);
    steps
}

fn grid_from_boxes(tiles: &[TileBox], hints: GridHints) -> Grid {
    let usual_m = usual_width(tiles);
    let cell_size_m = hints.cell_size_m.unwrap_or_else(|| round_size(usual_m));
    let lowest = |is_full: bool| {
        // A full tile's corner is its cell's corner; a partly filled one's lies anywhere in it.
        let counts =
            |t: &&TileBox| has_box(t) && (!is_full || (t.high - t.low).min_element() >= 0.98 * usual_m);
        tiles.iter().filter(counts).fold(DVec2::INFINITY, |m, t| m.min(t.low))
    };
    let low = Some(lowest(true)).filter(|l| l.is_finite()).unwrap_or_else(|| lowest(false));
    // A margin beyond the cell (overrun) moves the lowest corner out by half of what the boxes exceed the cell.
    let margin = ((usual_m - cell_size_m) / 2.0).max(0.0);
    let origin = hints.origin.unwrap_or_else(|| {
        DVec2::new(tidy_origin(low.x + margin, cell_size_m), tidy_origin(low.y + margin, cell_size_m))
    });
    Grid { origin, cell_size_m }
}

/// True if at least nine of ten tiles lie in the cell of their name, within 2 % of its size.
fn boxes_agree(tiles: &[TileBox], grid: &Grid) -> bool {
    let boxed: Vec<_> = tiles.iter().filter(|t| has_box(t)).collect();
    let slack = 0.02 * grid.cell_size_m;
    let agree = boxed
        .iter()
        .filter(|t| {
            let low = grid.origin + index_vector(t) * grid.cell_size_m;
            (t.low - low).min_element() >= -slack && (low + grid.cell_size_m - t.high).min_element() >= -slack
        })
        .count();
    agree * 10 >= boxed.len() * 9
}

fn refuse_two_tiles(tiles: &[TileBox], cells: &[Option<CellId>]) -> Result<(), GridError> {
    let mut first: BTreeMap<CellId, &str> = BTreeMap::new();
    for (tile, cell) in tiles.iter().zip(cells).filter_map(|(t, c)| Some((t, (*c)?))) {
        if let Some(other) = first.insert(cell, &tile.name) {
            return Err(GridError::TwoTiles(other.to_owned(), tile.name.clone(), cell));
        }
    }
    Ok(())
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    Some(if values.len() % 2 == 1 { values[middle] } else { (values[middle - 1] + values[middle]) / 2.0 })
}

/// A size within a tenth of a per mille of a millimetre multiple is that multiple.
fn tidy(size: f64) -> f64 {
    for digits in [1.0, 10.0, 100.0, 1000.0] {
        let rounded = (size * digits).round() / digits;
        if rounded > 0.0 && (size - rounded).abs() <= 1e-4 * size {
            return rounded;
        }
    }
    size
}

/// An origin within a thousandth of a cell of a multiple of 0.5 m (1 cm, 1 mm) is that multiple.
fn tidy_origin(value: f64, cell_size_m: f64) -> f64 {
    for step in [0.5, 0.01, 0.001] {
        let rounded = (value / step).round() * step;
        if (value - rounded).abs() <= (3e-4 * cell_size_m).min(step / 10.0) {
            return rounded + 0.0;
        }
    }
    value
}

/// The largest "round" cell size that a box of this width may overrun by up to 2 %.
fn round_size(widest: f64) -> f64 {
    let unit = 10f64.powi((widest.log10().floor() as i32) - 1);
    for step in [10.0, 5.0, 2.5, 1.0] {
        let size = (widest / (unit * step)).round() * unit * step;
        if size > 0.0 && (widest - size).abs() <= 0.02 * size {
            return size;
        }
    }
    widest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(index: Option<(i32, i32)>, signed: bool, low: (f64, f64), high: (f64, f64)) -> TileBox {
        let name = format!("{index:?}{low:?}");
        TileBox { name, index, signed, low: low.into(), high: high.into() }
    }

    fn row(overrun: f64, size: f64, origin: f64, signed: bool) -> Vec<TileBox> {
        (0..4)
            .flat_map(|i| (0..3).map(move |j| (i, j)))
            .map(|(i, j)| {
                let low = (origin + f64::from(i) * size - overrun, origin + f64::from(j) * size - overrun);
                tile(Some((i, j)), signed, low, (low.0 + size + 2.0 * overrun, low.1 + size + 2.0 * overrun))
            })
            .collect()
    }

    #[test]
    fn names_and_boxes_give_size_and_origin() {
        for (name, overrun, size, origin, signed) in [
            ("exact", 0.0, 250.0, 0.0, true),
            ("overrun", 0.1, 100.0, 0.0, true),
            ("odd size, origin far out", 0.193, 200.0, 497_400.0, true),
            ("unsigned names that agree", 0.0, 50.0, 12.5, false),
        ] {
            let found = infer_grid(&row(overrun, size, origin, signed), GridHints::default()).expect(name);
            assert!((found.grid.cell_size_m - size).abs() < 1e-9, "{name}: {:?}", found.grid);
            assert!((found.grid.origin - DVec2::splat(origin)).length() < 1e-6, "{name}: {:?}", found.grid);
            assert!(found.from_names, "{name}");
            assert_eq!(found.cells[4], Some(CellId::new(1, 1)), "{name}");
        }
    }

    #[test]
    fn ragged_outer_tiles_are_outvoted() {
        let mut tiles = row(0.0, 50.0, 0.0, true);
        for t in tiles.iter_mut().filter(|t| t.index == Some((3, 0))) {
            t.high.x -= 36.0;
        }
        let found = infer_grid(&tiles, GridHints::default()).expect("grid");
        assert_eq!(found.grid, Grid { origin: DVec2::ZERO, cell_size_m: 50.0 });
    }

    #[test]
    fn unsigned_numbers_that_disagree_with_the_boxes_are_ignored() {
        let mut tiles = row(0.0, 100.0, 0.0, false);
        for (k, t) in tiles.iter_mut().enumerate() {
            t.index = Some((k as i32, 7));
        }
        let found = infer_grid(&tiles, GridHints::default()).expect("grid");
        assert!(!found.from_names);
        assert_eq!(found.grid.cell_size_m, 100.0);
    }

    #[test]
    fn one_odd_tile_does_not_turn_a_grid_without_names() {
        let unnamed = |mut tiles: Vec<TileBox>| {
            tiles.iter_mut().for_each(|t| t.index = None);
            tiles
        };
        let grid = Grid { origin: DVec2::ZERO, cell_size_m: 100.0 };
        let mut tiles = unnamed(row(0.1, 100.0, 0.0, false));
        let clean = infer_grid(&tiles, GridHints::default()).expect("grid");
        assert_eq!(clean.grid, grid);
        // A half-empty tile in the south-west, one that is a little too wide, one without vertices, a date as a name.
        tiles[0].low = DVec2::splat(41.0);
        tiles[5].high.x += 60.0;
        let empty = (f64::INFINITY, f64::NEG_INFINITY);
        tiles.push(tile(None, false, (empty.0, empty.0), (empty.1, empty.1)));
        tiles[7].index = Some((20_240_101, 7));
        let found = infer_grid(&tiles, GridHints::default()).expect("grid");
        assert_eq!(found.grid, grid);
        assert_eq!(found.cells[..12], clean.cells[..]);
        assert_eq!(found.cells[12], None, "nothing says where it lies");
    }

    #[test]
    fn a_stray_vertex_names_its_tile_where_boxes_are_all_there_is() {
        let mut tiles = row(0.0, 100.0, 0.0, true);
        tiles[5].high.x = 1e9;
        let named = infer_grid(&tiles, GridHints::default()).expect("names tell the cells");
        assert_eq!(named.grid, Grid { origin: DVec2::ZERO, cell_size_m: 100.0 });
        tiles.iter_mut().for_each(|t| t.index = None);
        let error = infer_grid(&tiles, GridHints::default()).expect_err("no cell is that wide");
        assert!(error.to_string().contains(&tiles[5].name), "{error}");
    }

    #[test]
    fn flags_win() {
        let hints = GridHints { cell_size_m: Some(25.0), origin: Some(DVec2::new(1.0, 2.0)) };
        let found = infer_grid(&row(0.0, 25.0, 1.0, true), hints).expect("grid");
        assert_eq!(found.grid, Grid { origin: DVec2::new(1.0, 2.0), cell_size_m: 25.0 });
        assert!(!found.size_inferred && !found.origin_inferred);
    }

    #[test]
    fn what_cannot_be_is_an_error() {
        let twice = vec![tile(Some((0, 0)), true, (0.0, 0.0), (9.0, 9.0)); 2];
        assert!(matches!(infer_grid(&twice, GridHints::default()), Err(GridError::TwoTiles(..))));
        assert_eq!(infer_grid(&[], GridHints::default()), Err(GridError::NoBoxes));
        let bad = GridHints { cell_size_m: Some(-1.0), origin: None };
        assert_eq!(infer_grid(&twice, bad), Err(GridError::BadSize(-1.0)));
    }
}
