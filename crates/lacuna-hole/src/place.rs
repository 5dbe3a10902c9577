//! Where holes lie with respect to a polygon area (decisions 1 to 3).

use crate::box_tree::BoxTree;
use crate::outline::point_inside;
use glam::DVec2;
use lacuna_mesh::{Bounds, Location, Meeting, contains, segments_cross};

/// Where a hole lies in a polygon area.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlaceInArea {
    /// No part of it lies outside; it may touch the area's outline.
    Inside,
    /// No part of it lies inside.
    Outside,
    /// The area's outline runs through it.
    Crosses,
}

/// The rings of a polygon area.
pub(crate) struct AreaOutline<'a> {
    rings: &'a [Vec<DVec2>],
    edges: Vec<[DVec2; 2]>,
    tree: BoxTree,
}

impl<'a> AreaOutline<'a> {
    pub(crate) fn new(rings: &'a [Vec<DVec2>]) -> Self {
        let edges: Vec<[DVec2; 2]> = rings.iter().flat_map(|r| edges_of(r)).collect();
        let tree = BoxTree::new(edges.iter().map(|e| bounds_of(e)));
        Self { rings, edges, tree }
    }

    /// Where a hole with this outline lies: edge by edge, since a corner of the area can lie in a hole whose vertices are
    /// all on one side.
    pub(crate) fn place(&self, outline: &[DVec2]) -> PlaceInArea {
        let Some(&first) = outline.first() else { return PlaceInArea::Inside };
        let near: Vec<[DVec2; 2]> =
            self.tree.touching(&bounds_of(outline)).into_iter().map(|k| self.edges[k]).collect();
        if near.is_empty() {
            // Not even the boxes meet: all of the hole lies where its first vertex does.
            return if self.holds(first) == Location::Inside {
                PlaceInArea::Inside
            } else {
                PlaceInArea::Outside
            };
        }
        let crosses =
            |&[a, b]: &[DVec2; 2]| near.iter().any(|&[c, d]| segments_cross(a, b, c, d) == Meeting::Crossing);
        // Of an outline that runs through vertices of the area's, the middles of the edges tell; of the area's own, a point
        // within.
        let middles = edges_of(outline).map(|[a, b]| (a + b) / 2.0);
        let sides: Vec<Location> = outline
            .iter()
            .copied()
            .chain(middles)
            .chain([point_inside(outline)])
            .map(|p| self.holds(p))
            .collect();
        let (is_in, is_out) = (sides.contains(&Location::Inside), sides.contains(&Location::Outside));
        let encloses = near.iter().any(|e| contains(outline, e[0]) == Location::Inside);
        if is_in && is_out || encloses || edges_of(outline).any(|e| crosses(&e)) {
            PlaceInArea::Crosses
        } else if is_out {
            PlaceInArea::Outside
        } else {
            PlaceInArea::Inside
        }
    }

    /// Where a point lies, by the even-odd rule over all rings.
    fn holds(&self, point: DVec2) -> Location {
        let places = || self.rings.iter().map(|ring| contains(ring, point));
        if places().any(|l| l == Location::OnEdge) {
            return Location::OnEdge;
        }
        let around = places().filter(|l| *l == Location::Inside).count();
        if around % 2 == 1 { Location::Inside } else { Location::Outside }
    }
}

fn edges_of(ring: &[DVec2]) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    (0..ring.len()).map(|k| [ring[k], ring[(k + 1) % ring.len()]])
}

fn bounds_of(points: &[DVec2]) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    points.iter().for_each(|p| bounds.add(p.extend(0.0)));
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, size: f64) -> Vec<DVec2> {
        [(0.0, 0.0), (size, 0.0), (size, size), (0.0, size)]
            .map(|(dx, dy)| DVec2::new(x + dx, y + dy))
            .to_vec()
    }

    #[test]
    fn holes_in_on_and_beside_an_area() {
        let outer = square(0.0, 0.0, 100.0);
        let court = square(40.0, 40.0, 20.0);
        let spike: Vec<DVec2> = [(0.0, 0.0), (100.0, 50.0), (0.0, 100.0)].map(DVec2::from).to_vec();
        let strip: Vec<DVec2> =
            [(0.0, 45.0), (100.0, 45.0), (100.0, 55.0), (0.0, 55.0)].map(DVec2::from).to_vec();
        for (name, rings, hole, expected) in [
            ("well inside", vec![outer.clone()], square(10.0, 10.0, 5.0), PlaceInArea::Inside),
            ("inside, touching an edge", vec![outer.clone()], square(0.0, 10.0, 5.0), PlaceInArea::Inside),
            ("the area itself", vec![outer.clone()], outer.clone(), PlaceInArea::Inside),
            ("well outside", vec![outer.clone()], square(200.0, 10.0, 5.0), PlaceInArea::Outside),
            (
                "outside, touching an edge",
                vec![outer.clone()],
                square(100.0, 10.0, 5.0),
                PlaceInArea::Outside,
            ),
            (
                "outside, touching a corner",
                vec![outer.clone()],
                square(100.0, 100.0, 5.0),
                PlaceInArea::Outside,
            ),
            ("over an edge", vec![outer.clone()], square(95.0, 10.0, 10.0), PlaceInArea::Crosses),
            ("a corner of the area in it", vec![spike], square(90.0, 30.0, 40.0), PlaceInArea::Crosses),
            ("through it, no vertex in it", vec![strip], square(40.0, 30.0, 40.0), PlaceInArea::Crosses),
            ("the area in it", vec![square(5.0, 5.0, 1.0)], square(0.0, 0.0, 10.0), PlaceInArea::Crosses),
            ("in a court", vec![outer.clone(), court.clone()], square(45.0, 45.0, 5.0), PlaceInArea::Outside),
            ("the court", vec![outer.clone(), court.clone()], court.clone(), PlaceInArea::Outside),
            ("round a court", vec![outer, court], square(30.0, 30.0, 40.0), PlaceInArea::Crosses),
        ] {
            assert_eq!(AreaOutline::new(&rings).place(&hole), expected, "{name}");
        }
    }
}
