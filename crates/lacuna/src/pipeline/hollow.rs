//! Which tile a hollow cell's new tile is made after, and where it will lie.

use super::scan::CellTile;
use lacuna_grid::{CellId, Side};
use lacuna_tile::{Scene, hollow_tile_path};
use std::collections::BTreeMap;

/// Tiles by cell.
type Tiles = BTreeMap<CellId, CellTile>;

/// A template and a path for the tile of every cell of `cells` without one: the 4-neighbour of lowest index that has
/// a tile, else the nearest (decisions 6).
pub(crate) fn hollow_tiles<'a>(
    scene: &Scene,
    tiles: &Tiles,
    cells: impl Iterator<Item = &'a CellId>,
) -> BTreeMap<CellId, (CellId, String)> {
    let missing = cells.filter(|c| !tiles.contains_key(c));
    let planned = missing.filter_map(|&cell| {
        let template = neighbour(tiles, cell).or_else(|| nearest(tiles, cell))?;
        let group = &scene.groups[tiles[&template].group];
        Some((cell, (template, hollow_tile_path(scene, (cell.i, cell.j), group))))
    });
    planned.collect()
}

fn neighbour<T>(tiles: &BTreeMap<CellId, T>, cell: CellId) -> Option<CellId> {
    let beside = Side::ALL.iter().map(|&s| cell.neighbour(s));
    beside.filter(|c| tiles.contains_key(c)).min()
}

/// The tile whose cell is nearest, of equally near ones the first in the order of cells. Looks at two tiles a row, rows
/// near the cell first.
fn nearest<T>(tiles: &BTreeMap<CellId, T>, cell: CellId) -> Option<CellId> {
    let (first, last) = (tiles.keys().next()?.j, tiles.keys().next_back()?.j);
    let most = first.abs_diff(cell.j).max(last.abs_diff(cell.j));
    let mut best: Option<(i64, CellId)> = None;
    for rows in 0..=most.cast_signed() {
        if best.is_some_and(|(distance, _)| i64::from(rows) * i64::from(rows) > distance) {
            break;
        }
        for j in [cell.j.saturating_sub(rows), cell.j.saturating_add(rows)] {
            let east = tiles.range(CellId::new(cell.i, j)..=CellId::new(i32::MAX, j)).next();
            let west = tiles.range(CellId::new(i32::MIN, j)..CellId::new(cell.i, j)).next_back();
            let found = east.into_iter().chain(west).map(|(&c, _)| (distance(cell, c), c));
            best = best.into_iter().chain(found).min();
        }
    }
    best.map(|(_, cell)| cell)
}

/// Squared, in cells.
fn distance(a: CellId, b: CellId) -> i64 {
    let (di, dj) = (i64::from(a.i) - i64::from(b.i), i64::from(a.j) - i64::from(b.j));
    di * di + dj * dj
}

#[cfg(test)]
mod tests {
    use super::{distance, nearest};
    use lacuna_grid::CellId;
    use std::collections::BTreeMap;

    #[test]
    fn the_nearest_of_all_is_found() {
        // A scatter without a pattern: every third or so cell of a square, always the same ones.
        let scattered = |k: &i32| (k * 7919 + 13) % 101 < 31;
        let cells = (0..400).filter(scattered).map(|k| CellId::new(3 * (k % 20) - 30, 2 * (k / 20) - 11));
        let tiles: BTreeMap<CellId, ()> = cells.map(|c| (c, ())).collect();
        for k in 0..900 {
            let cell = CellId::new(k % 30 * 3 - 45, k / 30 - 15);
            let expected = tiles.keys().copied().min_by_key(|c| (distance(cell, *c), *c));
            assert_eq!(nearest(&tiles, cell), expected, "{cell}");
        }
        assert_eq!(nearest(&BTreeMap::<CellId, ()>::new(), CellId::new(0, 0)), None);
    }
}
