//! The reconstruction area of a run.

use super::scan::Scanned;
use crate::config::AreaLimit;
use lacuna_grid::{Area, CellId};
use std::collections::BTreeSet;

/// The area that the settings ask for: the cells that have tiles (unreadable ones too), or the box of all vertices.
pub(crate) fn area(scanned: &Scanned, limit: &AreaLimit) -> Area {
    let present: BTreeSet<CellId> =
        scanned.surveys.keys().chain(scanned.unreadable.keys()).copied().collect();
    match limit {
        AreaLimit::Box => {
            let b = &scanned.bounds;
            Area::of_box(&present, &scanned.grid.grid, b.min.truncate(), b.max.truncate())
        }
        AreaLimit::Cells | AreaLimit::Polygon(_) => Area::of_cells(&present),
    }
}
