//! Where holes lie with respect to a polygon area.

use glam::DVec2;
use lacuna_mesh::{Location, contains};

/// Where a hole lies in a polygon area.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlaceInArea {
    Inside,
    Outside,
    Crosses,
}

pub(crate) fn place_in_area(outline: &[DVec2], rings: &[Vec<DVec2>]) -> PlaceInArea {
    let is_inside =
        |p: &DVec2| rings.iter().filter(|ring| contains(ring, *p) != Location::Outside).count() % 2 == 1;
    let inside = outline.iter().filter(|p| is_inside(p)).count();
    match inside {
        0 => PlaceInArea::Outside,
        n if n == outline.len() => PlaceInArea::Inside,
        _ => PlaceInArea::Crosses,
    }
}
