//! Cuts inside a tile: its sub-blocks end on common axis-parallel planes and do not weld (algorithms note B.1, formats
//! note section 3). Their edges are no rims.

use crate::label::Label;
use crate::{BorderFit, CellSurvey};
use glam::DVec3;
use std::collections::BTreeMap;

/// A coordinate of this precision is "in a plane", metres.
const PLANE_M: f64 = 0.002;
/// Least number of edges in a plane that make it a cut.
const LEAST_EDGES: usize = 3;

/// One boundary edge in an axis-parallel plane.
struct PlanarEdge {
    edge: u32,
    from: DVec3,
    to: DVec3,
}

/// Relabels rim edges that lie on a cut inside the tile.
///
/// Steps: group rim edges by axis and plane; a group of at least three edges is a cut where edges of another group of
/// the same axis, or of the same plane, lie within `cut_gap_m` and the triangles behind lie on the other side.
pub(crate) fn mark_cuts(survey: &CellSurvey, fit: &BorderFit, labels: &mut [Label]) {
    let gap_m = cut_gap(survey, fit);
    for axis in 0..3 {
        let planes = planes_of(survey, labels, axis);
        let cuts: Vec<u32> = planes
            .iter()
            .flat_map(|(&key, edges)| facing_edges(survey, &planes, key, edges, axis, gap_m))
            .collect();
        for edge in cuts {
            labels[edge as usize] = Label::Cut;
        }
    }
}

/// How far the two sides of a cut lie apart at most: sub-blocks overrun their plane as tiles overrun their cell.
fn cut_gap(survey: &CellSurvey, fit: &BorderFit) -> f64 {
    (3.0 * fit.margin_m).max(0.4 * survey.median_edge_m)
}

/// How far two rim ends may lie apart to be joined over a cut.
pub(crate) fn bridge_reach(survey: &CellSurvey, fit: &BorderFit) -> f64 {
    (6.0 * fit.margin_m).max(survey.median_edge_m)
}

/// Rim edges by the plane they lie in.
fn planes_of(survey: &CellSurvey, labels: &[Label], axis: usize) -> BTreeMap<i64, Vec<PlanarEdge>> {
    let mut planes: BTreeMap<i64, Vec<PlanarEdge>> = BTreeMap::new();
    for edge in (0..labels.len() as u32).filter(|&e| labels[e as usize] == Label::Rim) {
        let (from, to) = (survey.from(edge), survey.to(edge));
        if (from[axis] - to[axis]).abs() <= PLANE_M {
            let key = (from[axis] / PLANE_M).round() as i64;
            planes.entry(key).or_default().push(PlanarEdge { edge, from, to });
        }
    }
    planes.retain(|_, edges| edges.len() >= LEAST_EDGES);
    planes
}

/// The edges of one plane that face edges of a plane within the gap: near in the other two axes, surface on the other
/// side.
fn facing_edges(
    survey: &CellSurvey,
    planes: &BTreeMap<i64, Vec<PlanarEdge>>,
    key: i64,
    edges: &[PlanarEdge],
    axis: usize,
    gap_m: f64,
) -> Vec<u32> {
    let reach = (gap_m / PLANE_M).ceil() as i64;
    let others: Vec<&PlanarEdge> =
        planes.range(key.saturating_sub(reach)..=key.saturating_add(reach)).flat_map(|p| p.1).collect();
    let side = |e: &PlanarEdge| {
        let apex = survey.boundary.edges[e.edge as usize].apex;
        (apex[axis] - e.from[axis]).signum()
    };
    let faces = |e: &PlanarEdge, o: &PlanarEdge| {
        let opposite = side(e) * side(o) < 0.0;
        let against = (e.to - e.from).dot(o.to - o.from) < 0.0;
        opposite && against && run_side_by_side(e, o, axis, gap_m.max(0.5 * survey.median_edge_m))
    };
    edges.iter().filter(|e| others.iter().any(|o| o.edge != e.edge && faces(e, o))).map(|e| e.edge).collect()
}

/// True if two edges run side by side within the plane: along their longer direction they share a quarter of the shorter
/// one, across it they lie within `slack_m`.
fn run_side_by_side(a: &PlanarEdge, b: &PlanarEdge, axis: usize, slack_m: f64) -> bool {
    let span = |e: &PlanarEdge, k: usize| (e.from[k].min(e.to[k]), e.from[k].max(e.to[k]));
    let length = |e: &PlanarEdge, k: usize| span(e, k).1 - span(e, k).0;
    let shared = |k: usize| span(a, k).1.min(span(b, k).1) - span(a, k).0.max(span(b, k).0);
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let (along, across) =
        if length(a, u) + length(b, u) >= length(a, v) + length(b, v) { (u, v) } else { (v, u) };
    shared(along) >= 0.25 * length(a, along).min(length(b, along)).max(PLANE_M) && shared(across) >= -slack_m
}
