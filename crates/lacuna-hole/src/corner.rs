//! Grid corners that some tile has a vertex at.

use crate::BorderMode;
use crate::fit::BorderFit;
use crate::plan::{Anchor, corner_key};
use crate::shared::CellView;
use glam::DVec3;
use lacuna_grid::{CellId, Side};
use std::collections::BTreeMap;

/// Boundary vertices that stand at grid corners, where tiles are cut on the line: of the first cell that has one.
pub(crate) fn corner_vertices(
    views: &BTreeMap<CellId, CellView<'_>>,
    fit: &BorderFit,
) -> BTreeMap<String, Anchor> {
    let mut corners: BTreeMap<String, Anchor> = BTreeMap::new();
    if fit.mode == BorderMode::Overrun {
        return corners;
    }
    for (&cell, view) in views {
        for run in &view.coverage.runs {
            let first = view.survey.boundary.edges[run.edges[0] as usize].from;
            let last = run.edges.last().map(|&e| view.survey.boundary.edges[e as usize].to);
            for point in std::iter::once(first).chain(last) {
                let place: DVec3 = view.survey.position(point);
                for side in Side::ALL {
                    if place.truncate().distance(view.domain.corner_after(side)) <= fit.tolerance_m {
                        corners
                            .entry(corner_key(cell.corner_after(side)))
                            .or_insert(Anchor::Point(cell, point));
                    }
                }
            }
        }
    }
    corners
}
