//! The reconstruction area of a run.

use super::RunError;
use super::scan::Scanned;
use crate::PolygonSet;
use crate::config::AreaLimit;
use glam::DVec2;
use lacuna_grid::{Area, AreaLimit as GridLimit, CellId, Grid};
use std::collections::BTreeSet;

/// The area that the settings ask for: the cells that have tiles (unreadable ones too), the box of all vertices, or
/// polygons; then missing cells that lie wholly inside them belong to it too.
/// `margin_m` is how far tiles run past their cells: no cell lies in that margin alone.
///
/// # Errors
/// A box or polygons over more cells than a run can plan.
pub(crate) fn area(
    scanned: &Scanned,
    limit: &AreaLimit,
    srs_origin: DVec2,
    margin_m: f64,
) -> Result<Area, RunError> {
    let present: BTreeSet<CellId> =
        scanned.surveys.keys().chain(scanned.unreadable.keys()).copied().collect();
    let grid = &scanned.grid.grid;
    match limit {
        AreaLimit::Cells => Ok(Area::of_cells(&present)),
        AreaLimit::Box => {
            let b = &scanned.bounds;
            let (low, high) = (b.min.truncate(), b.max.truncate());
            refuse_too_many_cells(grid, low, high, "--area box: the box of all tiles", "give --area cells")?;
            // Walls and fragments reach past the margin by a little.
            let inner = Area::of_box(&present, grid, low + 2.0 * margin_m, high - 2.0 * margin_m);
            Ok(Area { cells: inner.cells, limit: GridLimit::Box(low, high) })
        }
        AreaLimit::Polygon(file) => {
            let polygons = file.in_scene(srs_origin);
            let points = || polygons.rings.iter().flatten();
            let low = points().fold(DVec2::INFINITY, |m, p| m.min(*p));
            let high = points().fold(DVec2::NEG_INFINITY, |m, p| m.max(*p));
            let what = format!("{}: the box of its polygons", file.path.display());
            refuse_too_many_cells(grid, low, high, &what, "check that its coordinates are the scene's")?;
            let meets = |c: &CellId| {
                let (a, b) = grid.rectangle(*c);
                a.cmple(high).all() && b.cmpge(low).all()
            };
            if !present.iter().any(meets) {
                return Err(RunError::usage(format!(
                    "{}: its polygons ({:.0},{:.0} to {:.0},{:.0}) do not touch the scene; check that its coordinates are \
                     the scene's, or give the file a `crs`",
                    file.path.display(),
                    low.x,
                    low.y,
                    high.x,
                    high.y
                )));
            }
            let cells = present.into_iter().chain(cells_inside(&polygons, grid, low, high)).collect();
            Ok(Area { cells, limit: GridLimit::Polygon(polygons.rings) })
        }
    }
}

/// Missing cells of the area take memory and time like those that have tiles.
const MOST_CELLS: f64 = 4e6;

fn refuse_too_many_cells(
    grid: &Grid,
    low: DVec2,
    high: DVec2,
    what: &str,
    advice: &str,
) -> Result<(), RunError> {
    let count = ((high - low) / grid.cell_size_m).ceil().max(DVec2::ZERO);
    let cells = count.x * count.y;
    if cells <= MOST_CELLS || !cells.is_finite() {
        return Ok(());
    }
    Err(RunError::usage(format!(
        "{what} holds {} x {} cells of {} m, more than a run can plan; {advice}, or leave out what lies far off",
        count.x, count.y, grid.cell_size_m
    )))
}

/// Cells whose four corners and middle lie inside the polygons.
fn cells_inside(polygons: &PolygonSet, grid: &Grid, low: DVec2, high: DVec2) -> Vec<CellId> {
    if !(low.is_finite() && high.is_finite()) {
        return Vec::new();
    }
    let (first, last) = (grid.cell_at(low), grid.cell_at(high));
    let all = (first.j..=last.j).flat_map(|j| (first.i..=last.i).map(move |i| CellId::new(i, j)));
    let inside = |cell: &CellId| {
        let (a, b) = grid.rectangle(*cell);
        let corners = [a, DVec2::new(b.x, a.y), b, DVec2::new(a.x, b.y), (a + b) / 2.0];
        corners.into_iter().all(|p| polygons.contains(p))
    };
    all.filter(inside).collect()
}
