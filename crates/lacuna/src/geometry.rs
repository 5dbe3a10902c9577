//! Polygons that users give: areas and regions from GeoJSON files.

use glam::DVec2;
use lacuna_mesh::{Location, contains};

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
