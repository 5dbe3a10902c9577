//! Plane geometry that several stages share: polygons that users give, and boxes of tiles.

use glam::DVec2;
use lacuna_grid::{CellId, Grid};
use lacuna_mesh::{Bounds, Location, contains};

/// The box of a tile without what lies more than a cell's size past its cell: no tile reaches that far, but a stray vertex
/// does, and one of them must not stretch the scene.
pub(crate) fn box_near_cell(bounds: &Bounds, grid: &Grid, cell: CellId) -> Bounds {
    let (low, high) = grid.rectangle(cell);
    let near = |p: glam::DVec3| {
        let plan = p.truncate().clamp(low - grid.cell_size_m, high + grid.cell_size_m);
        plan.extend(p.z)
    };
    if bounds.is_empty() { *bounds } else { Bounds { min: near(bounds.min), max: near(bounds.max) } }
}

/// Rings in scene coordinates; a point is inside if an odd number of rings holds it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonSet {
    /// Closed rings without a repeated last point.
    pub rings: Vec<Vec<DVec2>>,
}

impl PolygonSet {
    /// True if the point lies inside or on the outline.
    #[must_use]
    pub fn contains(&self, point: DVec2) -> bool {
        let mut inside = false;
        for ring in &self.rings {
            match contains(ring, point) {
                Location::OnEdge => return true,
                Location::Inside => inside = !inside,
                Location::Outside => {}
            }
        }
        inside
    }
}
