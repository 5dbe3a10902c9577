//! Closed loops: holes, outlines of loose pieces, and what only looks like a hole (algorithms note A.2, B.5, B.7).

use crate::box_tree::BoxTree;
use crate::{CellSurvey, LoopSurvey};
use glam::DVec2;
use lacuna_mesh::{Bounds, Location, contains, signed_area};
use serde::{Deserialize, Serialize};

/// Mean width below which a loop is a slit, metres.
const SLIT_WIDTH_M: f64 = 0.005;

/// What only looks like a hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NotHole {
    /// Two rims that touch all along.
    Slit,
    /// The mouth of a tube: a passage, a courtyard, a shaft; its rim's triangles stand across the opening.
    Passage,
    /// The outline of a loose piece of surface.
    Floater,
    /// A cut inside the tile whose two sides do not weld.
    InnerCut,
    /// The outline of an overhang at the cell's border.
    Overhang,
}

/// What a closed loop is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LoopKind {
    Hole,
    /// An outline of a piece of surface seen from above: an island if it lies inside a hole.
    Outline,
    Not(NotHole),
}

/// Judges one closed loop by its vector area and the triangles behind it.
pub(crate) fn judge_loop(l: &LoopSurvey) -> LoopKind {
    let area = l.vector_area.length();
    if 2.0 * area < SLIT_WIDTH_M * l.length_m {
        return LoopKind::Not(NotHole::Slit);
    }
    if l.sheetness <= -0.3 {
        // The triangles behind face against the loop's own side: the loop runs round a piece of surface.
        return if l.vector_area.z < -0.15 * area {
            LoopKind::Outline
        } else {
            LoopKind::Not(NotHole::Floater)
        };
    }
    if l.sheetness < 0.3 {
        return if l.vector_area.z < -0.15 * area {
            LoopKind::Outline
        } else {
            LoopKind::Not(NotHole::Passage)
        };
    }
    if l.vector_area.z < -0.15 * area {
        // A hole in a sheet that faces down: the underside of a bridge or balcony.
        return LoopKind::Not(NotHole::Overhang);
    }
    LoopKind::Hole
}

/// True if the loop's component is debris: too small to be an island (algorithms note A.4, relative to the rim edge).
pub(crate) fn is_debris(survey: &CellSurvey, component: u32) -> bool {
    let Some(c) = survey.components.get(component as usize) else { return false };
    c.triangles < 50 && c.area_m2 < 4.0 * survey.median_edge_m * survey.median_edge_m
}

/// How far a piece must float above a hole's rim to be no island, metres: a crown above a pond.
const HOVER_M: f64 = 2.0;

/// Greatest height of a hole's rim, metres; `None` without rim.
pub(crate) fn highest(survey: &CellSurvey, rim: impl Iterator<Item = u32>) -> Option<f64> {
    rim.map(|e| survey.from(e).z).reduce(f64::max)
}

/// True if all of a loop lies clearly above all of a hole's rim (algorithms note B.5). A hole without rim has no height to
/// float above.
pub(crate) fn hovers(survey: &CellSurvey, island: &LoopSurvey, rim_highest_m: Option<f64>) -> bool {
    let lowest = island.edges.iter().map(|&e| survey.from(e).z).fold(f64::INFINITY, f64::min);
    rim_highest_m.is_some_and(|highest| lowest > highest + HOVER_M)
}

/// The polygon of a loop in plan.
pub(crate) fn loop_polygon(survey: &CellSurvey, l: &LoopSurvey) -> Vec<DVec2> {
    l.edges.iter().map(|&e| survey.from(e).truncate()).collect()
}

/// The polygon of a hole in plan.
#[derive(Clone, Debug)]
pub(crate) struct HolePolygon {
    pub(crate) outline: Vec<DVec2>,
    pub(crate) area_m2: f64,
}

impl HolePolygon {
    pub(crate) fn new(outline: Vec<DVec2>) -> Self {
        let area_m2 = signed_area(&outline).abs();
        Self { outline, area_m2 }
    }

    fn bounds(&self) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        self.outline.iter().for_each(|p| bounds.add(p.extend(0.0)));
        bounds
    }
}

/// The polygons of all holes of a cell.
pub(crate) struct HolePolygons {
    pub(crate) list: Vec<HolePolygon>,
    boxes: BoxTree,
}

impl HolePolygons {
    pub(crate) fn new(list: Vec<HolePolygon>) -> Self {
        let boxes = BoxTree::new(list.iter().map(HolePolygon::bounds));
        Self { list, boxes }
    }

    /// The smallest polygon (by area) that `island` lies in. It may touch the polygon in vertices: the first of its
    /// vertices and edge middles that is not on the polygon decides.
    pub(crate) fn smallest_around(&self, island: &[DVec2]) -> Option<usize> {
        // Inside a polygon or on it, the first vertex lies in its box.
        let first = island.first()?.extend(0.0);
        let middles = (0..island.len()).map(|k| (island[k] + island[(k + 1) % island.len()]) / 2.0);
        let places: Vec<DVec2> = island.iter().copied().chain(middles).collect();
        let is_around = |k: &usize| {
            let polygon = &self.list[*k].outline;
            let decided = places.iter().map(|&p| contains(polygon, p)).find(|l| *l != Location::OnEdge);
            decided == Some(Location::Inside)
        };
        let near = self.boxes.touching(&Bounds { min: first, max: first });
        near.into_iter()
            .filter(is_around)
            .min_by(|&a, &b| self.list[a].area_m2.total_cmp(&self.list[b].area_m2).then(a.cmp(&b)))
    }
}
